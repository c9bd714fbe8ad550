#include "skinfield/io/gmsh.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_gmsh(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
