// In which order a Cholesky factorisation eliminates its rows.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

/// Orders with little fill for the symmetric matrix A: its rows, first eliminated first. The same
/// for the same pattern.
/// Eigen's approximate minimum degree: soon done, and good for thin shapes.
std::vector<int> minimum_degree_order(const SparseRows& A);
/// METIS: takes ten times as long; on thick shapes the factor is half as large. Empty if the build
/// has no METIS, or if it fails.
std::vector<int> nested_dissection_order(const SparseRows& A);

}  // namespace skinfield
