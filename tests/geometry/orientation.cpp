#include "geometry/shapes.h"
#include "skinfield/geometry/normals.h"
#include "skinfield/geometry/winding_number.h"

#include <gtest/gtest.h>

using namespace skinfield_test;

namespace {

int flip_some(Triangles& F, double share, std::uint64_t seed) {
  int count = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    if (Random(seed, f).uniform() >= share) continue;
    std::swap(F(f, 1), F(f, 2));
    ++count;
  }
  return count;
}

/// Every face with corners of its own, moved at random, only a share of the faces kept.
Mesh tear(const Mesh& mesh, double keep, double jitter, std::uint64_t seed) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f)
    if (Random(seed, f).uniform() < keep) kept.push_back(f);
  Mesh soup;
  soup.V.resize(static_cast<Eigen::Index>(kept.size()) * 3, 3);
  soup.F.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (Eigen::Index i = 0; i < soup.V.rows(); ++i) {
    Random random(seed, 1000000 + static_cast<std::uint64_t>(i));
    soup.V.row(i) = mesh.V.row(mesh.F(kept[i / 3], i % 3)) +
                    jitter * Eigen::RowVector3d(random.normal(), random.normal(), random.normal());
    soup.F(i / 3, i % 3) = static_cast<int>(i);
  }
  return soup;
}

Points ring(double radius, int count) {
  Points X(count, 3);
  for (int i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * i / count;
    X.row(i) << radius * std::cos(a), radius * std::sin(a), 0;
  }
  return X;
}

TEST(Orientation, ConsistentClosedMeshesComeBackUnchanged) {
  const Mesh torus = torus_mesh(1, 0.4);
  for (const Points& inside : {Points(0, 3), ring(1, 20)}) {
    const OrientationRepair repair = repair_orientation(torus.V, torus.F, inside);
    EXPECT_EQ(repair.F, torus.F);
    EXPECT_EQ(repair.flipped, 0);
    EXPECT_EQ(repair.inconsistent, 0);
  }
}

TEST(Orientation, RandomFlipsAreUndone) {
  const Mesh torus = torus_mesh(1, 0.4);
  for (const double share : {0.01, 0.3, 0.5, 0.8, 1.0}) {
    Mesh mesh = torus;
    const int flips = flip_some(mesh.F, share, 3);
    const OrientationRepair repair = repair_orientation(mesh.V, mesh.F, ring(1, 20));
    EXPECT_EQ(repair.flipped, flips) << share;
    EXPECT_EQ(repair.inconsistent > 0, share < 1) << share;
    EXPECT_NEAR(face_normals(mesh.V, repair.F).cwiseProduct(face_normals(torus.V, torus.F)).sum(),
                face_normals(torus.V, torus.F).squaredNorm(), 1e-9);
  }
}

TEST(Orientation, FlipsAreUndoneAcrossSplitVertices) {
  Mesh mesh = tear(torus_mesh(1, 0.4), 1, 0, 1);  // all corners apart, at equal places
  const int flips = flip_some(mesh.F, 0.4, 5);
  const OrientationRepair repair = repair_orientation(mesh.V, mesh.F, ring(1, 20));
  EXPECT_EQ(repair.flipped, flips);
}

TEST(Orientation, OneInvertedPartOfSeveralIsTurned) {
  Mesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  Points inside(0, 3);
  for (int i = 1; i < 6; ++i) {
    const Mesh next = box_mesh({0.9 * i, 0, 0}, {0.9 * i + 1, 1, 1});
    mesh.V.conservativeResize(mesh.V.rows() + 8, 3);
    mesh.V.bottomRows(8) = next.V;
    mesh.F.conservativeResize(mesh.F.rows() + 12, 3);
    mesh.F.bottomRows(12) = next.F.array() + 8 * i;
  }
  inside.resize(40, 3);
  for (int i = 0; i < 40; ++i) inside.row(i) << 0.3 + 0.12 * i, 0.45, 0.55;
  EXPECT_EQ(repair_orientation(mesh.V, mesh.F, inside).flipped, 0);
  Mesh bad = mesh;
  bad.F.middleRows(24, 12).col(1).swap(bad.F.middleRows(24, 12).col(2));
  EXPECT_EQ(repair_orientation(bad.V, bad.F, inside).F, mesh.F);
}

TEST(Orientation, AClosedPieceWithoutInsidePointsIsLeftAlone) {
  Mesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  const Mesh apart = box_mesh({2, 0, 0}, {2.2, 0.2, 0.2});
  mesh.V.conservativeResize(16, 3);
  mesh.V.bottomRows(8) = apart.V;
  mesh.F.conservativeResize(24, 3);
  mesh.F.bottomRows(12) = apart.F.array() + 8;
  const Points inside = Eigen::RowVector3d(0.5, 0.5, 0.5);
  EXPECT_EQ(repair_orientation(mesh.V, mesh.F, inside).flipped, 0);
}

TEST(Orientation, SoupsOfFlippedFacesGetAnInsideAgain) {
  const Mesh soup = tear(torus_mesh(1, 0.4), 0.3, 0.01, 2);
  const Points inside = ring(1, 60);
  const double truth = WindingNumber(soup.V, soup.F).at(inside).mean();
  Mesh flipped = soup;
  flip_some(flipped.F, 0.5, 7);
  EXPECT_LT(WindingNumber(flipped.V, flipped.F).at(inside).mean(), 0.5 * truth);
  const OrientationRepair repair = repair_orientation(flipped.V, flipped.F, inside);
  EXPECT_NEAR(WindingNumber(soup.V, repair.F).at(inside).mean(), truth, 0.05 * truth);
  const auto wrong = (repair.F.col(1).array() != soup.F.col(1).array()).count();
  EXPECT_LT(static_cast<double>(wrong), 0.03 * static_cast<double>(soup.F.rows()));
}

TEST(Orientation, ConsistentSoupsStayAsTheyAre) {
  const Mesh soup = tear(torus_mesh(1, 0.4), 0.3, 0.02, 4);
  EXPECT_EQ(repair_orientation(soup.V, soup.F, ring(1, 60)).flipped, 0);
}

TEST(Orientation, AMoebiusStripKeepsItsSeam) {
  Mesh strip = moebius_strip(24);
  EXPECT_EQ(repair_orientation(strip.V, strip.F, Points(0, 3)).F, strip.F);
  Mesh flipped = strip;
  flip_some(flipped.F, 0.3, 2);
  const OrientationRepair repair = repair_orientation(flipped.V, flipped.F, Points(0, 3));
  EXPECT_LE(repair_orientation(strip.V, repair.F, Points(0, 3)).inconsistent, 3);
}

TEST(Orientation, OddInputIsNoTrouble) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                              {{0, 1, 2}, {0, 1, 2}, {2, 1, 0}, {0, 0, 1}, {1, 1, 1}});
  const Points inside = Eigen::RowVector3d(0.2, 0.2, -0.5);
  const OrientationRepair repair = repair_orientation(mesh.V, mesh.F, inside);
  EXPECT_EQ(repair.F.rows(), 5);
  EXPECT_EQ(repair_orientation(Points(0, 3), Triangles(0, 3), inside).F.rows(), 0);
}

}  // namespace
