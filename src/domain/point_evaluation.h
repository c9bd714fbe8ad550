// Weights of any point from the nodes it sees (findings A 5 and E 5).
#pragma once

#include "domain/kd_tree.h"
#include "skinfield/domain/domain.h"
#include "skinfield/domain/solid.h"

#include <vector>

namespace skinfield {

/// Sparse rows under construction.
struct InterpolationRows {
  std::vector<std::vector<std::pair<int, double>>> row;
  std::vector<Fill> fill;
};

class PointEvaluation {
 public:
  /// @param connected nodes whose graph component holds a handle. @param K the stiffness.
  PointEvaluation(const Solid& solid, const std::vector<Site>& sites, const KdTree& tree,
                  const SparseRows& K, const std::vector<char>& connected, double step);

  /// The row of a point on or in the solid; `normal` outward (or zero) tells where inside is and
  /// along which plane the row is exact for linear functions. `clean`: the masked kernel may be
  /// used.
  Fill evaluate(const Vec3& x, const Vec3& normal, bool clean,
                std::vector<std::pair<int, double>>& row) const;

  /// Unit vector at x away from the nodes around: a normal where triangles give none to rely on.
  Vec3 away_from_nodes(const Vec3& x) const;

  /// The site from which x looks into the solid, if there is one.
  bool look_from(const Vec3& x, const Vec3& normal, Site& site) const;

 private:
  void around(int centre, const Vec3& x, std::vector<std::pair<int, double>>& row) const;

  const Solid& solid_;
  const std::vector<Site>& sites_;
  const KdTree& tree_;
  const SparseRows& K_;
  const std::vector<char>& connected_;
  double step_;
};

/// Passengers: the 16 nearest vertices of the domain, by distance and likeness of normals
/// (findings E 2). `from` rows (n,3), the domain's vertices X, normals N and their rows P.
void carry_passengers(const Points& from, const Points& from_normals, const Points& X,
                      const Points& N, const InterpolationRows& rows_of_X,
                      const std::vector<int>& wanted, InterpolationRows& result);

/// Pieces that float clear of the solid X ride on it stiffly: all their vertices take the mean row
/// of the ones nearest to it, lest a pad above a shoulder tear between arm and chest. A piece is
/// `component` (of all vertices, -1: none) all of whose vertices are `wanted`.
void stiffen_floating(const Points& from, const std::vector<int>& component, const Points& X,
                      const std::vector<int>& wanted, InterpolationRows& result);

/// Sums duplicates, drops dust, and makes rows sum to one.
SparseRows to_matrix(const InterpolationRows& rows, Eigen::Index nodes);

}  // namespace skinfield
