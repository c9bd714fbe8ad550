#include "methods/nodal_program.h"

#include "skinfield/base/error.h"
#include "skinfield/operators/biharmonic.h"

#include <algorithm>
#include <string>

namespace skinfield {
namespace {

void check(const BoundedBiharmonicProblem& problem, const NodalConditions& conditions,
           const FixedRows& fixed, const char* where) {
  const Eigen::Index n = problem.K.rows(), columns = fixed.weights.cols();
  const auto refuse = [where](const std::string& what) { throw SolveError(what, where); };
  if (problem.K.cols() != n || problem.M.size() != n) refuse("K and M differ in size");
  const RowMatrix& start = conditions.start;
  if (start.size() && (start.rows() != n || start.cols() != columns)) {
    refuse("the start has a wrong size");
  }
  if (!conditions.support.empty() && static_cast<Eigen::Index>(conditions.support.size()) != n) {
    refuse("the support has a wrong size");
  }
  if (!conditions.locked.empty() && start.size() == 0) refuse("locked columns need a start");
  for (const int j : conditions.locked) {
    if (j < 0 || j >= columns) refuse("locked column " + std::to_string(j) + " does not exist");
  }
  if (fixed.node.empty()) {
    throw SolveError("no row is fixed", where, "give at least one handle inside the shape");
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

NodalProgram::NodalProgram(const BoundedBiharmonicProblem& problem,
                           const NodalConditions& conditions, const char* where)
    : N_(problem.K.rows()), locks_({}, 0) {
  const FixedRows fixed = merge(problem.fixed, conditions.paint);
  check(problem, conditions, fixed, where);
  columns_ = fixed.weights.cols();
  locks_ = Locks(conditions.locked, columns_);
  reached_ = reached_nodes(problem.K, fixed.node);
  const auto n = static_cast<Eigen::Index>(reached_.node.size());
  locked_ = RowMatrix::Zero(n, columns_);
  if (locks_.any()) {
    for (Eigen::Index i = 0; i < n; ++i) {
      locked_.row(i) = locks_.part(conditions.start, reached_.node[static_cast<std::size_t>(i)]);
    }
  }
  if (open()) fill(problem, conditions, fixed);
}

void NodalProgram::fill(const BoundedBiharmonicProblem& problem, const NodalConditions& conditions,
                        const FixedRows& fixed) {
  const auto n = static_cast<Eigen::Index>(reached_.node.size());
  const auto open = static_cast<Eigen::Index>(locks_.open().size());
  program.K = unreached().empty() ? problem.K : restrict_to(problem.K, reached_);
  program.M.resize(n);
  program.columns = static_cast<int>(open);
  if (conditions.start.size()) start.resize(n, open);
  if (locks_.any()) program.row_sum.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int v = reached_.node[static_cast<std::size_t>(i)];
    program.M[i] = problem.M[v];
    if (conditions.start.size()) {
      for (Eigen::Index t = 0; t < open; ++t) {
        start(i, t) = conditions.start(v, locks_.open()[static_cast<std::size_t>(t)]);
      }
    }
    if (locks_.any()) program.row_sum[i] = std::max(0.0, 1 - locked_.row(i).sum());
  }
  program.fixed.weights.resize(static_cast<Eigen::Index>(fixed.node.size()), open);
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    const int v = fixed.node[k];
    const int i = reached_.position[static_cast<std::size_t>(v)];
    const auto row = static_cast<Eigen::Index>(k);
    program.fixed.node.push_back(i);
    if (locks_.any()) {
      program.fixed.weights.row(row) =
          locks_.rest(fixed.weights.row(row), conditions.start, v, program.row_sum[i]);
    } else {
      program.fixed.weights.row(row) = fixed.weights.row(row);
    }
  }
  if (!conditions.support.empty()) fill_support(conditions.support);
  program.Q = biharmonic(program.K, program.M);
}

void NodalProgram::fill_support(const std::vector<std::vector<int>>& support) {
  std::vector<int> number(static_cast<std::size_t>(columns_), -1);
  for (std::size_t t = 0; t < locks_.open().size(); ++t) {
    number[static_cast<std::size_t>(locks_.open()[t])] = static_cast<int>(t);
  }
  program.support.resize(reached_.node.size());
  for (std::size_t i = 0; i < reached_.node.size(); ++i) {
    auto& list = program.support[i];
    for (const int j : support[static_cast<std::size_t>(reached_.node[i])]) {
      if (number[static_cast<std::size_t>(j)] >= 0) {
        list.push_back(number[static_cast<std::size_t>(j)]);
      }
    }
    // Locked columns may have taken the whole list, but what they leave must go somewhere.
    if (list.empty()) {
      for (int t = 0; t < program.columns; ++t) list.push_back(t);
    }
  }
}

RowMatrix NodalProgram::weights(const RowMatrix& open_columns) const {
  RowMatrix W = RowMatrix::Zero(N_, columns_);
  for (Eigen::Index i = 0; i < locked_.rows(); ++i) {
    auto row = W.row(reached_.node[static_cast<std::size_t>(i)]);
    row = locked_.row(i);
    for (std::size_t t = 0; t < locks_.open().size(); ++t) {
      row[locks_.open()[t]] = open_columns(i, static_cast<Eigen::Index>(t));
    }
    if (open()) continue;
    if (!(row.sum() > 0)) row.setOnes();
    row /= row.sum();
  }
  return W;
}

}  // namespace skinfield
