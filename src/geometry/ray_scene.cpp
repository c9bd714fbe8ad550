// The one file that knows Embree, versions 3.13 and 4.
#include "skinfield/geometry/ray_scene.h"

#include "geometry/line_view.h"
#include "skinfield/base/error.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

constexpr std::size_t kStream = 64;  // occlusion rays handed to Embree at a time: a third faster
constexpr double kNearEdge = 4e-6;   // distance to an edge that single precision cannot judge

#if RTC_VERSION_MAJOR >= 4
using Context = RTCRayQueryContext;
constexpr RTCSceneFlags kFilterFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
void init(Context* context) { rtcInitRayQueryContext(context); }
#else
using Context = RTCIntersectContext;
constexpr RTCSceneFlags kFilterFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
void init(Context* context) { rtcInitIntersectContext(context); }
#endif

/// What the all-hits filter finds behind the context pointer that Embree hands through.
struct CollectContext {
  Context base;  // first, so that the pointers agree
  std::vector<RayHit>* hits;
};

/// Notes the hit and rejects it, so that the ray goes on.
void collect(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const CollectContext*>(args->context);
  if (args->valid[0] != -1) return;
  RayHit hit;
  hit.t = RTCRayN_tfar(args->ray, args->N, 0);
  hit.face = static_cast<int>(RTCHitN_primID(args->hit, args->N, 0));
  hit.u = RTCHitN_u(args->hit, args->N, 0);
  hit.v = RTCHitN_v(args->hit, args->N, 0);
  context->hits->push_back(hit);
  args->valid[0] = 0;
}

void shoot(RTCScene scene, RTCRayHit* ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, ray);
#else
  Context context;
  init(&context);
  rtcIntersect1(scene, &context, ray);
#endif
}

void shoot_all(RTCScene scene, CollectContext* context, RTCRayHit* ray) {
  init(&context->base);
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments args;
  rtcInitIntersectArguments(&args);
  args.context = &context->base;
  args.filter = collect;
  args.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  rtcIntersect1(scene, ray, &args);
#else
  context->base.filter = collect;
  rtcIntersect1(scene, &context->base, ray);
#endif
}

void test(RTCScene scene, RTCRay* ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, ray);
#else
  Context context;
  init(&context);
  rtcOccluded1(scene, &context, ray);
#endif
}

void test_stream(RTCScene scene, RTCRay* rays, std::size_t n) {
#if RTC_VERSION_MAJOR >= 4
  for (std::size_t i = 0; i < n; ++i) rtcOccluded1(scene, rays + i);
#else
  Context context;
  init(&context);
  rtcOccluded1M(scene, &context, rays, static_cast<unsigned>(n), sizeof(RTCRay));
#endif
}

RTCRay make_ray(const Vec3& origin, const Vec3& direction, double t_min, double t_max) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(std::max(t_min, 0.0));
  ray.tfar = static_cast<float>(std::min<double>(t_max, std::numeric_limits<float>::max()));
  ray.mask = ~0u;
  return ray;
}

RTCRayHit make_ray_hit(const Vec3& origin, const Vec3& direction, double t_min, double t_max) {
  RTCRayHit ray{};
  ray.ray = make_ray(origin, direction, t_min, t_max);
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

RayHit read_hit(const RTCRayHit& ray, const Vec3& direction) {
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};  // geomID: a tfar test misreads floats
  RayHit hit;
  hit.t = ray.ray.tfar;
  hit.face = static_cast<int>(ray.hit.primID);
  hit.u = ray.hit.u;
  hit.v = ray.hit.v;
  hit.sign = Vec3(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).dot(direction) < 0 ? 1 : -1;
  return hit;
}

