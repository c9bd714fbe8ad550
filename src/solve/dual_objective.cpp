#include "solve/dual_objective.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 256;
// Entries at zero would stay there: their derivative vanishes with x. In weight units.
constexpr double kLeastVariable = 0.1;

struct Sums {
  double quadratic = 0, linear = 0, violation = 0;
};

}  // namespace

DualObjective::DualObjective(const FreeRows& free, const FreeConstraints& constraints,
                             const ConstrainedInverse& inverse, double scale, bool upper)
    : free_(free), constraints_(constraints), inverse_(inverse), scale_(scale), upper_(upper) {
  R_ = free_.R;  // Q12 D, fixed rows and the linear term included
  Z0_ = constraints_.D;
  inverse_.apply(R_, Z0_);
  if (!free_.boxes()) {
    // Equation 14: R = Q12 D P_m + 1/m s 1'.
    const auto m = static_cast<double>(R_.cols());
    R_.colwise() += (free_.row_sum - R_.rowwise().sum()) / m;
  }
  base_ = free_.energy(R_, free_.gradient(R_));
  T_.resizeLike(R_);
  W_.resizeLike(R_);
}

/// T <- T P.
void DualObjective::centre(RowMatrix& T) const {
  if (free_.boxes()) return;
  parallel_for(static_cast<std::size_t>(T.rows()), kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    T.row(i).array() -= T.row(i).mean();
  });
}

double DualObjective::evaluate(const Vector& x, Vector& g) {
  const Eigen::Index m = R_.cols(), half = R_.size();
  V_.resizeLike(R_);
  parallel_for(static_cast<std::size_t>(R_.rows()), kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    T_.row(i) = scale_ * x.segment(i * m, m).array().square().matrix().transpose();
    if (upper_) {
      T_.row(i) -= scale_ * x.segment(half + i * m, m).array().square().matrix().transpose();
    }
    V_.row(i) = T_.row(i);
    if (!free_.boxes()) V_.row(i).array() -= V_.row(i).mean();
  });
  inverse_.apply(V_);
  const Sums sums = parallel_reduce(
      static_cast<std::size_t>(R_.rows()), kRowsPerBlock, Sums(),
      [&](std::size_t begin, std::size_t end) {
        Sums sum;
        for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
          W_.row(i) = R_.row(i) + V_.row(i);  // equations 15 and B4
          sum.quadratic += T_.row(i).dot(V_.row(i));
          sum.linear += T_.row(i).dot(R_.row(i));
          sum.violation += W_.row(i).cwiseMin(0).squaredNorm();
          // Equation 16: the gradient with respect to Y is W; the chain rule does the rest.
          const auto own = x.segment(i * m, m).transpose().array();
          g.segment(i * m, m) = (2 * scale_ * own * W_.row(i).array()).matrix().transpose();
          if (!upper_) continue;
          const auto other = x.segment(half + i * m, m).transpose().array();
          const Eigen::RowVectorXd room = free_.row_sum[i] - W_.row(i).array();
          sum.linear += free_.row_sum[i] * scale_ * other.square().sum();
          sum.violation += room.cwiseMin(0).squaredNorm();
          g.segment(half + i * m, m) = (2 * scale_ * other * room.array()).matrix().transpose();
        }
        return sum;
      },
      [](Sums a, const Sums& b) {
        a.quadratic += b.quadratic;
        a.linear += b.linear;
        a.violation += b.violation;
        return a;
      });
  quadratic_ = sums.quadratic;
  violation_ = std::sqrt(sums.violation);
  value_ = 0.5 * quadratic_ + sums.linear;
  return value_;
}

Vector DualObjective::cold() const {
  // Multipliers in proportion to how far the unconstrained weights leave their sets.
  Vector x(size());
  RowMatrix F;
  free_.project(R_, F);
  const Eigen::Index half = R_.size();
  for (Eigen::Index e = 0; e < half; ++e) {
    const double excess = F.data()[e] - R_.data()[e];
    x[e] = std::sqrt(std::max(0.0, excess)) + kLeastVariable;
    if (upper_) x[half + e] = std::sqrt(std::max(0.0, -excess)) + kLeastVariable;
  }
  return x;
}

Vector DualObjective::variables(const RowMatrix& W) const {
  Vector x(size());
  const RowMatrix G = free_.gradient(W);
  const Eigen::Index m = R_.cols(), half = R_.size();
  for (Eigen::Index i = 0; i < R_.rows(); ++i) {
    // Q W - R = v 1' + Y with Y >= 0: the least entry of a row is v (no multiplier where W > 0).
    const double v = free_.boxes() ? 0.0 : G.row(i).minCoeff();
    for (Eigen::Index j = 0; j < m; ++j) {
      const double t = (G(i, j) - v) / scale_;
      x[i * m + j] = std::sqrt(std::max(0.0, t)) + 0.1 * kLeastVariable;
      if (upper_) x[half + i * m + j] = std::sqrt(std::max(0.0, -t)) + 0.1 * kLeastVariable;
    }
  }
  return x;
}

double DualObjective::lower_bound(RowMatrix& L) const {
  L = free_.gradient(W_);
  if (constraints_.C.rows() == 0) return free_.lower_bound(W_, L);
  RowMatrix U = T_, Z;
  centre(U);
  inverse_.apply(U, Z);
  Z += Z0_;
  // <Q W - R, V> = <L, V> - <Z, D> for every V with C V = D.
  const RowMatrix CZ = constraints_.C.transpose() * Z;
  L += CZ;
  return free_.lower_bound(W_, L) + 0.5 * W_.cwiseProduct(CZ).sum() -
         Z.cwiseProduct(constraints_.D).sum();
}

}  // namespace skinfield
