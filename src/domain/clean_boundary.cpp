#include "domain/clean_boundary.h"

#include "skinfield/geometry/closest_point.h"
#include "skinfield/geometry/segment_scene.h"
#include "skinfield/geometry/winding_number.h"

namespace skinfield {
namespace {

class TriangleBoundary final : public CleanBoundary {
 public:
  TriangleBoundary(const Points& V, const Triangles& F, double accuracy)
      : scene_(V, F), winding_(V, F, WindingNumberOptions{accuracy}), closest_(V, F) {}

  bool occluded(const Vec3& a, const Vec3& b) const override { return scene_.occluded(a, b); }
  void all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const override {
    scene_.all_hits(a, b, hits);
  }
  void first_hits(const Vec3& origin, std::span<const Vec3> directions,
                  std::span<const double> t_max, std::span<RayHit> hits) const override {
    scene_.first_hits(origin, directions, t_max, hits);
  }
  double winding(const Vec3& x) const override { return winding_.at(x); }
  double distance(const Vec3& x) const override { return closest_.at(x).distance; }

 private:
  RayScene scene_;
  WindingNumber winding_;
  ClosestPointQuery closest_;
};

Segments both(const Segments& a, const Segments& b) {
  Segments all(a.rows() + b.rows(), 2);
  all << a, b;
  return all;
}

/// As triangles of no width, for closest points.
Triangles thin(const Segments& E) {
  Triangles F(E.rows(), 3);
  F << E, E.col(1);
  return F;
}

class SegmentBoundary final : public CleanBoundary {
 public:
  SegmentBoundary(const Points& V, const Segments& closed, const Segments& open)
      : scene_(V, both(closed, open)),
        closed_(V, closed),
        closest_(V, thin(both(closed, open))),
        V_(V),
        open_(open) {}

  bool occluded(const Vec3& a, const Vec3& b) const override { return scene_.occluded(a, b); }
  void all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const override {
    scene_.all_hits(a, b, hits);
  }
  void first_hits(const Vec3& origin, std::span<const Vec3> directions,
                  std::span<const double> t_max, std::span<RayHit> hits) const override {
    for (std::size_t i = 0; i < directions.size(); ++i)
      hits[i] = scene_.first_hit(origin, directions[i], t_max[i]);
  }
  double winding(const Vec3& x) const override {
    return closed_.winding(x) + winding_number_of_segments(V_, open_, x);
  }
  double distance(const Vec3& x) const override { return closest_.at(x).distance; }

 private:
  SegmentScene scene_, closed_;
  ClosestPointQuery closest_;
  Points V_;
  Segments open_;
};

}  // namespace

std::unique_ptr<CleanBoundary> boundary_of_triangles(const Points& V, const Triangles& F,
                                                     double accuracy) {
  return std::make_unique<TriangleBoundary>(V, F, accuracy);
}

std::unique_ptr<CleanBoundary> boundary_of_segments(const Points& V, const Segments& closed,
                                                    const Segments& open) {
  return std::make_unique<SegmentBoundary>(V, closed, open);
}

}  // namespace skinfield
