#include "skinfield/io/stl.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_stl(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