void sort_unique(std::vector<int>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

struct RayScene::Impl {
  // Positions inside are (x - origin) * scale, near the unit box, for the sake of single
  // precision. The scale is a power of two: simple coordinates stay exact.
  Vec3 origin = Vec3::Zero();
  double scale = 1;
  Points V;
  Triangles F;
  std::vector<int> corner_id;                 // vertices at one place share it
  std::vector<int> first_face, faces_around;  // per corner id, those with area
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  bool empty = true;

  Impl(const Points& vertices, const Triangles& faces) : F(faces) {
    normalise(vertices);
    link_corners();
    device = rtcNewDevice(nullptr);
    if (!device) throw SolveError("Embree gives no device", "rays");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | kFilterFlag));
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    upload(geometry);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) {
      release();
      throw SolveError("Embree cannot build its hierarchy", "rays", "is there enough memory?");
    }
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { release(); }

  void release() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
    scene = nullptr;
    device = nullptr;
  }

  void normalise(const Points& vertices) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
      const Vec3 x = vertices.row(i).transpose();
      if (!x.allFinite()) continue;
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    const double side = (high - low).maxCoeff();
    if (side >= 0) origin = low + (high - low) / 2;
    if (side > 0) scale = std::exp2(-std::ceil(std::log2(side)));
    V = (vertices.rowwise() - origin.transpose()) * scale;
  }

  Vec3 corner(Eigen::Index f, int k) const { return V.row(F(f, k)).transpose(); }
  bool has_area(Eigen::Index f) const {
    const Vec3 a = corner(f, 0);
    const double area = (corner(f, 1) - a).cross(corner(f, 2) - a).norm();
    return area > 0 && std::isfinite(area);
  }
  Vec3 map(const Vec3& x) const { return (x - origin) * scale; }

  void upload(RTCGeometry geometry) {
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), static_cast<std::size_t>(V.rows()) + 1));
    auto* corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), static_cast<std::size_t>(F.rows())));
    if (!positions || (!corners && F.rows() > 0)) {
      rtcReleaseGeometry(geometry);
      release();
      throw SolveError("Embree cannot hold the triangles", "rays", "is there enough memory?");
    }
    for (Eigen::Index i = 0; i < V.rows(); ++i)
      for (int k = 0; k < 3; ++k) positions[3 * i + k] = static_cast<float>(V(i, k));
    // The extra vertex is not a number: faces left out point to it, which Embree skips.
    const auto nowhere = static_cast<unsigned>(V.rows());
    for (int k = 0; k < 3; ++k)
      positions[3 * nowhere + k] = std::numeric_limits<float>::quiet_NaN();
    for (Eigen::Index f = 0; f < F.rows(); ++f) {
      const bool fine = has_area(f);
      for (int k = 0; k < 3; ++k)
        corners[3 * f + k] = fine ? static_cast<unsigned>(F(f, k)) : nowhere;
      empty = empty && !fine;
    }
  }

  void link_corners();
  void collect_hits(const Vec3& from, const Vec3& direction, std::vector<RayHit>& hits) const {
    CollectContext context;
    context.hits = &hits;
    RTCRayHit ray = make_ray_hit(from, direction, 0, 1);
    shoot_all(scene, &context, &ray);
  }
  bool crosses(int f, const LineView& view, const Vec3& a, const Vec3& direction,
               RayHit& hit) const;
  void settle_edges(const Vec3& a, const Vec3& direction, std::vector<RayHit>& hits) const;
};

void RayScene::Impl::link_corners() {
  corner_id = weld(V).vertex;
  first_face.assign(V.rows() + 1, 0);
  const auto each_corner = [&](const auto& visit) {
    for (Eigen::Index f = 0; f < F.rows(); ++f)
      if (has_area(f))
        for (int k = 0; k < 3; ++k) visit(corner_id[F(f, k)], static_cast<int>(f));
  };
  each_corner([&](int c, int) { ++first_face[c + 1]; });
  for (std::size_t c = 1; c < first_face.size(); ++c) first_face[c] += first_face[c - 1];
  faces_around.resize(first_face.back());
  std::vector<int> at(first_face.begin(), first_face.end() - 1);
  each_corner([&](int c, int f) { faces_around[at[c]++] = f; });
}

/// The exact test in double precision: of the faces around an edge or a corner that the line
/// meets, those say yes that a line moved by nothing at all would cross.
bool RayScene::Impl::crosses(int f, const LineView& view, const Vec3& a, const Vec3& direction,
                             RayHit& hit) const {
  double inner[3];
  int sides = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 p = corner(f, (k + 1) % 3), q = corner(f, (k + 2) % 3);
    inner[k] = (p - a).cross(q - a).dot(direction);
    sides += view.side(view(p), view(q));
  }
  const Vec3 p = corner(f, 0);
  const Vec3 n = (corner(f, 1) - p).cross(corner(f, 2) - p);
  const double slope = n.dot(direction), sum = inner[0] + inner[1] + inner[2];
  if (std::abs(sides) != 3 || slope == 0) return false;
  hit.t = n.dot(p - a) / slope;
  hit.face = f;
  hit.u = sum != 0 ? std::clamp(inner[1] / sum, 0.0, 1.0) : 0;
  hit.v = sum != 0 ? std::clamp(inner[2] / sum, 0.0, 1 - hit.u) : 0;
  hit.sign = sides < 0 ? 1 : -1;
  return hit.t >= 0 && hit.t <= 1;
}

