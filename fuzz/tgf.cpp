#include "skinfield/io/tgf.h"

#include "fuzz.h"

static void read(std::string_view bytes) { skinfield::parse_tgf(bytes, "fuzz"); }
SKINFIELD_FUZZ(read)
