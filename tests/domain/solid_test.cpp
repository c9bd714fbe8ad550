#include "skinfield/domain/solid.h"

#include "domain/fixtures.h"
#include "skinfield/base/parallel.h"
#include "skinfield/domain/point_domain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace skinfield {
namespace {

using namespace skinfield_test;

Solid solid_of(const Mesh& mesh, const std::vector<Handle>& handles) {
  return Solid(mesh, probe_handles(handles, 0.02));
}

const std::vector<Handle>& axis() {
  static const std::vector<Handle> handles{bone({0, 0, -0.3}, {0, 0, 0.3})};
  return handles;
}

/// Share of 4,000 random points, those within `skin` of the radius left out, on the right side.
double sphere_agreement(const Solid& solid, double radius, double skin) {
  const Points X = random_points(4000, -0.6, 0.6, 3);
  int right = 0, asked = 0;
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const double r = X.row(i).norm();
    if (std::abs(r - radius) < skin) continue;
    ++asked;
    right += solid.inside(row(X, i)) == (r < radius);
  }
  return static_cast<double>(right) / asked;
}

TEST(Solid, SphereHasItsInside) {
  const Solid solid = solid_of(sphere_mesh(0.5), axis());
  EXPECT_EQ(sphere_agreement(solid, 0.5, 0.006), 1);
  EXPECT_EQ(solid.facts().clean, 1);
  EXPECT_EQ(solid.facts().dirty, 0);
  EXPECT_FALSE(solid.has_dirty());
  EXPECT_EQ(solid.facts().handle_samples_inside, solid.facts().handle_samples);
}

TEST(Solid, BoxHasItsInside) {
  const Vec3 low(0.1, 0.2, 0.3), high(0.9, 0.6, 0.5);
  const Solid solid = solid_of(box_mesh(low, high), {bone({0.2, 0.4, 0.4}, {0.8, 0.4, 0.4})});
  const Points X = random_points(4000, 0, 1, 5);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const Vec3 x = row(X, i);
    const double depth = std::min((x - low).minCoeff(), (high - x).minCoeff());
    if (std::abs(depth) < 1e-4) continue;
    EXPECT_EQ(solid.inside(x), depth > 0) << x.transpose();
  }
}

TEST(Solid, OutwardClosedSurfaceInsideOutIsTheSame) {
  const Solid solid = solid_of(turned_inside_out(sphere_mesh(0.5)), axis());
  EXPECT_EQ(sphere_agreement(solid, 0.5, 0.006), 1);
}

TEST(Solid, OverlappingPartsAreOneInside) {
  // An L of two boxes whose surfaces cross.
  const Mesh mesh =
      together(box_mesh({0, 0, 0}, {1, 0.2, 0.2}), box_mesh({0.78, 0.03, 0.02}, {0.98, 0.9, 0.18}));
  const Solid solid = solid_of(
      mesh, {bone({0.1, 0.1, 0.1}, {0.6, 0.1, 0.1}), bone({0.88, 0.3, 0.1}, {0.88, 0.8, 0.1})});
  EXPECT_EQ(solid.facts().clean, 2);
  EXPECT_EQ(solid.facts().passengers, 0);
  const Site foot = solid.site({0.1, 0.1, 0.1}), corner = solid.site({0.88, 0.1, 0.1});
  const Site top = solid.site({0.88, 0.8, 0.1});
  EXPECT_FALSE(solid.blocked(foot, corner));
  EXPECT_FALSE(solid.blocked(corner, top));
  EXPECT_FALSE(solid.blocked(top, corner));
  EXPECT_TRUE(solid.blocked(foot, top));
  EXPECT_TRUE(solid.blocked(top, foot));
}

TEST(Solid, ACavityIsOutsideAndBlocks) {
  const Mesh mesh = together(box_mesh({0, 0, 0}, {1, 1, 1}),
                             moved(turned_inside_out(sphere_mesh(0.25)), {0.5, 0.5, 0.5}));
  const Solid solid = solid_of(mesh, {bone({0.1, 0.1, 0.1}, {0.9, 0.1, 0.1})});
  EXPECT_EQ(solid.facts().passengers, 0);
  EXPECT_FALSE(solid.inside(Vec3(0.5, 0.5, 0.5)));
  EXPECT_TRUE(solid.inside(Vec3(0.5, 0.5, 0.1)));
  EXPECT_TRUE(solid.blocked(solid.site({0.1, 0.5, 0.5}), solid.site({0.9, 0.5, 0.5})));
  EXPECT_FALSE(solid.blocked(solid.site({0.1, 0.1, 0.5}), solid.site({0.9, 0.1, 0.5})));
}

