#include "skinfield/io/medit.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_medit(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
