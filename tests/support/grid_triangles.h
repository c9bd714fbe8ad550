// A planar grid of triangles made in code; right triangles, so that the cotangent stiffness is an
// M-matrix.
#pragma once

#include "skinfield/geometry/mesh.h"

namespace skinfield_test {

/// nx x ny cells of side `size`; vertex (i,j) is number i*(ny+1)+j.
inline skinfield::Mesh grid_triangles(int nx, int ny, double size = 1.0) {
  skinfield::Mesh mesh;
  mesh.V.resize((nx + 1) * (ny + 1), 3);
  mesh.F.resize(2 * nx * ny, 3);
  Eigen::Index f = 0;
  for (int i = 0; i <= nx; ++i) {
    for (int j = 0; j <= ny; ++j) {
      const int v = i * (ny + 1) + j;
      mesh.V.row(v) << size * i, size * j, 0;
      if (i == nx || j == ny) continue;
      mesh.F.row(f++) << v, v + ny + 1, v + ny + 2;
      mesh.F.row(f++) << v, v + ny + 2, v + 1;
    }
  }
  return mesh;
}

}  // namespace skinfield_test
