// From what a domain and the user give to a quadratic program over the nodes that handles reach:
// paint, locked columns, kept supports, a start. Shared by the bounded methods.
#pragma once

#include "methods/locks.h"
#include "methods/reached.h"
#include "skinfield/methods/bounded_biharmonic.h"

#include <vector>

namespace skinfield {

struct NodalConditions {
  const RowMatrix& start;
  const std::vector<int>& locked;
  const FixedRows& paint;
  const std::vector<std::vector<int>>& support;
};

class NodalProgram {
 public:
  /// @throws SolveError if no row is fixed, or sizes do not fit. `where` names the method.
  NodalProgram(const BoundedBiharmonicProblem& problem, const NodalConditions& conditions,
               const char* where);

  /// Whether any column is left to solve for; if not, the program is empty.
  bool open() const { return !locks_.open().empty(); }
  const std::vector<int>& unreached() const { return reached_.left_out; }
  /// All N rows from the open columns' weights, or from the locks alone if none is open. Zero at
  /// unreached nodes.
  RowMatrix weights(const RowMatrix& open) const;

  SimplexProblem program;  ///< over reached nodes and open columns
  RowMatrix start;         ///< the same part of the start, or empty

 private:
  void fill(const BoundedBiharmonicProblem& problem, const NodalConditions& conditions,
            const FixedRows& fixed);
  void fill_support(const std::vector<std::vector<int>>& support);

  Eigen::Index N_, columns_ = 0;
  Locks locks_;
  NodeSubset reached_;
  RowMatrix locked_;  ///< (n,m) the locked parts of rows
};

}  // namespace skinfield
