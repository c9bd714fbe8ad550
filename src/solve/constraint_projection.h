// Weights that lie in their rows' sets and satisfy linear constraints.
#pragma once

#include "solve/dual_objective.h"

#include <Eigen/SparseCholesky>

namespace skinfield {

class ConstraintProjection {
 public:
  ConstraintProjection(const FreeRows& free, const FreeConstraints& constraints);

  /// Moves W to the nearest point of both sets (Boyle and Dykstra 1986), a fixed number of rounds
  /// at most; the last step is the rows' projection, which therefore holds exactly.
  void project(RowMatrix& W) const;
  /// Largest entry of |C W - D|.
  double residual(const RowMatrix& W) const;

 private:
  const FreeRows& free_;
  const FreeConstraints& constraints_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> gram_;  ///< of C C'
};

}  // namespace skinfield
