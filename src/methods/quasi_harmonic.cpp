#include "skinfield/methods/quasi_harmonic.h"

#include "domain/stage_clock.h"
#include "methods/handle_distance.h"
#include "methods/locks.h"
#include "methods/mesh_order.h"
#include "methods/quasi_harmonic_objective.h"
#include "methods/tensor_descent.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/methods/bounded_biharmonic.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace skinfield {
namespace {

constexpr const char* kWhere = "quasi-harmonic weights";
constexpr double kClearlyLess = 0.8;  // energy of one start over that of the other

void check(const QuasiHarmonicProblem& problem, const QuasiHarmonicOptions& options,
           Eigen::Index columns) {
  const Eigen::Index n = problem.V.rows();
  const auto refuse = [](const std::string& what) { throw SolveError(what, kWhere); };
  if (problem.T.rows() == 0 && problem.F.rows() == 0) refuse("the mesh has no elements");
  if (problem.M.size() != n) refuse("V and M differ in size");
  if (!(problem.M.minCoeff() > 0) || !problem.M.allFinite()) refuse("a mass is not positive");
  if (options.start.size() && (options.start.rows() != n || options.start.cols() != columns)) {
    refuse("the start has a wrong size");
  }
  if (!options.locked.empty() && options.start.size() == 0) refuse("locked columns need a start");
  for (const int j : options.locked) {
    if (j < 0 || j >= columns) refuse("locked column " + std::to_string(j) + " does not exist");
  }
  if (!(options.kappa > 0) || !(options.epsilon >= 0) || !(options.rate > 0) || options.round < 1 ||
      options.max_iterations < 0 || options.adam_steps < 0 || !(options.momentum >= 0) ||
      !(options.momentum < 1)) {
    refuse("an option is out of range");
  }
}

template <class Elements>
Points element_centres(const Points& V, const Elements& E) {
  Points centres = Points::Zero(E.rows(), 3);
  for (Eigen::Index i = 0; i < E.cols(); ++i) centres += V(E.col(i), Eigen::all);
  return centres / static_cast<double>(E.cols());
}

/// Squared distances to the nearest handle, blunted by the elements' own size (section 7.5).
template <class Elements>
Vector squared_distance(TensorStart start, const Points& V, const Elements& E, const Vector& M,
                        const AnisotropicStiffness& stiffness, const std::vector<int>& nodes) {
  Vector distance;
  if (start == TensorStart::inverse_square) {
    distance = straight_distance(element_centres(V, E), V, nodes);
  } else {
    const double mean = stiffness.volumes().mean();
    // A tetrahedron of volume v has edges of about 2 v^(1/3), a triangle of area a 1.5 a^(1/2).
    const double edge = stiffness.dimension() == 3 ? 2 * std::cbrt(mean) : 1.5 * std::sqrt(mean);
    const Vector nodal = heat_distance(stiffness, M, edge, nodes);
    distance.setZero(E.rows());
    for (Eigen::Index i = 0; i < E.cols(); ++i) {
      distance += nodal(E.col(i)) / static_cast<double>(E.cols());
    }
  }
  return distance.array().square() + stiffness.volumes().array().pow(2.0 / stiffness.dimension());
}

/// distance^-power, with mean 1: only ratios matter. Elements of no volume get whatever is
/// harmless.
Vector scale_by_distance(const Vector& square, int power) {
  Vector scale = square.unaryExpr(
      [power](double d) { return d > 0 ? std::pow(d, -0.5 * static_cast<double>(power)) : 0.0; });
  const double mean = scale.mean();
  for (double& s : scale) s = s > 0 && mean > 0 ? s / mean : 1;
  return scale;
}

/// The flux of a weight through shells around a handle is constant, so that its slope goes with
/// 1 / (shell area * tensor); which power of the distance makes that a bounded biharmonic weight's
/// depends on whether the handle is a face, a line or a point. The paper's 2 stays unless 1 is
/// clearly better.
void choose_start(QuasiHarmonicObjective& objective, const Vector& square,
                  const Eigen::MatrixXd& theta) {
  const auto energy = [&](int power) {
    objective.set_scale(scale_by_distance(square, power));
    return objective.evaluate(theta);
  };
  const double first = energy(1);
  if (first < kClearlyLess * energy(2)) objective.set_scale(scale_by_distance(square, 1));
}

/// The fixed rows of the open columns, each with sum 1. Rows of locked handles alone become free.
FixedRows open_rows(const FixedRows& fixed, const Locks& locks) {
  if (!locks.any()) return fixed;
  FixedRows result;
  RowMatrix rows(fixed.weights.rows(), static_cast<Eigen::Index>(locks.open().size()));
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    const auto to = static_cast<Eigen::Index>(result.node.size());
    for (std::size_t t = 0; t < locks.open().size(); ++t) {
      rows(to, static_cast<Eigen::Index>(t)) =
          fixed.weights(static_cast<Eigen::Index>(k), locks.open()[t]);
    }
    const double sum = rows.row(to).sum();
    if (!(sum > 0)) continue;
    rows.row(to) /= sum;
    result.node.push_back(fixed.node[k]);
  }
  result.weights = rows.topRows(static_cast<Eigen::Index>(result.node.size()));
  return result;
}

