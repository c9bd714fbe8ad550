// Our own supernodal multifrontal Cholesky (Duff and Reid 1983; Liu 1992): made for many
// right-hand sides, which run in strips through one dense kernel.
#include "skinfield/base/parallel.h"
#include "solve/dense_kernel.h"
#include "solve/factor_backend.h"
#include "solve/supernodal_solve.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr double kLeastPivot = 1e-15;      // of the diagonal entry: less is rounding
constexpr std::ptrdiff_t kDepth = 256;     // rows of a strip that stay in the first cache
constexpr std::size_t kRowsPerTask = 128;  // of a front, where its work is shared out

/// Rows [begin, end) of F (stride s): F[i][j0..j0+width) -= sum_{k<K} F[i][k] F[j0+t][k].
void update_rows(double* F, int s, int begin, int end, int j0, int width, int K,
                 const double* packed) {
  double acc[kKernelRows * kStrip];
  for (int k0 = 0; k0 < K; k0 += kDepth) {
    const std::ptrdiff_t depth = std::min<std::ptrdiff_t>(kDepth, K - k0);
    for (int i = begin; i < end; i += kKernelRows) {
      const double* a[kKernelRows];
      const int rows = std::min(kKernelRows, end - i);
      for (int r = 0; r < kKernelRows; ++r) {
        a[r] = F + static_cast<std::ptrdiff_t>(i + std::min(r, rows - 1)) * s + k0;
      }
      multiply_strip(a, 1, depth, packed + static_cast<std::ptrdiff_t>(k0) * kStrip, acc);
      for (int r = 0; r < rows; ++r) {
        double* row = F + static_cast<std::ptrdiff_t>(i + r) * s + j0;
        const int limit = std::min(width, i + r - j0 + 1);  // the lower triangle
        for (int t = 0; t < limit; ++t) row[t] -= acc[r * kStrip + t];
      }
    }
  }
}

/// Transposes rows j0..j0+width of F's first K columns into a strip.
void pack(const double* F, int s, int j0, int width, int K, std::vector<double>& packed) {
  packed.assign(static_cast<std::size_t>(K) * kStrip, 0.0);
  for (int t = 0; t < width; ++t) {
    const double* row = F + static_cast<std::ptrdiff_t>(j0 + t) * s;
    for (int k = 0; k < K; ++k) packed[static_cast<std::size_t>(k * kStrip + t)] = row[k];
  }
}

class SupernodalFactor : public SparseFactor::Backend {
 public:
  void analyse(const SparseRows& A) override { structure_ = analyse_supernodes(A); }

  void factor(const SparseRows& A) override {
    L_.resize(structure_.values);
    std::vector<std::vector<double>> updates(structure_.nodes.size());
    const auto n = static_cast<std::size_t>(A.rows());
    parallel_for(structure_.subtrees.size(), 1, [&](std::size_t t) {
      std::vector<int> local(n);
      for (int k = structure_.begin[t]; k <= structure_.subtrees[t]; ++k) {
        eliminate(A, k, updates, local, false);
      }
    });
    std::vector<int> local(n);
    for (const int k : structure_.top) eliminate(A, k, updates, local, true);
  }

  void solve(RowMatrix& B) const override {
    ActiveRows all;
    all.columns = static_cast<int>(B.cols());
    for (Eigen::Index i = 0; i <= B.rows(); ++i) all.start.push_back(i * B.cols());
    all.column.resize(static_cast<std::size_t>(B.size()));
    for (std::size_t e = 0; e < all.column.size(); ++e) {
      all.column[e] = static_cast<int>(e % static_cast<std::size_t>(all.columns));
    }
    solve_supernodal(structure_, L_.data(), all, B.data());
  }

  void solve(const ActiveRows& active, Vector& values) const override {
    solve_supernodal(structure_, L_.data(), active, values.data());
  }

  std::int64_t nonzeros() const override {
    std::int64_t count = 0;
    for (const Supernode& node : structure_.nodes) {
      const std::int64_t w = node.width;
      count += w * (w + 1) / 2 + w * static_cast<std::int64_t>(node.rows.size());
    }
    return count;
  }

