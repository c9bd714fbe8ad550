#include "solve/anderson.h"

#include "skinfield/base/parallel.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <functional>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 512;
constexpr double kGrowth = 1.5;      // a residual that grows by more makes the history worthless
constexpr double kTikhonov = 1e-10;  // of the Gram matrix's trace

template <class Body>
void for_rows(Eigen::Index rows, const Body& body) {
  parallel_blocks(static_cast<std::size_t>(rows), kRowsPerBlock,
                  [&](std::size_t begin, std::size_t end) {
                    body(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
                  });
}

}  // namespace

double Anderson::dot(const RowMatrix& A, const RowMatrix& B) const {
  return parallel_reduce(
      static_cast<std::size_t>(A.rows()), kRowsPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
          sum += weight_[i] * A.row(i).dot(B.row(i));
        }
        return sum;
      },
      std::plus<>());
}

void Anderson::forget() {
  filled_ = next_ = 0;
  previous_S_.resize(0, 0);
}

void Anderson::set_weight(const Vector& weight) {
  weight_ = weight;
  forget();
}

void Anderson::advance(RowMatrix& S, const RowMatrix& F) {
  const double now = std::sqrt(dot(F, F));
  if (previous_S_.size() == S.size() && previous_S_.size() > 0) {
    if (now > kGrowth * previous_norm_) {
      filled_ = next_ = 0;
    } else {
      if (static_cast<int>(dS_.size()) < memory_) {
        dS_.resize(static_cast<std::size_t>(memory_));
        dF_.resize(static_cast<std::size_t>(memory_));
        gram_.setZero(memory_, memory_);
      }
      const auto slot = static_cast<std::size_t>(next_);
      dS_[slot].resizeLike(S);
      dF_[slot].resizeLike(F);
      for_rows(S.rows(), [&](Eigen::Index at, Eigen::Index count) {
        dS_[slot].middleRows(at, count) =
            S.middleRows(at, count) - previous_S_.middleRows(at, count);
        dF_[slot].middleRows(at, count) =
            F.middleRows(at, count) - previous_F_.middleRows(at, count);
      });
      filled_ = std::max(filled_, next_ + 1);
      for (int a = 0; a < filled_; ++a) {
        gram_(a, next_) = gram_(next_, a) = dot(dF_[static_cast<std::size_t>(a)], dF_[slot]);
      }
      next_ = (next_ + 1) % memory_;
    }
  }
  previous_S_ = S;
  previous_F_ = F;
  previous_norm_ = now;
  Vector gamma = Vector::Zero(filled_);
  if (filled_ > 0) {
    for (int a = 0; a < filled_; ++a) gamma[a] = dot(dF_[static_cast<std::size_t>(a)], F);
    Eigen::MatrixXd G = gram_.topLeftCorner(filled_, filled_);
    G.diagonal().array() += kTikhonov * G.trace() + 1e-300;
    gamma = G.ldlt().solve(gamma);
    if (!gamma.allFinite()) gamma.setZero();
  }
  for_rows(S.rows(), [&](Eigen::Index at, Eigen::Index count) {
    S.middleRows(at, count) += F.middleRows(at, count);
    for (int a = 0; a < filled_; ++a) {
      const auto slot = static_cast<std::size_t>(a);
      S.middleRows(at, count) -=
          gamma[a] * (dS_[slot].middleRows(at, count) + dF_[slot].middleRows(at, count));
    }
  });
}

}  // namespace skinfield
