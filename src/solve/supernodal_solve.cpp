#include "solve/supernodal_solve.h"

#include "skinfield/base/parallel.h"
#include "solve/dense_kernel.h"

#include <algorithm>
#include <cstring>

namespace skinfield {
namespace {

template <class Value>
class Solve {
 public:
  Solve(const SupernodalStructure& structure, const Value* L, const ActiveRows& active,
        double* values, LargeArray<double>& space)
      : s_(structure),
        L_(L),
        active_(active),
        values_(values),
        chunks_((active.columns + kChunk - 1) / kChunk),
        stride_(chunks_ * kChunk),
        X_(space.resize(static_cast<std::size_t>(s_.spare.back()) *
                        static_cast<std::size_t>(stride_))) {}

  void run() {
    find_chunks();
    parallel_for(s_.subtrees.size(), 1, [&](std::size_t t) {
      for (int k = s_.begin[t]; k <= s_.subtrees[t]; ++k) load(k);
      for (int row = s_.spare[t]; row < s_.spare[t + 1]; ++row) clear(s_.subtrees[t], row);
      Scratch scratch;
      for (int k = s_.begin[t]; k <= s_.subtrees[t]; ++k) forward(k, 0, chunks_, scratch);
    });
    for_top([&](int k) { load(k); });
    // An even number of parts, so that two threads get as much each.
    const int wide = 2 * kStripChunks;
    const int strips = std::min(chunks_, 2 * ((chunks_ + wide - 1) / wide));
    parallel_for(static_cast<std::size_t>(strips), 1, [&](std::size_t strip) {
      const int begin = static_cast<int>(strip) * chunks_ / strips;
      const int end = (static_cast<int>(strip) + 1) * chunks_ / strips;
      Scratch scratch;
      for (std::size_t t = 0; t < s_.subtrees.size(); ++t) collect(t, begin, end);
      for (const int k : s_.top) forward(k, begin, end, scratch);
      for (std::size_t t = s_.top.size(); t-- > 0;) backward(s_.top[t], begin, end, scratch);
    });
    for_top([&](int k) { store(k); });
    parallel_for(s_.subtrees.size(), 1, [&](std::size_t t) {
      Scratch scratch;
      for (int k = s_.subtrees[t]; k >= s_.begin[t]; --k) {
        backward(k, 0, chunks_, scratch);
        store(k);
      }
    });
  }

 private:
  struct Scratch {
    std::vector<double> panel, gathered;
  };

  const Supernode& node(int k) const { return s_.nodes[static_cast<std::size_t>(k)]; }
  double* row(int i) const { return X_ + static_cast<std::ptrdiff_t>(i) * stride_; }

  template <class Body>
  void for_top(const Body& body) const {
    parallel_for(s_.top.size(), 1, [&](std::size_t t) { body(s_.top[t]); });
  }

  /// Chunks with an active entry in the supernode or below it: others stay zero there.
  void find_chunks() {
    const auto width = static_cast<std::size_t>(chunks_);
    std::vector<char> used(s_.nodes.size() * width, 0);
    const auto mark = [&](int k) {
      char* own = used.data() + static_cast<std::size_t>(k) * width;
      for (int i = node(k).first; i < node(k).first + node(k).width; ++i) {
        const auto [begin, end] = entries(i);
        for (auto e = begin; e < end; ++e) {
          own[active_.column[static_cast<std::size_t>(e)] / kChunk] = 1;
        }
      }
    };
    const auto inherit = [&](int k) {
      char* own = used.data() + static_cast<std::size_t>(k) * width;
      for (const int child : node(k).children) {
        const char* below = used.data() + static_cast<std::size_t>(child) * width;
        for (std::size_t c = 0; c < width; ++c) own[c] |= below[c];
      }
    };
    parallel_for(s_.subtrees.size(), 1, [&](std::size_t t) {
      for (int k = s_.begin[t]; k <= s_.subtrees[t]; ++k) {
        mark(k);
        inherit(k);
      }
    });
    for_top(mark);
    for (const int k : s_.top) inherit(k);
    first_.assign(1, 0);
    for (std::size_t k = 0; k < s_.nodes.size(); ++k) {
      for (int c = 0; c < chunks_; ++c) {
        if (used[k * width + static_cast<std::size_t>(c)]) at_.push_back(c * kChunk);
      }
      first_.push_back(static_cast<int>(at_.size()));
    }
  }

