// Our own supernodal multifrontal Cholesky (Duff and Reid 1983; Liu 1992): made for many
// right-hand sides, which run in strips through one dense kernel.
#include "base/large_array.h"
#include "skinfield/base/parallel.h"
#include "solve/dense_kernel.h"
#include "solve/factor_backend.h"
#include "solve/supernodal_solve.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <numeric>
#include <vector>

namespace skinfield {
namespace {

constexpr double kLeastPivot = 1e-15;     // of the diagonal entry: less is rounding
constexpr int kDepth = 256;               // rows of a strip that stay in the first cache
constexpr std::size_t kRowsPerTask = 64;  // of a front, where its work is shared out

using Buffer = LargeArray<double>;

/// What one elimination after the other uses.
struct Workspace {
  Workspace(std::size_t n, std::size_t largest_front) : local(n) {
    front.resize(largest_front * largest_front);
  }
  std::vector<int> local;  ///< row of the front of a row of the matrix
  Buffer front, packed;
};

/// What solves need beside the factor, kept for the next ones; several may run at once.
class Spaces {
 public:
  LargeArray<double> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return {};
    LargeArray<double> space = std::move(free_.back());
    free_.pop_back();
    return space;
  }
  void give(LargeArray<double> space) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(space));
  }
  void clear() { free_.clear(); }

 private:
  std::mutex mutex_;
  std::vector<LargeArray<double>> free_;
};

/// The lower triangle of a dense matrix of which the first `width` columns are eliminated.
struct Front {
  double* F;
  std::ptrdiff_t size;
  int width;
  bool shared;  ///< is the work spread over the threads?

  double* row(int i) const { return F + i * size; }

  /// body(begin, end) for all rows from `first` on.
  template <class Body>
  void rows(int first, const Body& body) const {
    const int end = static_cast<int>(size);
    if (first >= end) return;
    if (!shared) return body(first, end);
    parallel_blocks(static_cast<std::size_t>(end - first), kRowsPerTask,
                    [&](std::size_t from, std::size_t to) {
                      body(first + static_cast<int>(from), first + static_cast<int>(to));
                    });
  }
};

/// Transposes rows j0 .. j0+width of the first K columns into a strip.
const double* pack(const Front& front, int j0, int width, int K, Buffer& packed) {
  double* to = packed.resize(static_cast<std::size_t>(K) * kStrip);
  for (int t = 0; t < kStrip; ++t) {
    if (t < width) {
      const double* from = front.row(j0 + t);
      for (int k = 0; k < K; ++k) to[k * kStrip + t] = from[k];
    } else {
      for (int k = 0; k < K; ++k) to[k * kStrip + t] = 0;
    }
  }
  return to;
}

/// A strip is nearly always full, and a copy of constant size costs no call.
void copy_strip(const double* from, int width, double* to) {
  if (width == kStrip) {
    std::memcpy(to, from, kStrip * sizeof(double));
  } else {
    std::copy_n(from, width, to);
  }
}

/// acc := rows i .. i+count of the first K columns, times the strip.
void multiply_rows(const Front& front, int i, int count, int K, const double* packed, double* acc) {
  const double* a[kKernelRows];
  for (int r = 0; r < kKernelRows; ++r) a[r] = front.row(i + std::min(r, count - 1));
  multiply_strip(a, 1, std::min(K, kDepth), packed, acc);
  double more[kKernelRows * kStrip];
  for (int k0 = kDepth; k0 < K; k0 += kDepth) {
    for (const double*& row : a) row += kDepth;
    multiply_strip(a, 1, std::min(K - k0, kDepth), packed + k0 * kStrip, more);
    for (int e = 0; e < kKernelRows * kStrip; ++e) acc[e] += more[e];
  }
}

/// |L_ij| <= sqrt(A_ii), and no pivot is below kLeastPivot of its entry: far from float's ends.
bool fits_single(const SparseRows& A) {
  const Vector diagonal = A.diagonal();
  return diagonal.size() == 0 || (diagonal.maxCoeff() < 1e70 && diagonal.minCoeff() > 1e-50);
}

class SupernodalFactor : public SparseFactor::Backend {
 public:
  void analyse(const SparseRows& A) override { structure_ = analyse_supernodes(A); }

