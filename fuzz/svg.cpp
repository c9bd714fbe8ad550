#include "skinfield/io/svg.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_svg(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
