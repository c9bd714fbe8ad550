#include "geometry/edges.h"
#include "geometry/neighbours.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/normals.h"
#include "skinfield/geometry/ray_scene.h"
#include "skinfield/geometry/winding_number.h"

#include <Eigen/Dense>

#include <cmath>
#include <utility>
#include <vector>

namespace skinfield {
namespace {

constexpr Eigen::Index kWitnesses = 512;  // inside points that judge whole patches
constexpr int kNearWitnesses = 24;        // inside points that judge a small one
constexpr double kInside = 0.5;           // a winding number that is enough
constexpr double kWeighty = 0.25;         // a patch that changes it by this is judged as a whole
constexpr int kFragment = 3;              // patches of up to so many faces never are

/// Pairs of faces over manifold edges; `agree`: their orientations do.
struct Hinge {
  int f, g;
  bool agree;
};

std::vector<Hinge> find_hinges(const Triangles& F) {
  std::vector<Hinge> hinges;
  for_each_edge(F, [&](std::span<const HalfEdge> around) {
    if (around.size() == 2)
      hinges.push_back({around[0].face, around[1].face, around[0].forward != around[1].forward});
  });
  return hinges;
}

/// Faces joined by hinges, and which of them to turn so that they agree with the greater part.
struct Patches {
  std::vector<std::vector<int>> faces;
  std::vector<char> turn;  // per face
};

Patches find_patches(const std::vector<Hinge>& hinges, const Triangles& F, const Vector& area) {
  const auto n = static_cast<std::size_t>(F.rows());
  std::vector<std::vector<std::pair<int, bool>>> beside(n);
  for (const Hinge& h : hinges) {
    beside[h.f].push_back({h.g, h.agree});
    beside[h.g].push_back({h.f, h.agree});
  }
  Patches patches;
  patches.turn.assign(n, 0);
  std::vector<char> seen(n, 0);
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (seen[seed] || !has_three_corners(F, static_cast<Eigen::Index>(seed))) continue;
    std::vector<int> faces{static_cast<int>(seed)};
    seen[seed] = 1;
    double kept = 0, turned = 0;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const int f = faces[i];
      (patches.turn[f] ? turned : kept) += area[f];
      for (const auto& [g, agree] : beside[f]) {
        if (seen[g]) continue;
        seen[g] = 1;
        patches.turn[g] = agree ? patches.turn[f] : !patches.turn[f];
        faces.push_back(g);
      }
    }
    int before = 0, after = 0;  // disagreements; what cannot be oriented keeps its own seam
    for (const int f : faces) {
      for (const auto& [g, agree] : beside[f]) {
        before += !agree;
        after += agree != (patches.turn[f] == patches.turn[g]);
      }
    }
    if (after >= before || turned > kept) {
      for (const int f : faces) patches.turn[f] = after < before && !patches.turn[f];
    }
    patches.faces.push_back(std::move(faces));
  }
  return patches;
}

void turn_faces(Triangles& F, const std::vector<int>& faces) {
  for (const int f : faces) std::swap(F(f, 1), F(f, 2));
}

Points choose_witnesses(const Points& inside) {
  const Eigen::Index step = (inside.rows() + kWitnesses - 1) / kWitnesses;
  Points witnesses((inside.rows() + step - 1) / step, 3);
  for (Eigen::Index k = 0; k < witnesses.rows(); ++k) witnesses.row(k) = inside.row(k * step);
  return witnesses;
}

