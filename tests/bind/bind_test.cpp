#include "skinfield/bind/bind.h"

#include "bind/fixtures.h"

#include <limits>

namespace skinfield {
namespace {

using namespace skinfield_test;

/// The bar with three bones, bound once.
const BindResult& bar_result() {
  static const BindResult result = bound(character(bar(), bar_bones()));
  return result;
}

TEST(Bind, OneBoneTakesEverything) {
  const BindResult result =
      bound(character(sphere_mesh(1.7), {bone({0, 0, -1}, {0, 0, 1})}), quick(500));
  EXPECT_EQ(result.report.rung, Rung::volume);
  for (Eigen::Index i = 0; i < result.weights.W.rows(); ++i)
    EXPECT_DOUBLE_EQ(result.weights.W.coeff(i, 0), 1);
}

TEST(Bind, BonesRuleWhereTheyAre) {
  const BindResult& result = bar_result();
  EXPECT_EQ(result.report.rung, Rung::volume);
  EXPECT_EQ(result.report.domain_kind, "points");
  EXPECT_EQ(result.report.solve.status, SolveStats::Status::converged);
  EXPECT_EQ(result.report.node_components, 1);
  EXPECT_EQ(result.report.handles, 3);
  EXPECT_EQ(result.report.handles_inside.size(), 3u);
  EXPECT_TRUE(result.report.warnings.empty());
  EXPECT_TRUE(result.report.vertices_filled.empty());
  EXPECT_GE(result.report.solve.energy, result.report.solve.lower_bound);
  const Mesh mesh = bar();
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) {
    const double x = mesh.V(i, 0);
    for (int b = 0; b < 3; ++b)
      if (std::abs(x - (0.2 + 0.3 * b)) < 0.06) {
        EXPECT_GT(result.weights.W.coeff(i, b), 0.85) << "x = " << x;
      }
    EXPECT_LT(result.weights.W.coeff(i, x < 0.5 ? 2 : 0), 0.5);
  }
}

TEST(Bind, CoincidentVerticesAgree) {
  const Mesh split = soup_of(bar(), 0, 0, 1);  // every face its own corners, none moved
  const Character c = character(split, bar_bones());
  const BindResult result = bound(c);
  EXPECT_EQ(result.report.rung, Rung::volume);
  ASSERT_GT(result.weights.W.rows(), c.mesh.V.rows());
  std::vector<int> first(static_cast<std::size_t>(c.mesh.V.rows()), -1);
  const RowMatrix W = dense_weights(result.weights);
  for (std::size_t i = 0; i < c.vertex_of_input.size(); ++i) {
    int& f = first[static_cast<std::size_t>(c.vertex_of_input[i])];
    if (f < 0) f = static_cast<int>(i);
    EXPECT_EQ(W.row(static_cast<Eigen::Index>(i)), W.row(f));
  }
}

TEST(Bind, SaysWhatIsWrongWithTheInput) {
  EXPECT_THROW(bind(character(Mesh{}, bar_bones())), InputError);
  EXPECT_THROW(bind(character(bar(), {})), InputError);
  Character broken = character(bar(), bar_bones());
  broken.mesh.V(17, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(bind(broken), InputError);
  broken.mesh.V(17, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(bind(broken), InputError);

  const Character c = character(bar(), bar_bones());
  BindOptions options = quick();
  options.locked_columns = {0};
  EXPECT_THROW(bind(c, options), InputError);  // nothing to keep them from
  options = quick();
  options.start = SkinWeights{SparseRows(3, 3), {}};
  EXPECT_THROW(bind(c, options), InputError);
  options = quick();
  options.paint = Paint{{0}, RowMatrix::Identity(1, 2)};
  EXPECT_THROW(bind(c, options), InputError);
  options.paint = Paint{{1000000}, RowMatrix::Identity(1, 3)};
  EXPECT_THROW(bind(c, options), InputError);
  options.paint = Paint{{-1}, RowMatrix::Identity(1, 3)};
  EXPECT_THROW(bind(c, options), InputError);
}

TEST(Bind, AHandleOutsideGetsNothingAndAWarning) {
  std::vector<Handle> bones = bar_bones();
  bones.push_back(bone({0.2, 0.6, 0.1}, {0.8, 0.6, 0.1}, "halo"));
  bones.push_back(bone({0.9, 0.1, 0.1}, {1.4, 0.1, 0.1}, "tail"));
  const BindResult result = bound(character(bar(), bones));
  EXPECT_EQ(result.report.rung, Rung::volume);
  EXPECT_EQ(result.report.handles_outside, std::vector<std::string>{"halo"});
  EXPECT_EQ(result.report.handles_partly_inside, std::vector<std::string>{"tail"});
  EXPECT_EQ(result.weights.W.col(3).sum(), 0);
  EXPECT_GT(result.weights.W.col(4).sum(), 0);
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_NE(result.report.warnings[0].find("halo"), std::string::npos);
}

TEST(Bind, ABoneOfZeroLengthIsAPoint) {
  std::vector<Handle> bones = bar_bones(2);
  bones[1].segments = {{Vec3(0.8, 0.1, 0.1), Vec3(0.8, 0.1, 0.1)}};
  std::vector<Handle> points = bones;
  points[1] = point_handle({0.8, 0.1, 0.1}, "bone_1");
  const BindResult a = bound(character(bar(), bones)), b = bound(character(bar(), points));
  EXPECT_GT(a.weights.W.col(1).sum(), 0);
  EXPECT_LT(tv(a.weights, b.weights), 1e-6);
}

TEST(Bind, PaintedRowsHoldAndPullTheirNeighbours) {
  const Character c = character(bar(), bar_bones());
  const Mesh& mesh = c.mesh;
  // The top face around x = 0.2, bone 0's middle, is painted to bone 2.
  Paint paint;
  std::vector<int> neighbours;
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) {
    if (mesh.V(i, 2) < 0.199 || mesh.V(i, 1) < 0.04 || mesh.V(i, 1) > 0.16) continue;
    const double off = std::abs(mesh.V(i, 0) - 0.2);
    if (off < 0.06)
      paint.vertex.push_back(static_cast<int>(i));
    else if (off < 0.11)
      neighbours.push_back(static_cast<int>(i));
  }
  ASSERT_EQ(paint.vertex.size(), 9u);
  ASSERT_EQ(neighbours.size(), 6u);
  paint.weights = RowMatrix::Zero(9, 3);
  paint.weights.col(1).setConstant(0.25);
  paint.weights.col(2).setConstant(0.75);
  BindOptions options = quick();
  options.paint = paint;
  const BindResult result = bound(c, options);
  for (int v : paint.vertex)
    for (int j = 0; j < 3; ++j)
      EXPECT_DOUBLE_EQ(result.weights.W.coeff(v, j), 0.25 * j + (j == 2 ? 0.25 : 0));
  for (int v : neighbours) {
    EXPECT_LT(bar_result().weights.W.coeff(v, 2), 0.01);
    EXPECT_GT(result.weights.W.coeff(v, 2), 0.1);
  }
}

TEST(Bind, PaintAloneMakesTheHandles) {
  const Character c = character(bar(), {});
  BindOptions options = quick();
  Paint paint;
  for (Eigen::Index i = 0; i < c.mesh.V.rows(); ++i)
    if (c.mesh.V(i, 0) < 0.001 || c.mesh.V(i, 0) > 0.999)
      paint.vertex.push_back(static_cast<int>(i));
  paint.weights = RowMatrix::Zero(static_cast<Eigen::Index>(paint.vertex.size()), 2);
  for (std::size_t k = 0; k < paint.vertex.size(); ++k)
    paint.weights(static_cast<Eigen::Index>(k), c.mesh.V(paint.vertex[k], 0) > 0.5) = 1;
  options.paint = paint;
  const BindResult result = bound(c, options);
  EXPECT_EQ(result.weights.W.cols(), 2);
  for (Eigen::Index i = 0; i < c.mesh.V.rows(); ++i) {
    const double x = c.mesh.V(i, 0);
    if (x < 0.001 || x > 0.999) {
      EXPECT_DOUBLE_EQ(result.weights.W.coeff(i, 1), x > 0.5 ? 1 : 0);
    } else if (std::abs(x - 0.5) < 0.01) {
      EXPECT_NEAR(result.weights.W.coeff(i, 1), 0.5, 0.08);
    }
  }
}

TEST(Bind, LockedColumnsHold) {
  const Character c = character(bar(), bar_bones());
  const RowMatrix own = dense_weights(bar_result().weights);
  const RowMatrix given = 0.7 * own + RowMatrix::Constant(own.rows(), 3, 0.1);
  BindOptions options = quick();
  options.start = sparse_weights(given);
  options.locked_columns = {1};
  const RowMatrix W = dense_weights(bound(c, options).weights);
  EXPECT_LT((W.col(1) - given.col(1)).cwiseAbs().maxCoeff(), 1e-9);
  // The others share the rest, each where its bone is.
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    if (c.mesh.V(i, 0) < 0.3) {
      EXPECT_GT(W(i, 0), W(i, 2));
    }
  }
}

TEST(Bind, AStartDoesNotChangeTheOptimum) {
  const Character c = character(bar(), bar_bones());
  BindOptions options = quick();
  const RowMatrix uniform =
      RowMatrix::Constant(static_cast<Eigen::Index>(c.vertex_of_input.size()), 3, 1.0 / 3);
  for (const SkinWeights& start : {bar_result().weights, sparse_weights(uniform)}) {
    options.start = start;
    const BindResult warm = bound(c, options);
    EXPECT_EQ(warm.report.solve.status, SolveStats::Status::converged);
    EXPECT_LT(tv(warm.weights, bar_result().weights), 2e-3);
  }
}

TEST(Bind, KeepsAtMostSoManyInfluences) {
  const Character c = character(bar(), bar_bones(9));
  const BindResult all = bound(c);
  for (int k : {1, 2, 4}) {
    BindOptions options = quick();
    options.max_influences = k;
    const BindResult result = bound(c, options);
    for (Eigen::Index i = 0; i < result.weights.W.rows(); ++i) {
      int used = 0;
      for (SparseRows::InnerIterator it(result.weights.W, i); it; ++it) used += it.value() > 0;
      EXPECT_LE(used, k);
    }
    EXPECT_LE(result.report.influences.size(), static_cast<std::size_t>(k) + 1);
    if (k == 4) {
      EXPECT_LT(tv(result.weights, all.weights), 0.02);
    }
  }
}

TEST(Bind, PruneDropsSmallWeights) {
  BindOptions options = quick();
  options.prune = 0.05;
  const BindResult result = bound(character(bar(), bar_bones()), options);
  for (Eigen::Index i = 0; i < result.weights.W.rows(); ++i)
    for (SparseRows::InnerIterator it(result.weights.W, i); it; ++it) EXPECT_GE(it.value(), 0.05);
  EXPECT_GT(result.report.pruned_mass_max, 0);
  EXPECT_LT(result.report.pruned_mass_max, 0.1);
}

TEST(Bind, SymmetryMakesMirroredRowsEqual) {
  const Mesh mesh = bar();
  const std::vector<Handle> bones{bone({0.05, 0.1, 0.1}, {0.4, 0.1, 0.1}, "Arm.R"),
                                  bone({0.4, 0.1, 0.1}, {0.6, 0.1, 0.1}, "Chest"),
                                  bone({0.6, 0.1, 0.1}, {0.95, 0.1, 0.1}, "Arm.L")};
  const Character c = character(mesh, bones);
  for (auto symmetry : {BindOptions::Symmetry::x, BindOptions::Symmetry::automatic}) {
    BindOptions options = quick();
    options.symmetry = symmetry;
    const BindResult result = bound(c, options);
    EXPECT_TRUE(result.report.warnings.empty());
    const RowMatrix W = dense_weights(result.weights);
    for (Eigen::Index i = 0; i < W.rows(); ++i) {
      Eigen::Index mirrored = -1;
      const Vec3 x(1 - mesh.V(i, 0), mesh.V(i, 1), mesh.V(i, 2));
      (mesh.V.rowwise() - x.transpose()).rowwise().norm().minCoeff(&mirrored);
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(W(i, j), W(mirrored, 2 - j), 1e-9);
    }
  }
}

TEST(Bind, SymmetryHoldsWhenInfluencesAreCut) {
  const Mesh mesh = bar();
  std::vector<Handle> bones;
  for (int side : {-1, 1})
    for (int b = 0; b < 4; ++b)
      bones.push_back(bone({0.5 + side * (0.02 + 0.11 * b), 0.1, 0.1},
                           {0.5 + side * (0.12 + 0.11 * b), 0.1, 0.1},
                           "b" + std::to_string(b) + (side < 0 ? ".R" : ".L")));
  const Character c = character(mesh, bones);
  for (int influences : {2, 3, 4}) {
    BindOptions options = quick();
    options.symmetry = BindOptions::Symmetry::x;
    options.max_influences = influences;
    const RowMatrix W = dense_weights(bound(c, options).weights);
    for (Eigen::Index i = 0; i < W.rows(); ++i) {
      if (std::abs(mesh.V(i, 0) - 0.5) < 1e-9) continue;  // its own image: an odd cut takes a side
      Eigen::Index mirrored = -1;
      const Vec3 x(1 - mesh.V(i, 0), mesh.V(i, 1), mesh.V(i, 2));
      (mesh.V.rowwise() - x.transpose()).rowwise().norm().minCoeff(&mirrored);
      for (int j = 0; j < 4; ++j) {
        EXPECT_NEAR(W(i, j), W(mirrored, 4 + j), 1e-9);
        EXPECT_NEAR(W(i, 4 + j), W(mirrored, j), 1e-9);
      }
    }
  }
}

TEST(Bind, LimitsStillGiveValidWeights) {
  const Character c = character(bar(), bar_bones(6));
  BindOptions options = quick();
  options.iterations = 1;
  EXPECT_EQ(bound(c, options).report.solve.status, SolveStats::Status::limit);
  options = quick();
  options.time_limit_s = 1e-6;
  EXPECT_EQ(bound(c, options).report.solve.status, SolveStats::Status::limit);
}

TEST(Bind, StopsWhereverItIsAskedTo) {
  // Cancelled at the first poll of each stage it reports.
  const Character c = character(bar(), bar_bones());
  for (const char* stage : {"diagnose", "domain", "solve"}) {
    bool stop = false;
    Progress progress;
    progress.report = [&](std::string_view now, double) { stop |= now == stage; };
    progress.cancelled = [&stop] { return stop; };
    EXPECT_THROW(bind(c, quick(), progress), Cancelled) << stage;
  }
}

TEST(Transfer, ToItselfIsBindAndToACoarserMeshIsClose) {
  const std::vector<Handle> bones{bone({0, 0, -0.8}, {0, 0, -0.2}), bone({0, 0, -0.2}, {0, 0, 0.3}),
                                  bone({0, 0, 0.3}, {0, 0, 0.8})};
  const Character fine = character(sphere_mesh(1, 24), bones);
  const Character coarse = character(sphere_mesh(1, 10), bones);
  const BindResult result = bound(fine);
  EXPECT_LT(tv(transfer(*result.solved, fine), result.weights), 1e-9);
  std::map<std::string, std::int64_t> filled;
  const SkinWeights moved_over = transfer(*result.solved, coarse, &filled);
  const BindResult direct = bound(coarse);
  EXPECT_EQ(moved_over.W.rows(), direct.weights.W.rows());
  EXPECT_LT(tv(moved_over, direct.weights), 0.03);
  for (Eigen::Index i = 0; i < moved_over.W.rows(); ++i)
    EXPECT_NEAR(moved_over.W.row(i).sum(), 1, 1e-9);
  // Clothes a little outside are carried by the body.
  const SkinWeights cloth =
      transfer(*result.solved, character(sphere_mesh(1.05, 24), bones), &filled);
  EXPECT_LT(tv(cloth, result.weights), 0.03);
  EXPECT_GT(filled["passenger"], 0);
}

}  // namespace
}  // namespace skinfield