void describe_tensors(const AnisotropicStiffness& stiffness, const Eigen::MatrixXd& A,
                      QuasiHarmonicResult& result) {
  const int d = stiffness.dimension();
  result.direction.setZero(A.rows(), 3);
  result.condition.setOnes(A.rows());
  parallel_for(static_cast<std::size_t>(A.rows()), 1024, [&](std::size_t row) {
    const auto e = static_cast<Eigen::Index>(row);
    if (stiffness.volumes()[e] == 0) return;
    Eigen::Matrix3d one = Eigen::Matrix3d::Zero();
    Eigen::Index k = 0;
    for (int c = 0; c < d; ++c) {
      for (int r = c; r < d; ++r) one(r, c) = A(e, k++);
    }
    Vec3 local = Vec3::Zero();
    if (d == 3) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(one);
      local = eigen.eigenvectors().col(2);
      result.condition[e] = eigen.eigenvalues()[2] / eigen.eigenvalues()[0];
    } else {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(one.topLeftCorner<2, 2>());
      local.head<2>() = eigen.eigenvectors().col(1);
      result.condition[e] = eigen.eigenvalues()[1] / eigen.eigenvalues()[0];
    }
    result.direction.row(e) = (stiffness.frame(e) * local).transpose();
  });
}

/// @param problem with all fixed rows among its own. @param start the locked columns' values.
QuasiHarmonicResult solve(const QuasiHarmonicProblem& problem, const QuasiHarmonicOptions& options,
                          const RowMatrix& start, const Progress& progress) {
  const FixedRows& all = problem.fixed;
  const Eigen::Index columns = all.weights.cols(), n = problem.V.rows();
  const Locks locks(options.locked, columns);
  const FixedRows fixed = open_rows(all, locks);
  if (fixed.node.empty()) {
    throw SolveError("no row is fixed", kWhere, "give at least one open handle inside the shape");
  }
  RowMatrix kept;
  Vector share;
  if (locks.any()) {
    kept.resize(n, columns);
    for (Eigen::Index i = 0; i < n; ++i) kept.row(i) = locks.part(start, i);
    share = (1 - kept.rowwise().sum().array()).cwiseMax(0.0);
  }

  QuasiHarmonicResult result;
  StageClock clock(result.seconds);
  const bool solid = problem.T.rows() > 0;
  const AnisotropicStiffness stiffness = solid ? AnisotropicStiffness(problem.V, problem.T)
                                               : AnisotropicStiffness(problem.V, problem.F);
  TensorModel model;
  model.kappa = options.kappa;
  model.epsilon = options.epsilon;
  model.scale = Vector::Ones(stiffness.elements());
  QuasiHarmonicObjective objective(stiffness, problem.M, fixed, std::move(model), share,
                                   options.project);
  Eigen::MatrixXd theta = identity_parameters(stiffness.elements(), stiffness.dimension());
  if (options.start_tensors != TensorStart::identity) {
    const auto square = [&](const auto& E) {
      return squared_distance(options.start_tensors, problem.V, E, problem.M, stiffness,
                              fixed.node);
    };
    const Vector distance = solid ? square(problem.T) : square(problem.F);
    progress.check();
    if (options.start_tensors == TensorStart::heat) {
      choose_start(objective, distance, theta);
    } else {
      objective.set_scale(scale_by_distance(distance, 2));
    }
  }

  clock.lap("start");
  const double linear_at_start = objective.linear_seconds();
  TensorDescent descent = descend(objective, options, std::move(theta), progress);
  clock.lap("steps");
  result.seconds["linear"] = objective.linear_seconds() - linear_at_start;
  QuasiHarmonicObjective::State& best = descent.best;
  result.stats = descent.stats;
  result.history = std::move(descent.history);
  describe_tensors(stiffness, best.tensors, result);
  result.W = std::move(best.weights);
  result.unprojected = std::move(best.solved);
  result.stats.relative_gap = 1;
  result.stats.kkt_residual = std::numeric_limits<double>::quiet_NaN();
  result.unreached = objective.unreached();
  if (locks.any()) {
    RowMatrix unprojected = kept;
    for (std::size_t t = 0; t < locks.open().size(); ++t) {
      kept.col(locks.open()[t]) = result.W.col(static_cast<Eigen::Index>(t));
      unprojected.col(locks.open()[t]) = result.unprojected.col(static_cast<Eigen::Index>(t));
    }
    result.W = std::move(kept);
    result.unprojected = std::move(unprojected);
    for (const int v : result.unreached) result.W.row(v).setZero();
  }
  return result;
}

