#include "skinfield/io/ply.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_ply(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
