#include "skinfield/io/obj.h"

#include "fuzz.h"

static void read(std::string_view bytes) {
  skinfield::asset_from(skinfield::parse_obj(bytes, "fuzz"), "fuzz");
}
SKINFIELD_FUZZ(read)
