// The few matrix types that every room shares.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>

#include <cstdint>

namespace skinfield {

using Vec3 = Eigen::Vector3d;
using Box3 = Eigen::Matrix<double, 2, 3>;  ///< row 0: lower corner, row 1: upper corner

/// (n,3) positions or directions, one a row.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// (f,3) 0-based vertex indices.
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// (e,2) 0-based vertex indices.
using Segments = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor>;
/// (t,4) 0-based vertex indices.
using Tetrahedra = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// Dense rows: weights (n,m), right-hand sides (n,m).
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;
/// Compressed rows with 32-bit indices: stiffness K (N,N), interpolation P (n,N).
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;

}  // namespace skinfield
