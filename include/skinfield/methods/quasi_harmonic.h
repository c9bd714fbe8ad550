// Weights without local extrema that minimise the biharmonic energy among the solutions of
// anisotropic Laplace equations (Wang and Solomon 2021, "Fast quasi-harmonic weights for geometric
// data interpolation").
#pragma once

#include "skinfield/solve/simplex_qp.h"

#include <map>
#include <string>
#include <vector>

namespace skinfield {

/// Views, to be kept alive by the caller.
struct QuasiHarmonicProblem {
  const Points& V;
  const Tetrahedra& T;     ///< used if it has rows,
  const Triangles& F;      ///< else this
  const Vector& M;         ///< (N) > 0
  const FixedRows& fixed;  ///< (k,m): m is the number of columns
};

/// The tensors at the start: the identity (harmonic weights); divided by the squared straight
/// distance to the nearest fixed node; or divided by the squared distance inside the domain (heat
/// method), or that distance itself where it starts with clearly less energy. All in units of the
/// element's volume.
enum class TensorStart { identity, inverse_square, heat };

/// How the energy is brought down (section 6.1 and figure 2). restarted_adam is the paper's
/// customised Adam, which halves its rate and forgets its moments after every round; adam goes
/// without that; lbfgs has a memory of 10 and a line search. adam_lbfgs begins with the first and
/// goes on with the third, whose steps have no rate that runs out, as long as the maximum principle
/// holds: no weight is below -1e-4 before the projection.
enum class TensorOptimiser { adam_lbfgs, restarted_adam, adam, lbfgs };

struct QuasiHarmonicOptions {
  TensorStart start_tensors = TensorStart::heat;
  TensorOptimiser optimiser = TensorOptimiser::adam_lbfgs;
  int max_iterations = 80;  ///< steps; the paper takes 10 or 20 of the customised Adam
  int adam_steps = 24;      ///< how many of them are Adam's before L-BFGS goes on
  double rate = 0.1;        ///< of Adam, in the first round
  /// Adam's memory of the mean gradient (beta1). The customary 0.9 remembers ten steps, and a
  /// round has four.
  double momentum = 0.5;
  int round = 4;  ///< steps until Adam starts afresh, and until the tolerance is looked at
  /// Stops after a round that changed the energy by less than this share; 0: never.
  double tolerance = 1e-4;
  /// Projects to the simplex inside the objective. Without, weights can be mildly negative where
  /// the mesh is not Delaunay.
  bool project = true;
  double kappa = 0.2;       ///< bounds the tensors' condition by 1 + 2 / kappa
  double epsilon = 1e-4;    ///< least eigenvalue, in units of the tensors' scale
  double time_limit_s = 0;  ///< 0: none; else the best weights so far, status limit
  RowMatrix start;          ///< (N,m) the values of locked columns, or empty
  std::vector<int> locked;  ///< columns kept from `start`
  FixedRows paint;          ///< more fixed rows; they win over the problem's
};

struct QuasiHarmonicResult {
  RowMatrix W;                 ///< (N,m) rows on the simplex if projected; the best found
  RowMatrix unprojected;       ///< (N,m) the same before projection; sums 1 over the open columns
  std::vector<int> unreached;  ///< nodes that no element path joins to a fixed row: zero rows
  /// Energies are 1/2 tr(W' K M^-1 K W) over the columns not locked. The problem is not convex: no
  /// bound is known, so that lower_bound is 0, and kkt_residual (not measured) is not a number.
  SolveStats stats;
  std::vector<double> history;  ///< energies: [0] at the start, [k] after k steps
  /// Wall: `start` (symbolic factorisation, start of the tensors), `steps`, and what of these
  /// numerical factorisations and back substitutions take (`linear`).
  std::map<std::string, double> seconds;
  /// The tensors of W: unit eigenvectors of the largest eigenvalue (elements,3), and the largest
  /// eigenvalue over the smallest (section 7.4). Zero and 1 in degenerate elements.
  Points direction;
  Vector condition;
};

/// With locked columns the others minimise the same energy as (1 - locked sum) times quasi-harmonic
/// weights of the open handles alone: rows stay on the simplex, and it is those functions, before
/// the factor, that are free of extrema.
/// @throws SolveError if no row is fixed, sizes do not fit or options are out of range.
QuasiHarmonicResult quasi_harmonic(const QuasiHarmonicProblem& problem,
                                   const QuasiHarmonicOptions& options = {},
                                   const Progress& progress = {});

}  // namespace skinfield