RowMatrix rows_back(const RowMatrix& ordered, const std::vector<int>& node) {
  RowMatrix rows(ordered.rows(), ordered.cols());
  rows(node, Eigen::all) = ordered;
  return rows;
}

FixedRows reordered(const FixedRows& fixed, const std::vector<int>& node_place) {
  std::vector<std::pair<int, int>> rows;  // new node, row
  for (const int v : fixed.node) {
    rows.emplace_back(node_place[static_cast<std::size_t>(v)], static_cast<int>(rows.size()));
  }
  std::sort(rows.begin(), rows.end());
  FixedRows result;
  result.weights.resize(fixed.weights.rows(), fixed.weights.cols());
  for (const auto& [node, row] : rows) {
    result.weights.row(static_cast<Eigen::Index>(result.node.size())) = fixed.weights.row(row);
    result.node.push_back(node);
  }
  return result;
}

}  // namespace

QuasiHarmonicResult quasi_harmonic(const QuasiHarmonicProblem& problem,
                                   const QuasiHarmonicOptions& options, const Progress& progress) {
  const FixedRows all = merge(problem.fixed, options.paint);
  check(problem, options, all.weights.cols());
  const Eigen::Index n = problem.V.rows();
  const bool solid = problem.T.rows() > 0;
  const MeshOrder order = solid ? breadth_first(problem.T, n) : breadth_first(problem.F, n);
  const auto place = [&order](std::int32_t v) {
    return order.node_place[static_cast<std::size_t>(v)];
  };
  const Points V = problem.V(order.node, Eigen::all);
  const Vector M = problem.M(order.node);
  const FixedRows fixed = reordered(all, order.node_place);
  Tetrahedra T;
  Triangles F;
  if (solid) {
    T = problem.T(order.element, Eigen::all);
    T = T.unaryExpr(place).eval();
  } else {
    F = problem.F(order.element, Eigen::all);
    F = F.unaryExpr(place).eval();
  }
  RowMatrix start;
  if (options.start.size() > 0) start = options.start(order.node, Eigen::all);
  QuasiHarmonicResult result = solve({V, T, F, M, fixed}, options, start, progress);
  result.W = rows_back(result.W, order.node);
  result.unprojected = rows_back(result.unprojected, order.node);
  for (int& v : result.unreached) v = order.node[static_cast<std::size_t>(v)];
  std::sort(result.unreached.begin(), result.unreached.end());
  Points direction(result.direction.rows(), 3);
  Vector condition(result.condition.size());
  direction(order.element, Eigen::all) = result.direction;
  condition(order.element) = result.condition;
  result.direction = std::move(direction);
  result.condition = std::move(condition);
  return result;
}

}  // namespace skinfield
