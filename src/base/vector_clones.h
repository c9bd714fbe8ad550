// Functions compiled for several vector widths; the processor's is chosen when the program starts,
// so that one binary is fast everywhere. Sanitizers do not support such functions.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SKINFIELD_VECTOR_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define SKINFIELD_VECTOR_CLONES
#endif
