// The biharmonic energy of the weights that a tensor field generates, and its derivative.
#pragma once

#include "methods/reached.h"
#include "methods/tensor_parameters.h"
#include "skinfield/operators/anisotropic_stiffness.h"
#include "skinfield/solve/simplex_qp.h"
#include "skinfield/solve/sparse_factor.h"

#include <utility>
#include <vector>

namespace skinfield {

/// Problem (16) of Wang and Solomon 2021 as a function of the parameters theta.
class QuasiHarmonicObjective {
 public:
  /// The nodes that are neither fixed nor out of reach of a fixed one are solved for.
  /// share: (N) what the rows are scaled to after the projection, or empty for 1.
  QuasiHarmonicObjective(const AnisotropicStiffness& stiffness, const Vector& M,
                         const FixedRows& fixed, TensorModel model, Vector share, bool project);

  /// Replaces the model's scale; evaluate() must follow.
  void set_scale(Vector scale) { model_.scale = std::move(scale); }

  /// 1/2 tr(P' K M^-1 K P) of the weights P that theta generates: one factorisation, one solve.
  /// @throws SolveError if the stiffness is not positive definite (theta not finite).
  double evaluate(const Eigen::MatrixXd& theta);
  /// Its derivative by theta at the parameters last evaluated: one more solve (section 5.3).
  void gradient(const Eigen::MatrixXd& theta, Eigen::MatrixXd& result);

  /// What evaluate() found.
  struct State {
    RowMatrix solved;   ///< (N,m) sums 1
    RowMatrix weights;  ///< (N,m) projected and scaled
    Eigen::MatrixXd tensors;
  };
  const State& state() const { return state_; }
  /// Hands the state out without a copy, for one of this objective's own or an empty one. After
  /// that only evaluate() may follow.
  void exchange(State& other);
  const std::vector<int>& unreached() const { return unreached_; }
  /// Wall seconds in numerical factorisations and back substitutions so far.
  double linear_seconds() const { return linear_seconds_; }

 private:
  void fill_system();
  void accept_solution();
  void solve();

  const AnisotropicStiffness& stiffness_;
  Vector inverse_mass_, share_;
  TensorModel model_;
  bool project_;
  std::vector<int> free_, unreached_;
  std::vector<std::int32_t> source_;  ///< which value of K each value of the free block is
  struct Link {
    int row, node;       ///< a free row, a fixed node
    std::int32_t value;  ///< of K
  };
  std::vector<Link> links_;
  SparseRows K_, free_K_;
  SparseRows isotropic_free_rows_;  ///< (free, N) of the isotropic stiffness
  SparseFactor factor_;
  double linear_seconds_ = 0;
  State state_;
  RowMatrix solution_;  ///< the free rows of a solve
  RowMatrix residual_;  ///< M^-1 K P
  RowMatrix adjoint_;   ///< kept for its memory; zero on fixed rows
};

}  // namespace skinfield
