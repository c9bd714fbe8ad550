// The stiffness of an anisotropic Laplacian, refilled in place, and its derivative.
#pragma once

#include "skinfield/base/types.h"

#include <cstdint>
#include <vector>

namespace skinfield {

/// K(A) = sum over elements e of vol_e G_e' A_e G_e, with G_e the gradients of the corners' hat
/// functions and A_e a symmetric tensor (Wang and Solomon 2021, "Fast quasi-harmonic weights for
/// geometric data interpolation", section 5.1, where the volume is part of A). Pattern, gradients
/// and the way from elements to entries are found once; after that, refilling K and contracting its
/// derivative take a few passes over the elements. Parallel, deterministic.
///
/// Tensors are matrices with a row an element and a column a coefficient, in the order of equation
/// 15: a00 a10 a20 a11 a21 a22 on tetrahedra, in the coordinates of V; a00 a10 a11 on triangles, in
/// the two tangents of frame(). Elements that stiffness.h takes for degenerate add nothing.
class AnisotropicStiffness {
 public:
  AnisotropicStiffness(const Points& V, const Tetrahedra& T);
  AnisotropicStiffness(const Points& V, const Triangles& F);

  int dimension() const { return dimension_; }  ///< 3 on tetrahedra, 2 on triangles
  int coefficients() const { return dimension_ * (dimension_ + 1) / 2; }
  Eigen::Index elements() const { return volume_.size(); }
  const Vector& volumes() const { return volume_; }
  /// Orthonormal columns: the axes that a tensor's coefficients refer to; on a triangle the last is
  /// its normal. Triangles in a plane z = const have the axes of the coordinates.
  const Eigen::Matrix3d& frame(Eigen::Index e) const;

  /// K for A = identity: the cotangent stiffness. Every K has its pattern: both triangles and every
  /// diagonal entry stored, K 1 = 0 up to the rounding of row sums, symmetric to the last bit.
  const SparseRows& isotropic() const { return K_; }
  /// Writes K(A) into the values of K. A: (elements, coefficients). Precondition: K has the pattern
  /// of isotropic().
  void assemble(const Eigen::MatrixXd& A, SparseRows& K) const;
  /// D (elements, coefficients) becomes the derivative of tr(X' K(A) Y) by A's coefficients, an
  /// off-diagonal one standing for both of its places. X, Y: (n,m) nodal fields.
  void derivative(const RowMatrix& X, const RowMatrix& Y, Eigen::MatrixXd& D) const;
  /// The constant gradient of a nodal field x (n) in each element, in space.
  Points gradient(const Vector& x) const;
  /// sum over elements of vol_e G_e' q_e (n): minus the integrated divergence of a field q
  /// (elements,3) that is constant in each.
  Vector divergence(const Points& q) const;

 private:
  template <class Elements>
  void build(const Points& V, const Elements& E);
  void build_edges();
  void build_pattern(Eigen::Index nodes);

  int dimension_ = 0;
  Vector volume_;
  Eigen::MatrixXd G_;  ///< (elements, d d): gradients of corners 1 to d, corner after corner
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic> corner_;  ///< (elements, d + 1)
  std::vector<Eigen::Matrix3d> frame_;                                  ///< triangles only
  struct Edge {
    std::int32_t a, b;          ///< nodes, a < b
    std::int32_t upper, lower;  ///< where K's value array holds (a,b) and (b,a)
  };
  std::vector<Edge> edges_;  ///< ascending
  /// A slot is (pair of corners) * elements + element; of an edge: slot_[first_[e]] .. ascending.
  std::vector<std::int32_t> first_, slot_;
  std::vector<std::int32_t> edge_of_slot_;  ///< the number of edges for degenerate elements
  std::vector<std::int32_t> diagonal_;      ///< where K's value array holds (i,i)
  SparseRows K_;
};

}  // namespace skinfield
