#include "skinfield/io/off.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_off(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