 private:
  /// Assembles, factors and stores one front; its Schur complement goes to updates[k].
  void eliminate(const SparseRows& A, int k, std::vector<std::vector<double>>& updates,
                 std::vector<int>& local, bool shared) {
    const Supernode& node = structure_.nodes[static_cast<std::size_t>(k)];
    const int s = node.size(), w = node.width;
    for (int j = 0; j < w; ++j) local[static_cast<std::size_t>(node.first + j)] = j;
    for (int r = w; r < s; ++r) {
      local[static_cast<std::size_t>(node.rows[static_cast<std::size_t>(r - w)])] = r;
    }
    std::vector<double> front(static_cast<std::size_t>(s) * static_cast<std::size_t>(s), 0.0);
    double* F = front.data();
    for (int j = 0; j < w; ++j) {
      const int old = structure_.old_of_new[static_cast<std::size_t>(node.first + j)];
      for (SparseRows::InnerIterator it(A, old); it; ++it) {
        const int row = structure_.new_of_old[static_cast<std::size_t>(it.col())];
        if (row < node.first + j) continue;
        F[static_cast<std::ptrdiff_t>(local[static_cast<std::size_t>(row)]) * s + j] = it.value();
      }
    }
    for (const int child : node.children) {
      std::vector<double>& U = updates[static_cast<std::size_t>(child)];
      const std::vector<int>& rows = structure_.nodes[static_cast<std::size_t>(child)].rows;
      const std::size_t r = rows.size();
      for (std::size_t i = 0; i < r; ++i) {
        double* to = F + static_cast<std::ptrdiff_t>(local[static_cast<std::size_t>(rows[i])]) * s;
        const double* from = U.data() + i * r;
        for (std::size_t j = 0; j <= i; ++j)
          to[local[static_cast<std::size_t>(rows[j])]] += from[j];
      }
      std::vector<double>().swap(U);
    }
    const Vector diagonal = pivots_before(A, node);
    factor_panel(F, s, w, node.first, diagonal, shared);
    complement(F, s, w, shared);
    double* panel = L_.data() + node.offset;
    for (int i = 0; i < s; ++i) {
      std::copy_n(F + static_cast<std::ptrdiff_t>(i) * s, w,
                  panel + static_cast<std::ptrdiff_t>(i) * w);
    }
    const auto r = static_cast<std::size_t>(s - w);
    if (r == 0) return;
    std::vector<double>& U = updates[static_cast<std::size_t>(k)];
    U.resize(r * r);
    for (std::size_t i = 0; i < r; ++i) {
      std::copy_n(F + (static_cast<std::size_t>(w) + i) * static_cast<std::size_t>(s) + w, i + 1,
                  U.data() + i * r);
    }
  }

  Vector pivots_before(const SparseRows& A, const Supernode& node) const {
    Vector diagonal(node.width);
    for (int j = 0; j < node.width; ++j) {
      const int old = structure_.old_of_new[static_cast<std::size_t>(node.first + j)];
      diagonal[j] = A.coeff(old, old);
    }
    return diagonal;
  }

  void factor_panel(double* F, int s, int w, int first, const Vector& diagonal, bool shared) const {
    std::vector<double> packed;
    for (int j0 = 0; j0 < w; j0 += kStrip) {
      const int width = std::min(kStrip, w - j0);
      pack(F, s, j0, width, j0, packed);
      const auto rows = [&](int begin, int end) {
        update_rows(F, s, begin, end, j0, width, j0, packed.data());
      };
      share(s - j0, shared, [&](int begin, int end) { rows(j0 + begin, j0 + end); });
      for (int j = j0; j < j0 + width; ++j) {
        double* row = F + static_cast<std::ptrdiff_t>(j) * s;
        for (int c = j0; c <= j; ++c) {
          const double* other = F + static_cast<std::ptrdiff_t>(c) * s;
          double sum = row[c];
          for (int t = j0; t < c; ++t) sum -= row[t] * other[t];
          if (c < j) {
            row[c] = sum / other[c];
          } else {
            if (!(sum > kLeastPivot * diagonal[j])) {
              throw_not_positive_definite(
                  structure_.old_of_new[static_cast<std::size_t>(first + j)]);
            }
            row[c] = std::sqrt(sum);
          }
        }
      }
      share(s - j0 - width, shared, [&](int begin, int end) {
        for (int i = j0 + width + begin; i < j0 + width + end; ++i) {
          double* row = F + static_cast<std::ptrdiff_t>(i) * s;
          for (int c = j0; c < j0 + width; ++c) {
            const double* other = F + static_cast<std::ptrdiff_t>(c) * s;
            double sum = row[c];
            for (int t = j0; t < c; ++t) sum -= row[t] * other[t];
            row[c] = sum / other[c];
          }
        }
      });
    }
  }

  /// The trailing block: F22 -= F21 F21'.
  static void complement(double* F, int s, int w, bool shared) {
    const int strips = (s - w + kStrip - 1) / kStrip;
    const auto strip = [&](int t) {
      std::vector<double> packed;
      const int j0 = w + t * kStrip, width = std::min(kStrip, s - j0);
      pack(F, s, j0, width, w, packed);
      update_rows(F, s, j0, s, j0, width, w, packed.data());
    };
    if (shared) {
      parallel_for(static_cast<std::size_t>(strips), 1,
                   [&](std::size_t t) { strip(static_cast<int>(t)); });
    } else {
      for (int t = 0; t < strips; ++t) strip(t);
    }
  }

  template <class Body>
  static void share(int rows, bool shared, const Body& body) {
    if (rows <= 0) return;
    if (!shared) return body(0, rows);
    parallel_blocks(static_cast<std::size_t>(rows), kRowsPerTask,
                    [&](std::size_t begin, std::size_t end) {
                      body(static_cast<int>(begin), static_cast<int>(end));
                    });
  }

  SupernodalStructure structure_;
  std::vector<double> L_;  ///< panels, row-major
};

}  // namespace

std::unique_ptr<SparseFactor::Backend> make_supernodal_factor() {
  return std::make_unique<SupernodalFactor>();
}

}  // namespace skinfield
