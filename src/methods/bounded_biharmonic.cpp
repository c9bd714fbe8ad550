#include "skinfield/methods/bounded_biharmonic.h"

#include "methods/locks.h"
#include "methods/reached.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/biharmonic.h"

#include <algorithm>
#include <string>

namespace skinfield {
namespace {

constexpr const char* kWhere = "bounded biharmonic weights";

void check(const BoundedBiharmonicProblem& problem, const BoundedBiharmonicOptions& options,
           Eigen::Index columns) {
  const Eigen::Index n = problem.K.rows();
  const auto refuse = [](const std::string& what) { throw SolveError(what, kWhere); };
  if (problem.K.cols() != n || problem.M.size() != n) refuse("K and M differ in size");
  if (options.start.size() && (options.start.rows() != n || options.start.cols() != columns)) {
    refuse("the start has a wrong size");
  }
  if (!options.support.empty() && static_cast<Eigen::Index>(options.support.size()) != n) {
    refuse("the support has a wrong size");
  }
  if (!options.locked.empty() && options.start.size() == 0) refuse("locked columns need a start");
  for (const int j : options.locked) {
    if (j < 0 || j >= columns) refuse("locked column " + std::to_string(j) + " does not exist");
  }
}

}  // namespace

FixedRows merge(const FixedRows& under, const FixedRows& over) {
  FixedRows both;
  const Eigen::Index columns = std::max(under.weights.cols(), over.weights.cols());
  std::vector<Eigen::RowVectorXd> rows;
  std::size_t a = 0, b = 0;
  while (a < under.node.size() || b < over.node.size()) {
    const bool take_over =
        b < over.node.size() && (a == under.node.size() || over.node[b] <= under.node[a]);
    if (take_over) {
      if (a < under.node.size() && under.node[a] == over.node[b]) ++a;
      both.node.push_back(over.node[b]);
      rows.push_back(over.weights.row(static_cast<Eigen::Index>(b++)));
    } else {
      both.node.push_back(under.node[a]);
      rows.push_back(under.weights.row(static_cast<Eigen::Index>(a++)));
    }
  }
  both.weights.resize(static_cast<Eigen::Index>(rows.size()), columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    both.weights.row(static_cast<Eigen::Index>(i)) = rows[i];
  }
  return both;
}

BoundedBiharmonicResult bounded_biharmonic(const BoundedBiharmonicProblem& problem,
                                           const BoundedBiharmonicOptions& options,
                                           const Progress& progress) {
  const FixedRows fixed = merge(problem.fixed, options.paint);
  const Eigen::Index columns = fixed.weights.cols();
  check(problem, options, columns);
  if (fixed.node.empty()) {
    throw SolveError("no row is fixed", kWhere, "give at least one handle inside the shape");
  }
  const Locks locks(options.locked, columns);

  BoundedBiharmonicResult result;
  const NodeSubset reached = reached_nodes(problem.K, fixed.node);
  const std::vector<int>& node = reached.node;
  result.unreached = reached.left_out;

  const auto n = static_cast<Eigen::Index>(node.size());
  const auto open = static_cast<Eigen::Index>(locks.open().size());
  RowMatrix kept = RowMatrix::Zero(n, columns);
  result.W = RowMatrix::Zero(problem.K.rows(), columns);
  if (open > 0) {
    SimplexProblem program;
    program.K = result.unreached.empty() ? problem.K : restrict_to(problem.K, reached);
    program.M.resize(n);
    program.columns = static_cast<int>(open);
    SimplexOptions simplex;
    simplex.tolerance = options.tolerance;
    simplex.max_iterations = options.max_iterations;
    simplex.time_limit_s = options.time_limit_s;
    if (options.start.size()) simplex.start.resize(n, open);
    if (locks.any()) program.row_sum.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int v = node[static_cast<std::size_t>(i)];
      program.M[i] = problem.M[v];
      if (options.start.size()) {
        for (Eigen::Index t = 0; t < open; ++t) {
          simplex.start(i, t) = options.start(v, locks.open()[static_cast<std::size_t>(t)]);
        }
      }
      if (locks.any()) {
        kept.row(i) = locks.part(options.start, v);
        program.row_sum[i] = std::max(0.0, 1 - kept.row(i).sum());
      }
    }
    program.fixed.weights.resize(static_cast<Eigen::Index>(fixed.node.size()), open);
    for (std::size_t k = 0; k < fixed.node.size(); ++k) {
      const int v = fixed.node[k];
      const int i = reached.position[static_cast<std::size_t>(v)];
      const auto row = static_cast<Eigen::Index>(k);
      program.fixed.node.push_back(i);
      if (locks.any()) {
        program.fixed.weights.row(row) =
            locks.rest(fixed.weights.row(row), options.start, v, program.row_sum[i]);
      } else {
        program.fixed.weights.row(row) = fixed.weights.row(row);
      }
    }
    if (!options.support.empty()) {
      std::vector<int> number(static_cast<std::size_t>(columns), -1);
      for (std::size_t t = 0; t < locks.open().size(); ++t) {
        number[static_cast<std::size_t>(locks.open()[t])] = static_cast<int>(t);
      }
      program.support.resize(node.size());
      for (std::size_t i = 0; i < node.size(); ++i) {
        auto& list = program.support[i];
        for (const int j : options.support[static_cast<std::size_t>(node[i])]) {
          if (number[static_cast<std::size_t>(j)] >= 0) {
            list.push_back(number[static_cast<std::size_t>(j)]);
          }
        }
        // Locked columns may have taken the whole list, but what they leave must go somewhere.
        if (list.empty()) {
          for (int t = 0; t < open; ++t) list.push_back(t);
        }
      }
    }
    program.Q = biharmonic(program.K, program.M);
    if (!options.penalties_from_stiffness) program.K.resize(0, 0);
    SimplexSolution solution = solve_simplex_qp(program, simplex, progress);
    result.stats = solution.stats;
    for (Eigen::Index t = 0; t < open; ++t) {
      kept.col(locks.open()[static_cast<std::size_t>(t)]) = solution.W.col(t);
    }
  } else {
    for (Eigen::Index i = 0; i < n; ++i) {
      kept.row(i) = locks.part(options.start, node[static_cast<std::size_t>(i)]);
      if (!(kept.row(i).sum() > 0)) kept.row(i).setOnes();
      kept.row(i) /= kept.row(i).sum();
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    result.W.row(node[static_cast<std::size_t>(i)]) = kept.row(i);
  }
  return result;
}

}  // namespace skinfield