TEST(Solid, AShellAroundTheBodyIsAPassenger) {
  const Mesh body = sphere_mesh(0.5);
  const Solid solid = solid_of(together(body, sphere_mesh(0.51)), axis());
  EXPECT_EQ(solid.facts().clean, 1);
  EXPECT_EQ(solid.facts().passengers, 1);
  const int n = static_cast<int>(body.V.rows());
  for (int v = 0; v < 2 * n; ++v)
    EXPECT_EQ(solid.kind_of_vertex(v), v < n ? Solid::PartKind::clean : Solid::PartKind::passenger);
  EXPECT_EQ(solid.faces().rows(), body.F.rows());
  EXPECT_FALSE(solid.inside(Vec3(0.505, 0, 0)));
}

TEST(Solid, AJointWithoutBonesThatJoinsPartsStays) {
  const Mesh mesh = together(
      together(box_mesh({0, 0, 0}, {0.45, 0.2, 0.2}), box_mesh({0.55, 0, 0}, {1, 0.2, 0.2})),
      box_mesh({0.4, 0.03, 0.04}, {0.6, 0.16, 0.17}));
  const std::vector<Handle> bones{bone({0.05, 0.1, 0.1}, {0.35, 0.1, 0.1}),
                                  bone({0.65, 0.1, 0.1}, {0.95, 0.1, 0.1})};
  const Solid solid = solid_of(mesh, bones);
  EXPECT_EQ(solid.facts().passengers, 0);
  EXPECT_FALSE(solid.blocked(solid.site({0.2, 0.1, 0.1}), solid.site({0.8, 0.1, 0.1})));

  // The same knob where it joins nothing: it rides along.
  const Mesh knob = together(box_mesh({0, 0, 0}, {0.45, 0.2, 0.2}),
                             box_mesh({0.4, 0.03, 0.04}, {0.6, 0.16, 0.17}));
  const Solid with_knob = solid_of(knob, {bones[0]});
  EXPECT_EQ(with_knob.facts().passengers, 1);
  EXPECT_EQ(with_knob.kind_of_vertex(8), Solid::PartKind::passenger);
}

TEST(Solid, DoubledAndFlippedFacesGiveTheSameInside) {
  const Mesh torus = torus_mesh(0.35, 0.12);
  std::vector<Handle> ring;
  for (int k = 0; k < 6; ++k) {
    const double a = k * std::numbers::pi / 3, b = a + std::numbers::pi / 3;
    ring.push_back(bone({0.35 * std::cos(a), 0.35 * std::sin(a), 0},
                        {0.35 * std::cos(b), 0.35 * std::sin(b), 0}));
  }
  const Solid clean = solid_of(torus, ring);
  const Solid twice = solid_of(doubled(torus), ring);
  const Solid flipped = solid_of(randomly_flipped(torus, 4), ring);
  EXPECT_EQ(twice.facts().duplicate_faces, torus.F.rows());
  EXPECT_GT(flipped.facts().flipped_faces, torus.F.rows() / 4);
  EXPECT_EQ(flipped.facts().clean, 1);
  const Points X = random_points(3000, -0.5, 0.5, 9);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const Site site = clean.site(row(X, i));
    if (site.clearance < 1e-3) continue;
    EXPECT_EQ(twice.inside(row(X, i)), clean.inside(site));
    EXPECT_EQ(flipped.inside(row(X, i)), clean.inside(site));
  }
}

TEST(Solid, ASoupHasNearlyTheInsideOfItsSurface) {
  const Solid solid = solid_of(soup_of(sphere_mesh(0.5), 0.3, 0.01, 1), axis());
  EXPECT_TRUE(solid.has_dirty());
  EXPECT_GT(sphere_agreement(solid, 0.5, 0), 0.95);
  // Its own triangles do not block inside; the hull of it does.
  EXPECT_FALSE(solid.blocked(solid.site({-0.3, 0, 0}), solid.site({0.3, 0.1, 0.1})));
  EXPECT_TRUE(solid.blocked(solid.site({0, 0, 0}), solid.site({0.8, 0, 0})));
}

