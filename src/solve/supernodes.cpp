#include "solve/supernodes.h"

#include "solve/ordering.h"

#include <algorithm>
#include <numeric>

namespace skinfield {
namespace {

// Entries of the factor: below, a second ordering costs more than it saves.
constexpr std::size_t kDissectFrom = 20'000'000;

/// Liu's algorithm with path compression, in the order given.
std::vector<int> elimination_tree(const SparseRows& A, const std::vector<int>& old_of_new,
                                  const std::vector<int>& new_of_old) {
  const auto n = old_of_new.size();
  std::vector<int> parent(n, -1), ancestor(n, -1);
  for (int k = 0; k < static_cast<int>(n); ++k) {
    for (SparseRows::InnerIterator it(A, old_of_new[static_cast<std::size_t>(k)]); it; ++it) {
      int i = new_of_old[static_cast<std::size_t>(it.col())];
      while (i >= 0 && i < k) {
        const int next = ancestor[static_cast<std::size_t>(i)];
        ancestor[static_cast<std::size_t>(i)] = k;
        if (next < 0) parent[static_cast<std::size_t>(i)] = k;
        i = next;
      }
    }
  }
  return parent;
}

/// Position of every node when children come directly before their parent.
std::vector<int> postorder(const std::vector<int>& parent) {
  const auto n = static_cast<int>(parent.size());
  std::vector<int> first_child(parent.size(), -1), sibling(parent.size(), -1);
  for (int i = n - 1; i >= 0; --i) {
    const int p = parent[static_cast<std::size_t>(i)];
    if (p < 0) continue;
    sibling[static_cast<std::size_t>(i)] = first_child[static_cast<std::size_t>(p)];
    first_child[static_cast<std::size_t>(p)] = i;
  }
  std::vector<int> order(parent.size()), stack(parent.size());
  std::size_t done = 0, depth = 0;
  for (int root = 0; root < n; ++root) {
    if (parent[static_cast<std::size_t>(root)] >= 0) continue;
    stack[depth++] = root;
    while (depth > 0) {
      const int v = stack[depth - 1];
      int& child = first_child[static_cast<std::size_t>(v)];
      if (child >= 0) {
        stack[depth++] = child;
        child = sibling[static_cast<std::size_t>(child)];
      } else {
        order[done++] = v;
        --depth;
      }
    }
  }
  return order;
}

/// Entries of each column of L, the diagonal included: every row's subtree is walked once.
std::vector<int> column_counts(const SparseRows& A, const SupernodalStructure& s,
                               const std::vector<int>& parent) {
  const auto n = static_cast<int>(parent.size());
  std::vector<int> count(parent.size(), 1), mark(parent.size(), -1);
  for (int i = 0; i < n; ++i) {
    mark[static_cast<std::size_t>(i)] = i;
    for (SparseRows::InnerIterator it(A, s.old_of_new[static_cast<std::size_t>(i)]); it; ++it) {
      int j = s.new_of_old[static_cast<std::size_t>(it.col())];
      if (j >= i) continue;
      for (; mark[static_cast<std::size_t>(j)] != i; j = parent[static_cast<std::size_t>(j)]) {
        ++count[static_cast<std::size_t>(j)];
        mark[static_cast<std::size_t>(j)] = i;
      }
    }
  }
  return count;
}

/// May `zeros` extra entries be stored for `columns` merged columns of `entries` entries?
bool worth_merging(int columns, double zeros, double entries) {
  if (columns <= 8) return true;
  const double share = zeros / entries;
  return columns <= 24 ? share < 0.6 : columns <= 64 ? share < 0.15 : share < 0.05;
}

double panel_entries(double width, double rows_below) {
  return width * (width + 1) / 2 + width * rows_below;
}

/// First columns of the supernodes; ends with n.
std::vector<int> find_supernodes(const std::vector<int>& parent, const std::vector<int>& count) {
  const auto n = static_cast<int>(parent.size());
  struct Part {
    int first, width, below;  ///< below: rows under the last column
    double zeros;
  };
  std::vector<Part> done;  // a stack: a part is merged with the one right before it
  for (int j = 0; j < n;) {
    int last = j;
    while (last + 1 < n && parent[static_cast<std::size_t>(last)] == last + 1 &&
           count[static_cast<std::size_t>(last)] == count[static_cast<std::size_t>(last + 1)] + 1) {
      ++last;
    }
    Part part{j, last - j + 1, count[static_cast<std::size_t>(last)] - 1, 0};
    while (!done.empty()) {
      const Part& child = done.back();
      if (parent[static_cast<std::size_t>(part.first - 1)] < part.first ||
          parent[static_cast<std::size_t>(part.first - 1)] >= part.first + part.width) {
        break;
      }
      const int width = child.width + part.width;
      // The child's columns get the parent's whole structure.
      const double added =
          static_cast<double>(child.width) * (part.width + part.below - child.below);
      const double zeros = child.zeros + part.zeros + added;
      if (!worth_merging(width, zeros, panel_entries(width, part.below))) break;
      part = {child.first, width, part.below, zeros};
      done.pop_back();
    }
    done.push_back(part);
    j = last + 1;
  }
  std::vector<int> first;
  for (const Part& part : done) first.push_back(part.first);
  first.push_back(n);
  return first;
}

/// Splits the forest into subtrees of at most a sixteenth of the work, and the rest.
void split_work(SupernodalStructure& s) {
  std::vector<double> work(s.nodes.size());
  std::vector<int> lowest(s.nodes.size());
  double total = 0;
  for (std::size_t i = 0; i < s.nodes.size(); ++i) {
    const Supernode& node = s.nodes[i];
    const double own = static_cast<double>(node.width) * node.size() * node.size();
    work[i] += own;
    total += own;
    lowest[i] = node.children.empty() ? static_cast<int>(i)
                                      : lowest[static_cast<std::size_t>(node.children.front())];
    if (node.parent >= 0) work[static_cast<std::size_t>(node.parent)] += work[i];
  }
  // From the top down: a node is a subtree's root where its work is small and its parent's is not.
  std::vector<char> above(s.nodes.size(), 0);
  for (std::size_t i = s.nodes.size(); i-- > 0;) {
    const int parent = s.nodes[i].parent;
    const bool open = parent < 0 || above[static_cast<std::size_t>(parent)];
    if (!open) continue;
    if (work[i] > total / 16) {
      above[i] = 1;
      s.top.push_back(static_cast<int>(i));
    } else {
      s.subtrees.push_back(static_cast<int>(i));
    }
  }
  std::reverse(s.top.begin(), s.top.end());
  std::reverse(s.subtrees.begin(), s.subtrees.end());
  for (const int root : s.subtrees) s.begin.push_back(lowest[static_cast<std::size_t>(root)]);
}

void assign_targets(SupernodalStructure& s) {
  for (const int k : s.top) {
    Supernode& node = s.nodes[static_cast<std::size_t>(k)];
    node.target = node.rows;
  }
  s.spare.assign(1, static_cast<int>(s.old_of_new.size()));
  for (std::size_t t = 0; t < s.subtrees.size(); ++t) {
    const Supernode& root = s.nodes[static_cast<std::size_t>(s.subtrees[t])];
    const int end = root.first + root.width;
    for (int k = s.begin[t]; k <= s.subtrees[t]; ++k) {
      Supernode& node = s.nodes[static_cast<std::size_t>(k)];
      node.target = node.rows;
      for (int& row : node.target) {
        if (row < end) continue;
        const auto at = std::lower_bound(root.rows.begin(), root.rows.end(), row);
        row = s.spare.back() + static_cast<int>(at - root.rows.begin());
      }
    }
    s.spare.push_back(s.spare.back() + static_cast<int>(root.rows.size()));
  }
}

}  // namespace

SupernodalStructure analyse_supernodes(const SparseRows& A, std::vector<int> order) {
  SupernodalStructure s;
  const auto n = static_cast<std::size_t>(A.rows());
  const auto invert = [&] {
    s.new_of_old.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      s.new_of_old[static_cast<std::size_t>(s.old_of_new[i])] = static_cast<int>(i);
    }
  };
  s.old_of_new = std::move(order);
  invert();
  std::vector<int> parent = elimination_tree(A, s.old_of_new, s.new_of_old);
  const std::vector<int> post = postorder(parent);
  std::vector<int> place(n), ordered(n);
  for (std::size_t i = 0; i < n; ++i)
    place[static_cast<std::size_t>(post[i])] = static_cast<int>(i);
  for (std::size_t i = 0; i < n; ++i) {
    ordered[i] = s.old_of_new[static_cast<std::size_t>(post[i])];
  }
  s.old_of_new = std::move(ordered);
  invert();
  std::vector<int> moved(n);
  for (std::size_t i = 0; i < n; ++i) {
    const int p = parent[static_cast<std::size_t>(post[i])];
    moved[i] = p < 0 ? -1 : place[static_cast<std::size_t>(p)];
  }
  parent = std::move(moved);

