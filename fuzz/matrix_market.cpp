#include "skinfield/io/matrix_file.h"

#include "fuzz.h"

static void read(std::string_view bytes) { skinfield::parse_matrix_market(bytes, "fuzz"); }
SKINFIELD_FUZZ(read)