/// Turns the patches that matter to the witnesses, one after the other while it helps, so that as
/// many witnesses as can be have a winding number of at least kInside. Returns the other patches.
std::vector<const std::vector<int>*> settle_weighty(const Points& V, Triangles& F,
                                                    const Patches& patches,
                                                    const Points& witnesses) {
  constexpr WindingNumberOptions exact{6.0};
  std::vector<const std::vector<int>*> weighty, light;
  std::vector<Vector> part;
  for (const auto& faces : patches.faces) {
    Vector w;
    if (static_cast<int>(faces.size()) > kFragment)
      w = WindingNumber(V, F(faces, Eigen::all), exact).at(witnesses);
    const bool matters = w.size() > 0 && w.cwiseAbs().maxCoeff() >= kWeighty;
    (matters ? weighty : light).push_back(&faces);
    if (matters) part.push_back(std::move(w));
  }
  Vector total = WindingNumber(V, F, exact).at(witnesses);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = 0; p < weighty.size(); ++p) {
      const Vector after = total - 2 * part[p];
      const double gain = (after.cwiseMin(kInside) - total.cwiseMin(kInside)).sum();
      if (gain < kWeighty) continue;
      total = after;
      part[p] = -part[p];
      turn_faces(F, *weighty[p]);
      changed = true;
    }
  }
  return light;
}

/// What the inside points nearest to a small patch see of it: positive if mostly its back. Squares,
/// so that the near and the face-on ones decide; what is hidden behind other faces counts little.
double witness_vote(const Points& V, const Triangles& F, const std::vector<int>& faces,
                    const Vec3& middle, const Points& inside, const NearestPoints& nearest,
                    const RayScene& scene) {
  constexpr double kHidden = 0.1;
  double vote = 0;
  for (const auto& [distance, k] : nearest.at(middle, kNearWitnesses)) {
    const Vec3 x = inside.row(k).transpose();
    double w = 0;
    for (const int f : faces)
      w += solid_angle_fraction(V.row(F(f, 0)).transpose(), V.row(F(f, 1)).transpose(),
                                V.row(F(f, 2)).transpose(), x);
    const bool hidden = scene.occluded(x, middle, 0, 0.02 * distance);
    vote += (hidden ? kHidden : 1) * w * std::abs(w);
  }
  return vote;
}

/// A soup: turns every small patch as the inside points see it, unless the faces agree well enough
/// as they are (then what a few near points see is no better a judge than the input).
void settle_light(const Points& V, Triangles& F, const std::vector<const std::vector<int>*>& light,
                  const Points& inside, const Points& witnesses) {
  constexpr double kAgree = 0.45;  // of the winding number: about a quarter of the faces turned
  constexpr double kNoise = 1e-24;
  const NearestPoints nearest(inside);
  const RayScene scene(V, F);
  std::vector<char> turn(light.size(), 0);
  parallel_for(light.size(), 64, [&](std::size_t p) {
    Vec3 middle = Vec3::Zero();
    for (const int f : *light[p])
      for (int k = 0; k < 3; ++k) middle += V.row(F(f, k)).transpose();
    middle /= 3.0 * static_cast<double>(light[p]->size());
    turn[p] = witness_vote(V, F, *light[p], middle, inside, nearest, scene) < -kNoise;
  });
  Triangles turned = F;
  for (std::size_t p = 0; p < light.size(); ++p)
    if (turn[p]) turn_faces(turned, *light[p]);
  const double before = WindingNumber(V, F).at(witnesses).mean();
  const double after = WindingNumber(V, turned).at(witnesses).mean();
  if (before < kAgree * after) F = std::move(turned);
}

}  // namespace

OrientationRepair repair_orientation(const Points& V, const Triangles& F, const Points& inside) {
  OrientationRepair repair;
  repair.F = F;
  const std::vector<int> place = weld(V).vertex;
  Triangles welded = F;
  for (Eigen::Index i = 0; i < F.size(); ++i) welded.data()[i] = place[F.data()[i]];
  const std::vector<Hinge> hinges = find_hinges(welded);
  for (const Hinge& h : hinges) repair.inconsistent += !h.agree;
  const Patches patches = find_patches(hinges, welded, face_areas(V, F));
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    if (patches.turn[f]) std::swap(repair.F(f, 1), repair.F(f, 2));
  if (inside.rows() > 0 && !patches.faces.empty()) {
    const Points witnesses = choose_witnesses(inside);
    const auto light = settle_weighty(V, repair.F, patches, witnesses);
    if (!light.empty()) settle_light(V, repair.F, light, inside, witnesses);
  }
  repair.flipped = static_cast<int>((repair.F.col(1).array() != F.col(1).array()).count());
  return repair;
}

}  // namespace skinfield