  std::pair<std::int64_t, std::int64_t> entries(int row) const {
    const auto old = static_cast<std::size_t>(s_.old_of_new[static_cast<std::size_t>(row)]);
    return {active_.start[old], active_.start[old + 1]};
  }

  void clear(int k, int i) const {
    double* x = row(i);
    for (int c = first_[static_cast<std::size_t>(k)]; c < first_[static_cast<std::size_t>(k) + 1];
         ++c) {
      std::fill_n(x + at_[static_cast<std::size_t>(c)], kChunk, 0.0);
    }
  }

  void load(int k) const {
    for (int i = node(k).first; i < node(k).first + node(k).width; ++i) {
      clear(k, i);
      double* x = row(i);
      const auto [begin, end] = entries(i);
      for (auto e = begin; e < end; ++e)
        x[active_.column[static_cast<std::size_t>(e)]] = values_[e];
    }
  }

  void store(int k) const {
    for (int i = node(k).first; i < node(k).first + node(k).width; ++i) {
      const double* x = row(i);
      const auto [begin, end] = entries(i);
      for (auto e = begin; e < end; ++e)
        values_[e] = x[active_.column[static_cast<std::size_t>(e)]];
    }
  }

  /// Calls visit(offsets, count) for the supernode's chunks in [begin, end).
  template <class Visit>
  void chunks(int k, int begin, int end, const Visit& visit) const {
    const auto from = at_.begin() + first_[static_cast<std::size_t>(k)];
    const auto to = at_.begin() + first_[static_cast<std::size_t>(k) + 1];
    const auto at = std::lower_bound(from, to, begin * kChunk);
    const auto last = std::lower_bound(at, to, end * kChunk);
    if (at < last) visit(&*at, static_cast<int>(last - at));
  }

  /// Adds what subtree t sends to the rows above it.
  void collect(std::size_t t, int begin, int end) const {
    const Supernode& root = node(s_.subtrees[t]);
    chunks(s_.subtrees[t], begin, end, [&](const int* at, int count) {
      for (std::size_t r = 0; r < root.rows.size(); ++r) {
        const double* from = row(s_.spare[t] + static_cast<int>(r));
        double* to = row(root.rows[r]);
        for (int q = 0; q < count; ++q) {
          for (int c = at[q]; c < at[q] + kChunk; ++c) to[c] += from[c];
        }
      }
    });
  }

  Panel<Value> panel(int k, Scratch& scratch) const {
    const Supernode& n = node(k);
    if (scratch.panel.size() < scratch_size(n.width)) scratch.panel.resize(scratch_size(n.width));
    return {L_ + n.offset, n.width, n.size(), row(n.first), X_, stride_, scratch.panel.data()};
  }

  void forward(int k, int begin, int end, Scratch& scratch) const {
    chunks(k, begin, end, [&](const int* at, int count) {
      forward_panel(panel(k, scratch), node(k).target.data(), at, count);
    });
  }

  void backward(int k, int begin, int end, Scratch& scratch) const {
    chunks(k, begin, end, [&](const int* at, int count) {
      const std::size_t size = node(k).rows.size() * static_cast<std::size_t>(count) * kChunk;
      if (scratch.gathered.size() < size) scratch.gathered.resize(size);
      double* to = scratch.gathered.data();
      for (const int i : node(k).rows) {
        const double* from = row(i);
        for (int q = 0; q < count; ++q, to += kChunk) {
          std::memcpy(to, from + at[q], kChunk * sizeof(double));
        }
      }
      backward_panel(panel(k, scratch), scratch.gathered.data(), at, count);
    });
  }

  const SupernodalStructure& s_;
  const Value* L_;
  const ActiveRows& active_;
  double* values_;
  int chunks_, stride_;
  double* X_;                    ///< (n + spare, stride), rows in the factor's order
  std::vector<int> first_, at_;  ///< supernode k carries the columns from at_[first_[k] ...)
};

}  // namespace

void solve_supernodal(const SupernodalStructure& structure, const double* L,
                      const ActiveRows& active, double* values, LargeArray<double>& space) {
  Solve(structure, L, active, values, space).run();
}

void solve_supernodal(const SupernodalStructure& structure, const float* L,
                      const ActiveRows& active, double* values, LargeArray<double>& space) {
  Solve(structure, L, active, values, space).run();
}

}  // namespace skinfield
