// Reads what the tests need of MEDIT tet meshes and TGF skeletons (the io room is below solve).
#pragma once

#include "skinfield/geometry/mesh.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace skinfield_test {

/// Vertices and Tetrahedra of an ASCII .mesh file; false if the file is not such a one.
inline bool read_medit(const std::filesystem::path& path, skinfield::Mesh& mesh) {
  std::ifstream in(path);
  std::string word;
  while (in >> word) {
    long count = 0;
    if (word == "Vertices" && in >> count) {
      mesh.V.resize(count, 3);
      for (long i = 0; i < count; ++i) in >> mesh.V(i, 0) >> mesh.V(i, 1) >> mesh.V(i, 2) >> word;
    } else if (word == "Tetrahedra" && in >> count) {
      mesh.T.resize(count, 4);
      for (long i = 0; i < count; ++i) {
        for (int c = 0; c < 4; ++c) in >> mesh.T(i, c);
        in >> word;
      }
      mesh.T.array() -= 1;
    }
  }
  return mesh.V.rows() > 0 && mesh.T.rows() > 0;
}

/// The bone lines of a TGF file as segments.
inline std::vector<std::pair<skinfield::Vec3, skinfield::Vec3>> read_bones(
    const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<skinfield::Vec3> joints;
  std::vector<std::pair<skinfield::Vec3, skinfield::Vec3>> bones;
  bool edges = false;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    if (line.find('#') != std::string::npos) {
      edges = true;
    } else if (edges) {
      std::size_t a = 0, b = 0;
      if (words >> a >> b) bones.emplace_back(joints.at(a - 1), joints.at(b - 1));
    } else {
      int id = 0;
      skinfield::Vec3 p;
      if (words >> id >> p[0] >> p[1] >> p[2]) joints.push_back(p);
    }
  }
  return bones;
}

}  // namespace skinfield_test
