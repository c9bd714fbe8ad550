// The body with rods as handles, in its authors' convention.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/solve/simplex_qp.h"
#include "support/medit.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace skinfield_test {

struct Tibiman {
  skinfield::Mesh mesh;
  skinfield::Vector M;
  skinfield::FixedRows fixed;
};

inline Eigen::MatrixXd read_array(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string banner;
  std::getline(in, banner);
  Eigen::Index rows = 0, columns = 0;
  in >> rows >> columns;
  Eigen::MatrixXd A(rows, columns);
  for (double& x : A.reshaped()) in >> x;
  return A;
}

/// folder: that of tibiman.mesh, tibiman-B.mtx (1-based nodes), -BC.mtx (values), -mv.mtx (masses).
inline Tibiman tibiman(const std::filesystem::path& folder) {
  Tibiman result;
  read_medit(folder / "tibiman.mesh", result.mesh);
  result.M = read_array(folder / "tibiman-mv.mtx");
  const Eigen::MatrixXd B = read_array(folder / "tibiman-B.mtx");
  const Eigen::MatrixXd values = read_array(folder / "tibiman-BC.mtx");
  std::vector<std::pair<int, Eigen::Index>> order;
  for (Eigen::Index k = 0; k < B.size(); ++k) order.emplace_back(static_cast<int>(B(k)) - 1, k);
  std::sort(order.begin(), order.end());
  result.fixed.weights.resize(values.rows(), values.cols());
  for (std::size_t k = 0; k < order.size(); ++k) {
    result.fixed.node.push_back(order[k].first);
    result.fixed.weights.row(static_cast<Eigen::Index>(k)) = values.row(order[k].second);
  }
  return result;
}

}  // namespace skinfield_test
