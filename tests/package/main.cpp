// Uses the geometry room through the installed package: a tetrahedron contains its centroid.
#include <skinfield/geometry/winding_number.h>

#include <cstdio>

int main() {
  skinfield::Points V(4, 3);
  V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  skinfield::Triangles F(4, 3);
  F << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  const skinfield::WindingNumber winding(V, F);
  const double inside = winding.at(skinfield::Vec3(0.25, 0.25, 0.25));
  std::printf("skinfield %s: winding number at the centroid %.6f\n", SKINFIELD_VERSION, inside);
  return inside > 0.99 ? 0 : 1;
}
