#include "solve/anderson.h"

#include "skinfield/base/parallel.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace skinfield {
namespace {

constexpr std::size_t kEntriesPerBlock = 2048;  // a few of them stay in the first cache
constexpr double kGrowth = 1.5;      // a residual that grows by more makes the history worthless
constexpr double kTikhonov = 1e-10;  // of the Gram matrix's trace

template <class Body>
void for_blocks(Eigen::Index entries, const Body& body) {
  parallel_blocks(static_cast<std::size_t>(entries), kEntriesPerBlock,
                  [&](std::size_t begin, std::size_t end) {
                    body(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
                  });
}

/// Weighted inner products of each dF with the newest one and with F, and of F with itself.
struct Products {
  std::array<double, Anderson::kMemory> newest{}, residual{};
  double norm = 0;
};

}  // namespace

Vector remapped(const Vector& values, const std::vector<std::int64_t>& old) {
  Vector result(static_cast<Eigen::Index>(old.size()));
  parallel_for(old.size(), kEntriesPerBlock, [&](std::size_t e) {
    result[static_cast<Eigen::Index>(e)] = old[e] < 0 ? 0.0 : values[old[e]];
  });
  return result;
}

void Anderson::forget() {
  filled_ = next_ = 0;
  previous_S_.resize(0);
}

void Anderson::remap(const std::vector<std::int64_t>& old) {
  if (previous_S_.size() == 0) return;
  previous_S_ = remapped(previous_S_, old);
  previous_F_ = remapped(previous_F_, old);
  for (std::size_t a = 0; a < static_cast<std::size_t>(filled_); ++a) {
    dG_[a] = remapped(dG_[a], old);
    dF_[a] = remapped(dF_[a], old);
  }
}

void Anderson::advance(const Vector& weight, Vector& S, const Vector& F) {
  const bool history = previous_S_.size() == S.size() && S.size() > 0;
  const auto slot = static_cast<std::size_t>(next_);
  if (history) {
    dG_.resize(kMemory);
    dF_.resize(kMemory);
    if (gram_.size() == 0) gram_.setZero(kMemory, kMemory);
    dG_[slot].resize(S.size());
    dF_[slot].resize(S.size());
    filled_ = std::max(filled_, next_ + 1);
  }
  const int filled = filled_;
  const Products products = parallel_reduce(
      static_cast<std::size_t>(S.size()), kEntriesPerBlock, Products(),
      [&](std::size_t from, std::size_t to) {
        const auto at = static_cast<Eigen::Index>(from),
                   count = static_cast<Eigen::Index>(to - from);
        Products sum;
        const Vector f = F.segment(at, count).cwiseProduct(weight.segment(at, count));
        sum.norm = f.dot(F.segment(at, count));
        if (!history) return sum;
        dF_[slot].segment(at, count) = F.segment(at, count) - previous_F_.segment(at, count);
        dG_[slot].segment(at, count) =
            S.segment(at, count) - previous_S_.segment(at, count) + dF_[slot].segment(at, count);
        const Vector d = dF_[slot].segment(at, count).cwiseProduct(weight.segment(at, count));
        for (std::size_t a = 0; a < static_cast<std::size_t>(filled); ++a) {
          sum.newest[a] = dF_[a].segment(at, count).dot(d);
          sum.residual[a] = dF_[a].segment(at, count).dot(f);
        }
        return sum;
      },
      [](Products a, const Products& b) {
        for (std::size_t i = 0; i < kMemory; ++i) {
          a.newest[i] += b.newest[i];
          a.residual[i] += b.residual[i];
        }
        a.norm += b.norm;
        return a;
      });
  const double now = std::sqrt(products.norm);
  if (history) {
    if (now > kGrowth * previous_norm_) {
      filled_ = next_ = 0;
    } else {
      for (int a = 0; a < filled_; ++a) {
        gram_(a, next_) = gram_(next_, a) = products.newest[static_cast<std::size_t>(a)];
      }
      next_ = (next_ + 1) % kMemory;
    }
  }
  Vector gamma(filled_);
  for (int a = 0; a < filled_; ++a) gamma[a] = products.residual[static_cast<std::size_t>(a)];
  if (filled_ > 0) {
    Eigen::MatrixXd G = gram_.topLeftCorner(filled_, filled_);
    G.diagonal().array() += kTikhonov * G.trace() + 1e-300;
    gamma = G.ldlt().solve(gamma);
    if (!gamma.allFinite()) gamma.setZero();
  }
  previous_S_.resize(S.size());
  previous_F_.resize(S.size());
  previous_norm_ = now;
  for_blocks(S.size(), [&](Eigen::Index at, Eigen::Index count) {
    previous_S_.segment(at, count) = S.segment(at, count);
    previous_F_.segment(at, count) = F.segment(at, count);
    S.segment(at, count) += F.segment(at, count);
    for (int a = 0; a < filled_; ++a) {
      S.segment(at, count) -= gamma[a] * dG_[static_cast<std::size_t>(a)].segment(at, count);
    }
  });
}

}  // namespace skinfield