TEST(Solid, ACloudWithNormalsHasNearlyTheInsideOfItsSurface) {
  const Solid solid = solid_of(sphere_cloud(0.5, 2000, true), axis());
  EXPECT_TRUE(solid.has_dirty());
  EXPECT_GT(sphere_agreement(solid, 0.5, 0), 0.95);
}

TEST(Solid, SiteNearAgreesWithSite) {
  // Of a body with a cavity and an overlapping part: windings 0, 1 and 2.
  const Mesh mesh = together(together(box_mesh({0, 0, 0}, {0.8, 0.8, 0.8}),
                                      moved(turned_inside_out(sphere_mesh(0.2)), {0.3, 0.3, 0.3})),
                             box_mesh({0.6, 0.61, 0.62}, {1, 1, 1}));
  const Solid solid = solid_of(
      mesh, {bone({0.05, 0.05, 0.05}, {0.7, 0.05, 0.05}), bone({0.7, 0.7, 0.7}, {0.95, 0.9, 0.9})});
  const Points A = random_points(500, -0.1, 1.1, 1), B = random_points(500, -0.1, 1.1, 2);
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Site known = solid.site(row(A, i)), truth = solid.site(row(B, i));
    if (known.clearance < 1e-3 || truth.clearance < 1e-3) continue;
    const Site near = solid.site_near(known, row(B, i));
    EXPECT_NEAR(near.winding, truth.winding, 0.02);
    EXPECT_LE(near.clearance, truth.clearance + 1e-9);
    EXPECT_EQ(near.x, truth.x);
    EXPECT_EQ(solid.inside(near), solid.inside(truth));
  }
}

TEST(Solid, BlockingIsSymmetricAndTheSameOneByOneAndTogether) {
  const Solid solid = solid_of(torus_mesh(0.35, 0.12), {bone({0.35, -0.05, 0}, {0.35, 0.05, 0})});
  std::vector<Site> inside;
  const Points X = random_points(1500, -0.5, 0.5, 6);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const Site site = solid.site(row(X, i));
    if (solid.inside(site) && site.clearance > 1e-3) inside.push_back(site);
  }
  ASSERT_GT(inside.size(), 100u);
  std::vector<unsigned char> blocked(inside.size());
  int some = 0;
  for (std::size_t a = 0; a < inside.size(); a += 7) {
    solid.blocked(inside[a], inside, blocked);
    for (std::size_t b = 0; b < inside.size(); ++b) {
      const bool one = solid.blocked(inside[a], inside[b]);
      EXPECT_EQ(blocked[b] != 0, one);
      EXPECT_EQ(solid.blocked(inside[b], inside[a]), one);
      some += one;
      // A ray that stops at b says the same.
      const Vec3 way = inside[b].x - inside[a].x;
      if (way.norm() < 1e-6) continue;
      const Vec3 direction = way.normalized();
      double t = way.norm();
      unsigned char hit = 0;
      solid.reach(inside[a], {&direction, 1}, {&t, 1}, {&hit, 1});
      EXPECT_EQ(hit != 0, one);
      EXPECT_EQ(t == way.norm(), !one);
    }
  }
  EXPECT_GT(some, 100);  // through the hole of the torus
}

TEST(Solid, SameBytesForOneAndTwoThreads) {
  const Mesh mesh = soup_of(sphere_mesh(0.5), 0.3, 0.01, 1);
  const Points X = random_points(500, -0.6, 0.6, 3);
  std::vector<char> inside[2];
  std::vector<Site> sites[2];
  for (int run = 0; run < 2; ++run) {
    const ThreadLimit limit(run + 1);
    const Solid solid = solid_of(mesh, axis());
    sites[run] = solid.sites(X);
    for (const Site& s : sites[run]) inside[run].push_back(solid.inside(s));
  }
  EXPECT_EQ(inside[0], inside[1]);
  for (std::size_t i = 0; i < sites[0].size(); ++i) {
    EXPECT_EQ(sites[0][i].winding, sites[1][i].winding);
    EXPECT_EQ(sites[0][i].clearance, sites[1][i].clearance);
  }
}

TEST(Solid, StopsWhenAsked) {
  Progress progress;
  progress.cancelled = [] { return true; };
  EXPECT_THROW(Solid(sphere_mesh(0.5), probe_handles(axis(), 0.02), {}, progress), Cancelled);
}

}  // namespace
}  // namespace skinfield