  const std::vector<int> first = find_supernodes(parent, column_counts(A, s, parent));
  s.nodes.resize(first.size() - 1);
  std::vector<int> owner(n), mark(n, -1);
  for (std::size_t k = 0; k < s.nodes.size(); ++k) {
    Supernode& node = s.nodes[k];
    node.first = first[k];
    node.width = first[k + 1] - first[k];
    for (int j = node.first; j < first[k + 1]; ++j)
      owner[static_cast<std::size_t>(j)] = static_cast<int>(k);
  }
  for (std::size_t k = 0; k < s.nodes.size(); ++k) {
    Supernode& node = s.nodes[k];
    const int end = node.first + node.width;
    const auto add = [&](int row) {
      if (row < end || mark[static_cast<std::size_t>(row)] == static_cast<int>(k)) return;
      mark[static_cast<std::size_t>(row)] = static_cast<int>(k);
      node.rows.push_back(row);
    };
    for (int j = node.first; j < end; ++j) {
      for (SparseRows::InnerIterator it(A, s.old_of_new[static_cast<std::size_t>(j)]); it; ++it) {
        add(s.new_of_old[static_cast<std::size_t>(it.col())]);
      }
    }
    for (const int child : node.children) {
      for (const int row : s.nodes[static_cast<std::size_t>(child)].rows) add(row);
    }
    std::sort(node.rows.begin(), node.rows.end());
    node.offset = s.values;
    s.values += static_cast<std::size_t>(node.size()) * static_cast<std::size_t>(node.width);
    if (node.rows.empty()) continue;
    node.parent = owner[static_cast<std::size_t>(node.rows.front())];
    s.nodes[static_cast<std::size_t>(node.parent)].children.push_back(static_cast<int>(k));
  }
  split_work(s);
  assign_targets(s);
  return s;
}

SupernodalStructure analyse_supernodes(const SparseRows& A) {
  SupernodalStructure s = analyse_supernodes(A, minimum_degree_order(A));
  if (s.values < kDissectFrom) return s;
  std::vector<int> order = nested_dissection_order(A);
  if (order.empty()) return s;
  SupernodalStructure other = analyse_supernodes(A, std::move(order));
  return other.values < s.values ? other : s;
}

}  // namespace skinfield
