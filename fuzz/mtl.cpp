#include "skinfield/io/obj.h"

#include "fuzz.h"

SKINFIELD_FUZZ(skinfield::parse_mtl)