/// Near an edge or corner, single precision may report all faces around it or only some. There
/// test every face around the corners concerned anew, so that crossings add up.
void RayScene::Impl::settle_edges(const Vec3& a, const Vec3& direction,
                                  std::vector<RayHit>& hits) const {
  std::vector<int> corners, faces;
  for (const RayHit& hit : hits) {
    for (int k = 0; k < 3; ++k) {
      const int i = F(hit.face, (k + 1) % 3), j = F(hit.face, (k + 2) % 3);
      const Vec3 p = V.row(i).transpose(), q = V.row(j).transpose();
      const double distance = std::abs((p - a).cross(q - a).dot(direction));
      if (distance > kNearEdge * direction.cross(q - p).norm()) continue;
      corners.push_back(corner_id[i]);
      corners.push_back(corner_id[j]);
    }
  }
  sort_unique(corners);
  for (const int c : corners)
    faces.insert(faces.end(), faces_around.begin() + first_face[c],
                 faces_around.begin() + first_face[c + 1]);
  if (faces.empty()) return;
  sort_unique(faces);
  std::erase_if(hits, [&](const RayHit& hit) {
    return std::binary_search(faces.begin(), faces.end(), hit.face);
  });
  const LineView view(a, direction);
  RayHit hit;
  for (const int f : faces)
    if (crosses(f, view, a, direction, hit)) hits.push_back(hit);
}

RayScene::RayScene(const Points& V, const Triangles& F) : impl_(std::make_unique<Impl>(V, F)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

bool RayScene::empty() const { return impl_->empty; }

bool RayScene::occluded(const Vec3& a, const Vec3& b, double skip_a, double skip_b) const {
  const double length = (b - a).norm();
  if (!(length > skip_a + skip_b)) return false;
  RTCRay ray =
      make_ray(impl_->map(a), (b - a) * impl_->scale, skip_a / length, 1 - skip_b / length);
  test(impl_->scene, &ray);
  return ray.tfar < 0;
}

void RayScene::occluded(const Vec3& a, std::span<const Vec3> b,
                        std::span<unsigned char> blocked) const {
  alignas(16) std::array<RTCRay, kStream> rays;
  const Vec3 from = impl_->map(a);
  for (std::size_t start = 0; start < b.size(); start += kStream) {
    const std::size_t n = std::min(kStream, b.size() - start);
    for (std::size_t i = 0; i < n; ++i)
      rays[i] = make_ray(from, (b[start + i] - a) * impl_->scale, 0, 1);
    test_stream(impl_->scene, rays.data(), n);
    for (std::size_t i = 0; i < n; ++i) blocked[start + i] = rays[i].tfar < 0;
  }
}

RayHit RayScene::first_hit(const Vec3& origin, const Vec3& direction, double t_min,
                           double t_max) const {
  RTCRayHit ray = make_ray_hit(impl_->map(origin), direction * impl_->scale, t_min, t_max);
  shoot(impl_->scene, &ray);
  return read_hit(ray, direction);
}

void RayScene::first_hits(const Vec3& origin, std::span<const Vec3> directions,
                          std::span<const double> t_max, std::span<RayHit> hits) const {
  // One by one: Embree's streams of first hits measure a quarter slower than that.
  const Vec3 from = impl_->map(origin);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    RTCRayHit ray = make_ray_hit(from, directions[i] * impl_->scale, 0, t_max[i]);
    shoot(impl_->scene, &ray);
    hits[i] = read_hit(ray, directions[i]);
  }
}

void RayScene::faces_along(const Vec3& a, const Vec3& b, std::vector<int>& faces) const {
  std::vector<RayHit> hits;
  impl_->collect_hits(impl_->map(a), (b - a) * impl_->scale, hits);
  faces.clear();
  for (const RayHit& hit : hits) faces.push_back(hit.face);
}

void RayScene::all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const {
  hits.clear();
  const Vec3 from = impl_->map(a), direction = (b - a) * impl_->scale;
  if (!(direction.squaredNorm() > 0)) return;
  impl_->collect_hits(from, direction, hits);
  for (RayHit& hit : hits) {
    // Sheets closer than single precision resolves still come in the right order.
    const Vec3 p = impl_->corner(hit.face, 0);
    const Vec3 n = (impl_->corner(hit.face, 1) - p).cross(impl_->corner(hit.face, 2) - p);
    const double slope = n.dot(direction);
    hit.sign = slope < 0 ? 1 : -1;
    const double t = slope != 0 ? n.dot(p - from) / slope : hit.t;
    if (std::abs(t - hit.t) < 1e-4) hit.t = std::clamp(t, 0.0, 1.0);
  }
  impl_->settle_edges(from, direction, hits);
  std::sort(hits.begin(), hits.end(), [](const RayHit& x, const RayHit& y) {
    return x.t != y.t ? x.t < y.t : x.face < y.face;
  });
}

}  // namespace skinfield
