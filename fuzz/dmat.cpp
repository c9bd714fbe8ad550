#include "skinfield/io/weights_file.h"

#include "fuzz.h"

static void read(std::string_view bytes) { skinfield::parse_weights(bytes, ".dmat", "fuzz"); }
SKINFIELD_FUZZ(read)
