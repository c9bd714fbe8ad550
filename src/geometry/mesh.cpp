#include "skinfield/geometry/mesh.h"
namespace skinfield {}