  void factor(const SparseRows& A, PanelStorage storage) override {
    storage_ = fits_single(A) ? storage : PanelStorage::full;
    spaces_.clear();
    // Kernels read past the last row.
    const std::size_t size = structure_.values + kKernelRows;
    if (single()) {
      full_.release();
      single_.resize(size);
    } else {
      single_.release();
      full_.resize(size);
    }
    std::vector<Buffer> updates(structure_.nodes.size());
    const auto n = static_cast<std::size_t>(A.rows());
    const auto larger = [&](std::size_t rows, int k) {
      return std::max(rows, static_cast<std::size_t>(node(k).size()));
    };
    parallel_for(structure_.subtrees.size(), 1, [&](std::size_t t) {
      std::size_t largest = 0;
      for (int k = structure_.begin[t]; k <= structure_.subtrees[t]; ++k) {
        largest = larger(largest, k);
      }
      Workspace space(n, largest);
      for (int k = structure_.begin[t]; k <= structure_.subtrees[t]; ++k) {
        eliminate(A, k, updates, space, false);
      }
    });
    Workspace space(
        n, std::accumulate(structure_.top.begin(), structure_.top.end(), std::size_t{0}, larger));
    for (const int k : structure_.top) eliminate(A, k, updates, space, true);
  }

  void solve(RowMatrix& B) const override {
    ActiveRows all;
    all.columns = static_cast<int>(B.cols());
    for (Eigen::Index i = 0; i <= B.rows(); ++i) all.start.push_back(i * B.cols());
    all.column.resize(static_cast<std::size_t>(B.size()));
    for (std::size_t e = 0; e < all.column.size(); ++e) {
      all.column[e] = static_cast<int>(e % static_cast<std::size_t>(all.columns));
    }
    solve_panels(all, B.data());
  }

