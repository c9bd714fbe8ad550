// A box of tetrahedra made in code, six a cell.
#pragma once

#include "skinfield/geometry/mesh.h"

namespace skinfield_test {

/// nx x ny x nz cells of side `size`; vertex (i,j,k) is number (i*(ny+1)+j)*(nz+1)+k.
inline skinfield::Mesh box_tets(int nx, int ny, int nz, double size = 1.0) {
  skinfield::Mesh mesh;
  mesh.V.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  const auto id = [&](int i, int j, int k) { return (i * (ny + 1) + j) * (nz + 1) + k; };
  for (int i = 0; i <= nx; ++i) {
    for (int j = 0; j <= ny; ++j) {
      for (int k = 0; k <= nz; ++k) {
        mesh.V.row(id(i, j, k)) << size * i, size * j, size * k;
      }
    }
  }
  // The six paths from corner 000 to corner 111 (Kuhn's subdivision), which fit between cells.
  constexpr int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  mesh.T.resize(6 * nx * ny * nz, 4);
  Eigen::Index t = 0;
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      for (int k = 0; k < nz; ++k) {
        for (const auto& path : paths) {
          int at[3] = {i, j, k};
          mesh.T(t, 0) = id(at[0], at[1], at[2]);
          for (int step = 0; step < 3; ++step) {
            ++at[path[step]];
            mesh.T(t, step + 1) = id(at[0], at[1], at[2]);
          }
          ++t;
        }
      }
    }
  }
  return mesh;
}

}  // namespace skinfield_test
