#include "skinfield/io/pose_file.h"

#include "fuzz.h"

static void read(std::string_view bytes) { skinfield::parse_pose_json(bytes, "fuzz"); }
SKINFIELD_FUZZ(read)