  void solve(const ActiveRows& active, Vector& values) const override {
    solve_panels(active, values.data());
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
  bool single() const { return storage_ == PanelStorage::single; }

  void solve_panels(const ActiveRows& active, double* values) const {
    LargeArray<double> space = spaces_.take();
    single() ? solve_supernodal(structure_, single_.data(), active, values, space)
             : solve_supernodal(structure_, full_.data(), active, values, space);
    spaces_.give(std::move(space));
  }

  const Supernode& node(int k) const { return structure_.nodes[static_cast<std::size_t>(k)]; }

  /// Assembles, factors and stores one front; its Schur complement goes to updates[k].
  void eliminate(const SparseRows& A, int k, std::vector<Buffer>& updates, Workspace& space,
                 bool shared) {
    const Front front{space.front.data(), node(k).size(), node(k).width, shared};
    assemble(A, k, updates, space, front);
    factor_panel(A, node(k).first, front, space.packed);
    complement(front, space.packed);
    Buffer& update = updates[static_cast<std::size_t>(k)];
    single() ? store(k, front, single_, update) : store(k, front, full_, update);
  }

  void assemble(const SparseRows& A, int k, std::vector<Buffer>& updates, Workspace& space,
                const Front& front) const {
    const Supernode& own = node(k);
    const auto local = [&](int row) -> int& { return space.local[static_cast<std::size_t>(row)]; };
    for (int j = 0; j < own.width; ++j) local(own.first + j) = j;
    for (std::size_t r = 0; r < own.rows.size(); ++r) {
      local(own.rows[r]) = own.width + static_cast<int>(r);
    }
    front.rows(0, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) std::fill_n(front.row(i), i + 1, 0.0);
      std::vector<int> place;
      for (const int child : own.children) {
        const std::vector<int>& rows = node(child).rows;
        place.resize(rows.size());
        std::size_t count = 0;
        for (; count < rows.size() && local(rows[count]) < end; ++count) {
          place[count] = local(rows[count]);
        }
        auto i = static_cast<std::size_t>(
            std::lower_bound(place.begin(), place.begin() + static_cast<std::ptrdiff_t>(count),
                             begin) -
            place.begin());
        const double* from = updates[static_cast<std::size_t>(child)].data() + i * (i + 1) / 2;
        for (; i < count; from += ++i) {
          double* to = front.row(place[i]);
          for (std::size_t j = 0; j <= i; ++j) to[place[j]] += from[j];
        }
      }
    });
    for (const int child : own.children) updates[static_cast<std::size_t>(child)].release();
    for (int j = 0; j < own.width; ++j) {
      const int old = structure_.old_of_new[static_cast<std::size_t>(own.first + j)];
      for (SparseRows::InnerIterator it(A, old); it; ++it) {
        const int row = structure_.new_of_old[static_cast<std::size_t>(it.col())];
        if (row >= own.first + j) front.row(local(row))[j] += it.value();
      }
    }
  }

  /// Strip after strip: what the columns before it take away, its own triangle, the rows below.
  void factor_panel(const SparseRows& A, int first, const Front& front, Buffer& packed) const {
    for (int j0 = 0; j0 < front.width; j0 += kStrip) {
      const int width = std::min(kStrip, front.width - j0);
      const double* strip = pack(front, j0, width, j0, packed);
      StripFactor factor;
      factor_triangle(A, first, front, j0, width, strip, factor);
      front.rows(j0 + width, [&](int begin, int end) {
        double acc[kKernelRows * kStrip], rows[kKernelRows * kStrip] = {};
        for (int i = begin; i < end; i += kKernelRows) {
          const int count = std::min(kKernelRows, end - i);
          multiply_rows(front, i, count, j0, strip, acc);
          for (int r = 0; r < count; ++r) {
            copy_strip(front.row(i + r) + j0, width, rows + r * kStrip);
          }
          solve_strip(rows, acc, factor);
          for (int r = 0; r < count; ++r) {
            copy_strip(rows + r * kStrip, width, front.row(i + r) + j0);
          }
        }
      });
    }
  }

  void factor_triangle(const SparseRows& A, int first, const Front& front, int j0, int width,
                       const double* strip, StripFactor& factor) const {
    double triangle[kStrip * kStrip] = {}, least[kStrip] = {}, acc[kKernelRows * kStrip];
    for (int i = 0; i < width; i += kKernelRows) {
      const int count = std::min(kKernelRows, width - i);
      multiply_rows(front, j0 + i, count, j0, strip, acc);
      for (int r = 0; r < count; ++r) {
        const double* row = front.row(j0 + i + r) + j0;
        for (int t = 0; t <= i + r; ++t) {
          triangle[(i + r) * kStrip + t] = row[t] - acc[r * kStrip + t];
        }
      }
    }
    const auto old = [&](int c) {
      return structure_.old_of_new[static_cast<std::size_t>(first + j0 + c)];
    };
    for (int c = 0; c < width; ++c) least[c] = kLeastPivot * A.coeff(old(c), old(c));
    const int failed = factor_strip(triangle, width, least, factor);
    if (failed >= 0) throw_not_positive_definite(old(failed));
    for (int i = 0; i < width; ++i) {
      std::copy_n(triangle + i * kStrip, i + 1, front.row(j0 + i) + j0);
    }
  }

  /// The trailing block: F22 -= F21 F21'.
  static void complement(const Front& front, Buffer& packed) {
    const int size = static_cast<int>(front.size), w = front.width;
    const auto strip = [&](int t, Buffer& own) {
      const int j0 = w + t * kStrip, width = std::min(kStrip, size - j0);
      const double* columns = pack(front, j0, width, w, own);
      double acc[kKernelRows * kStrip];
      for (int i = j0; i < size; i += kKernelRows) {
        const int count = std::min(kKernelRows, size - i);
        multiply_rows(front, i, count, w, columns, acc);
        for (int r = 0; r < count; ++r) {
          double* row = front.row(i + r) + j0;
          const int limit = std::min(width, i + r - j0 + 1);  // the lower triangle
          if (limit == kStrip) {
            for (int c = 0; c < kStrip; ++c) row[c] -= acc[r * kStrip + c];
          } else {
            for (int c = 0; c < limit; ++c) row[c] -= acc[r * kStrip + c];
          }
        }
      }
    };
    const int strips = (size - w + kStrip - 1) / kStrip;
    if (!front.shared) {
      for (int t = 0; t < strips; ++t) strip(t, packed);
      return;
    }
    parallel_for(static_cast<std::size_t>(strips), 1, [&](std::size_t t) {
      Buffer own;
      strip(static_cast<int>(t), own);
    });
  }

  template <class Value>
  void store(int k, const Front& front, LargeArray<Value>& panels, Buffer& update) const {
    const auto w = static_cast<std::size_t>(front.width);
    const std::size_t below = node(k).rows.size();
    Value* panel = panels.data() + node(k).offset;
    double* U = update.resize(below * (below + 1) / 2);
    front.rows(0, [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        const double* row = front.row(static_cast<int>(i));
        Value* to = panel + i * w;
        for (std::size_t j = 0; j < std::min(i, w); ++j) to[j] = static_cast<Value>(row[j]);
        if (i < w) {
          to[i] = static_cast<Value>(1 / row[i]);
          continue;
        }
        const std::size_t r = i - w;
        std::copy_n(row + w, r + 1, U + r * (r + 1) / 2);
      }
    });
  }

  SupernodalStructure structure_;
  PanelStorage storage_ = PanelStorage::full;
  /// Panels, row-major: the inverse of the diagonal on it, zero above it. One of the two is used.
  LargeArray<double> full_;
  LargeArray<float> single_;
  mutable Spaces spaces_;
};

}  // namespace

std::unique_ptr<SparseFactor::Backend> make_supernodal_factor() {
  return std::make_unique<SupernodalFactor>();
}

}  // namespace skinfield
