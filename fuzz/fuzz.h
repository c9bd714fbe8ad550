// What all fuzz targets share: an input is read, or refused with an InputError; anything else
// (another exception, a crash, a sanitizer's finding, a timeout) is a bug.
#pragma once

#include "skinfield/base/error.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

/// Defines the target from a function of the bytes.
#define SKINFIELD_FUZZ(function)                                                      \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    try {                                                                             \
      function(std::string_view(reinterpret_cast<const char*>(data), size));          \
    } catch (const skinfield::InputError& error) {                                    \
      if (error.message().empty()) std::abort();                                      \
    }                                                                                 \
    return 0;                                                                         \
  }
