// Where weight functions live: nodes, fixed rows, an energy, and evaluation at any point.
#pragma once

#include "skinfield/operators/biharmonic.h"
#include "skinfield/rig/skeleton.h"
#include "skinfield/solve/simplex_qp.h"

#include <string>
#include <vector>

namespace skinfield {

/// How the weights of an evaluated point came about (counted in the report).
enum class Fill : unsigned char {
  none,       ///< the ordinary interpolation
  hidden,     ///< no node in view: nearest unblocked node's neighbourhood, or flood fill
  passenger,  ///< clothes and shells: carried by the nearest domain vertices
  handle,     ///< nearest visible handle
  nearest,    ///< nearest handle, visibility ignored
};

struct Interpolation {
  SparseRows P;            ///< (n,N) row-stochastic
  std::vector<Fill> fill;  ///< (n)
};

/// Positions are in the unit box.
class Domain {
 public:
  virtual ~Domain() = default;
  virtual const Points& nodes() const = 0;
  /// (N,N) symmetric positive semidefinite, K 1 = 0.
  virtual const SparseRows& stiffness() const = 0;
  /// (N) > 0
  virtual const Vector& mass() const = 0;
  /// Rows given by the handles: shared by k handles, 1/k each. Columns are handle indices.
  virtual const FixedRows& fixed() const = 0;
  /// P for (n,3) points; unit normals (n,3) help to look inward, or empty.
  virtual Interpolation at(const Points& X, const Points& normals) const = 0;
};

}  // namespace skinfield
