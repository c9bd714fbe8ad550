// What must not bleed and what must cross: narrow gaps, overlapping parts, shells, damaged faces.
#include "bind/fixtures.h"

namespace skinfield {
namespace {

using namespace skinfield_test;

TEST(Visibility, ProngsOfAForkDoNotBleed) {
  for (double gap : {0.02, 0.002, 0.0002, 0.00005}) {
    const Mesh fork = fork_mesh(gap);
    const BindResult result = bound(character(fork, fork_bones(gap)), quick(2000));
    EXPECT_EQ(result.report.rung, Rung::volume);
    double across = 0;
    int walls = 0;
    for (Eigen::Index i = 0; i < fork.V.rows(); ++i) {
      const double x = fork.V(i, 0);
      if (fork.V(i, 1) < 0.35) continue;
      const bool left = std::abs(x - 0.1) < 1e-9, right = std::abs(x - 0.1 - gap) < 1e-9;
      if (!left && !right) continue;
      ++walls;
      across = std::max(across, result.weights.W.coeff(i, left ? 1 : 0));
    }
    EXPECT_EQ(walls, 2 * 14 * 4);
    EXPECT_LE(across, 1e-3) << "gap " << gap;
  }
}

TEST(Visibility, OverlappingBoxesAreOneBody) {
  Mesh chain = fine_box({0, 0, 0}, {0.3, 0.2, 0.2}, {6, 4, 4});
  std::vector<Handle> bones{bone({0.05, 0.1, 0.1}, {0.2, 0.1, 0.1})};
  const Eigen::Index each = chain.V.rows();
  for (int b = 1; b < 4; ++b) {
    const double x = 0.22 * b, inset = 0.004 * b;  // no faces in common
    chain = together(chain,
                     fine_box({x, inset, inset}, {x + 0.3, 0.2 - inset, 0.2 - inset}, {6, 4, 4}));
    bones.push_back(bone({x + 0.1, 0.1, 0.1}, {x + 0.2, 0.1, 0.1}));
  }
  const BindResult result = bound(character(chain, bones), quick(2000));
  EXPECT_EQ(result.report.clean_parts, 4);
  EXPECT_EQ(result.report.passenger_parts, 0);
  EXPECT_EQ(result.report.node_components, 1);
  for (int b = 0; b < 4; ++b) {
    // Every bone rules its own box and reaches into the next one.
    const SkinWeights own = rows_of(result.weights, b * each, (b + 1) * each);
    EXPECT_GT(own.W.col(b).sum(), 0.4 * static_cast<double>(each));
    if (b < 3) {
      const SkinWeights next = rows_of(result.weights, (b + 1) * each, (b + 2) * each);
      EXPECT_GT(next.W.col(b).toDense().maxCoeff(), 0.3);
    }
  }
  // One bar with the same outline, four bones: about the same weights.
  const BindResult whole =
      bound(character(fine_box({0, 0, 0}, {0.96, 0.2, 0.2}, {19, 4, 4}), bones), quick(2000));
  Mesh at_chain;
  at_chain.V = chain.V;
  EXPECT_LT(tv(transfer(*whole.solved, character(at_chain, bones)), result.weights), 0.05);
}

TEST(Visibility, AShellIsCarriedByItsBody) {
  const std::vector<Handle> bones{bone({0, 0, -0.45}, {0, 0, -0.15}),
                                  bone({0, 0, -0.15}, {0, 0, 0.15}),
                                  bone({0, 0, 0.15}, {0, 0, 0.45})};
  const Mesh body = sphere_mesh(0.5);
  const Eigen::Index n = body.V.rows();
  const BindResult alone = bound(character(body, bones));
  const BindResult gloved = bound(character(together(body, sphere_mesh(0.51)), bones));
  EXPECT_EQ(gloved.report.passenger_parts, 1);
  EXPECT_EQ(gloved.report.vertices_filled.at("passenger"), n);
  EXPECT_LT(tv(rows_of(gloved.weights, 0, n), alone.weights), 0.02);
  EXPECT_LT(tv(rows_of(gloved.weights, n, 2 * n), rows_of(gloved.weights, 0, n)), 0.02);
}

TEST(Visibility, DoubledAndFlippedFacesChangeNothing) {
  const BindResult clean = bound(character(bar(), bar_bones()));
  const BindResult twice = bound(character(doubled(bar()), bar_bones()));
  const BindResult flipped = bound(character(randomly_flipped(bar(), 2), bar_bones()));
  EXPECT_EQ(flipped.report.rung, Rung::volume);
  EXPECT_GT(flipped.report.flipped_faces, 0);
  EXPECT_LT(tv(twice.weights, clean.weights), 1e-3);
  EXPECT_LT(tv(flipped.weights, clean.weights), 1e-3);
}

TEST(Visibility, ASoupIsNearlyItsSurface) {
  const Mesh mesh = bar();
  const Character c = character(mesh, bar_bones());
  const BindResult clean = bound(c);
  for (double removed : {0.1, 0.3, 0.6}) {
    const Character soup = character(soup_of(mesh, removed, 0.005, 3), bar_bones());
    const BindResult result = bound(soup);
    EXPECT_EQ(result.report.rung, Rung::volume);
    // Compared at the soup's own vertices.
    EXPECT_LT(tv(transfer(*clean.solved, soup), result.weights), 0.06) << removed << " removed";
  }
}

TEST(Visibility, ABoneDoesNotReachThroughACavity) {
  // Two walls of a hollow box: the bone in one is far from the other, whatever the distance.
  const Mesh hollow =
      voxel_mesh(steps(0, 1, 20), steps(0, 1, 20), steps(0, 0.2, 4),
                 [](const Vec3& x) { return x[0] < 0.45 || x[0] > 0.55 || x[1] < 0.2; });
  const std::vector<Handle> bones{bone({0.25, 0.3, 0.1}, {0.25, 0.9, 0.1}),
                                  bone({0.75, 0.3, 0.1}, {0.75, 0.9, 0.1}),
                                  bone({0.2, 0.1, 0.1}, {0.8, 0.1, 0.1})};
  const BindResult result = bound(character(hollow, bones), quick(2000));
  for (Eigen::Index i = 0; i < hollow.V.rows(); ++i) {
    if (hollow.V(i, 1) < 0.5) continue;
    EXPECT_LT(result.weights.W.coeff(i, hollow.V(i, 0) < 0.5 ? 1 : 0), 0.02);
  }
}

}  // namespace
}  // namespace skinfield
