#include "skinfield/io/gltf.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::read_gltf_bytes(std::as_bytes(std::span(bytes.data(), bytes.size())), "fuzz");
}
SKINFIELD_FUZZ(read)
