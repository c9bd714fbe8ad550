#include "skinfield/domain/field_conditions.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace skinfield {
namespace {

constexpr double piece_length = 0.01;  // of bones, for their visibility; unit box
constexpr int most_pieces = 400;
constexpr double inward_step = 1e-4;  // from the surface, for rays to painted places
constexpr double beside_wall = 1e-4;  // a wall's outer side is asked this far from it

/// The part of segment a-b within `reach` of x, as parameters; false if there is none.
bool clip(const Vec3& a, const Vec3& b, const Vec3& x, double reach, double& t0, double& t1) {
  const Vec3 d = b - a;
  const double length2 = d.squaredNorm();
  t0 = 0, t1 = 1;
  if (!(length2 > 0)) return (x - a).squaredNorm() < reach * reach;
  const double t = (x - a).dot(d) / length2;
  const double off2 = (a + t * d - x).squaredNorm();
  if (off2 >= reach * reach) return false;
  const double half = std::sqrt((reach * reach - off2) / length2);
  t0 = std::max(0.0, t - half), t1 = std::min(1.0, t + half);
  return t0 < t1;
}

}  // namespace

double bump(double distance, double epsilon) {
  if (!(distance < epsilon)) return 0;
  const double t = distance * distance / (epsilon * epsilon);
  if (!(t > 0)) return 1;
  // w = 1 - w'(t), w' = exp(-1/t) / (exp(-1/t) + exp(-1/(1-t)))
  return 1 / (1 + std::exp(1 / (1 - t) - 1 / t));
}

FieldConditions::FieldConditions(const Solid& solid, const Mesh& mesh,
                                 const std::vector<Handle>& handles, const PaintedVertices& paint,
                                 bool neumann)
    : solid_(solid) {
  const auto k = static_cast<Eigen::Index>(paint.vertex.size());
  if (paint.weights.rows() != k)
    throw InputError("there are " + std::to_string(paint.weights.rows()) + " painted rows for " +
                     std::to_string(k) + " vertices");
  const auto columns =
      handles.empty() ? paint.weights.cols() : static_cast<Eigen::Index>(handles.size());
  if (k > 0 && paint.weights.cols() != columns)
    throw InputError("painted rows have " + std::to_string(paint.weights.cols()) + " columns for " +
                     std::to_string(columns) + " handles");
  bound_.assign(static_cast<std::size_t>(columns), 0);

  std::map<int, Vector> painted;  // by vertex
  const auto put = [&](int v, Vector row) {
    if (v < 0 || v >= mesh.V.rows())
      throw InputError("painted vertex " + std::to_string(v) + " does not exist");
    for (Eigen::Index c = 0; c < row.size(); ++c)
      if (row[c] > 0) bound_[static_cast<std::size_t>(c)] = 1;
    painted[v] = std::move(row);
  };
  const InsideTest inside = [&](const Vec3& x) { return solid.inside(x); };
  for (std::size_t h = 0; h < handles.size(); ++h) {
    for (int v : handles[h].vertices) put(v, Vector::Unit(columns, static_cast<Eigen::Index>(h)));
    if (handles[h].kind == Handle::Kind::region) continue;
    HandleInside part = inside_part(handles[h], inside);
    if (handles[h].kind == Handle::Kind::point && part.place == HandlePlace::inside)
      part.segments = {{handles[h].point, handles[h].point}};
    for (const auto& [a, b] : part.segments) {
      segments_.emplace_back(a, b);
      bound_[h] = 1;
      Segment segment{static_cast<int>(h), a, b, {}};
      const int pieces =
          std::clamp(static_cast<int>(std::ceil((b - a).norm() / piece_length)), 1, most_pieces);
      for (int p = 0; p < pieces; ++p)
        segment.sites.push_back(solid.site(a + (b - a) * ((p + 0.5) / pieces)));
      handles_.push_back(std::move(segment));
    }
  }
  for (Eigen::Index i = 0; i < k; ++i)
    put(paint.vertex[static_cast<std::size_t>(i)], paint.weights.row(i).transpose());

  if (!painted.empty()) {
    paint_row_.assign(static_cast<std::size_t>(mesh.V.rows()), -1);
    paint_weights_.resize(static_cast<Eigen::Index>(painted.size()), columns);
    inward_ = mesh.V;
    int row = 0;
    for (const auto& [v, weights] : painted) {
      paint_row_[static_cast<std::size_t>(v)] = row;
      paint_weights_.row(row++) = weights.transpose();
      const Vec3 x = mesh.V.row(v).transpose();
      for (const double step : {-inward_step, inward_step, -10 * inward_step}) {
        if (solid.normals().rows() <= v) break;
        const Vec3 in = x + step * solid.normals().row(v).transpose();
        if (!solid.inside(in)) continue;
        inward_.row(v) = in.transpose();
        break;
      }
    }
    std::vector<Eigen::Vector3i> faces;
    for (Eigen::Index f = 0; f < mesh.F.rows(); ++f)
      if (painted.count(mesh.F(f, 0)) && painted.count(mesh.F(f, 1)) && painted.count(mesh.F(f, 2)))
        faces.emplace_back(mesh.F(f, 0), mesh.F(f, 1), mesh.F(f, 2));
    if (solid.dimension() == 2) {
      const Triangles& E = solid.faces();
      for (Eigen::Index e = 0; e < E.rows(); ++e)
        if (painted.count(E(e, 0)) && painted.count(E(e, 1)))
          faces.emplace_back(E(e, 0), E(e, 1), E(e, 1));
    }
    for (const auto& entry : painted) faces.emplace_back(Eigen::Vector3i::Constant(entry.first));
    painted_faces_.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
      painted_faces_.row(static_cast<Eigen::Index>(f)) = faces[f].transpose();
    painted_.emplace(mesh.V, painted_faces_);
  }

  if (neumann && solid.faces().rows() > 0) {
    // Walls of the union: faces inside another part are none.
    const Points& V = solid.vertices();
    const Triangles& F = solid.faces();
    std::vector<char> outer(static_cast<std::size_t>(F.rows()), 0);
    const double beside = std::max(beside_wall, 2 * solid.facts().epsilon);
    parallel_for(outer.size(), 64, [&](std::size_t i) {
      const auto f = static_cast<Eigen::Index>(i);
      const Vec3 a = V.row(F(f, 0)).transpose(), b = V.row(F(f, 1)).transpose();
      const Vec3 c = V.row(F(f, 2)).transpose();
      const Vec3 across = solid.dimension() == 2 ? Vec3::UnitZ() : Vec3(c - a);
      const Vec3 n = (b - a).cross(across).normalized();
      outer[i] = !solid.inside(Vec3((a + b + c) / 3 + beside * n));
    });
    Triangles W(std::count(outer.begin(), outer.end(), 1), 3);
    Eigen::Index next = 0;
    for (std::size_t i = 0; i < outer.size(); ++i)
      if (outer[i]) W.row(next++) = F.row(static_cast<Eigen::Index>(i));
    walls_.emplace(V, W);
  }
}

void FieldConditions::look(const Site& from, double reach, View& view) const {
  view.from = from;
  view.pieces.clear();
  const bool clear = !solid_.has_dirty() && from.clearance >= reach;
  for (const Segment& s : handles_) {
    double t0, t1;
    if (!clip(s.a, s.b, from.x, reach, t0, t1)) continue;
    const Vec3 d = s.b - s.a;
    if (clear) {
      view.pieces.push_back({s.column, s.a + t0 * d, s.a + t1 * d});
      continue;
    }
    const auto count = static_cast<double>(s.sites.size());
    const int first = static_cast<int>(t0 * count);
    const int last = std::min(static_cast<int>(t1 * count), static_cast<int>(s.sites.size()) - 1);
    for (int p = first; p <= last; ++p) {
      if (solid_.blocked(from, s.sites[static_cast<std::size_t>(p)])) continue;
      const double u0 = std::max(t0, p / count), u1 = std::min(t1, (p + 1) / count);
      view.pieces.push_back({s.column, s.a + u0 * d, s.a + u1 * d});
    }
  }
}

bool FieldConditions::touches(const Site& from, double reach) const {
  View view;
  look(from, reach, view);
  if (!view.pieces.empty()) return true;
  if (!painted_) return false;
  const ClosestPoint found = painted_->at(from.x, reach);
  return found.face >= 0 && sees_paint(from, found);
}

bool FieldConditions::sees_paint(const Site& from, const ClosestPoint& place) const {
  Vec3 look = Vec3::Zero();
  for (int c = 0; c < 3; ++c)
    look += place.barycentric[c] * inward_.row(painted_faces_(place.face, c)).transpose();
  // Places on the surface itself are where they are looked at from.
  return (look - from.x).norm() <= 2 * inward_step ||
         !solid_.blocked(from, solid_.site_near(from, look));
}

bool FieldConditions::paint_at(const View& view, const Vec3& x, Prescribed& result,
                               double& weight) const {
  const double radius = radii_.dirichlet * grading_.at(x);
  const ClosestPoint found = painted_->at(x, radius);
  if (found.face < 0 || !(found.distance < radius)) return false;
  if (!sees_paint(view.from, found)) return false;
  weight = bump(found.distance, radius);
  for (Eigen::Index j = 0; j < paint_weights_.cols(); ++j) {
    double g = 0;
    for (int c = 0; c < 3; ++c)
      g += found.barycentric[c] *
           paint_weights_(paint_row_[static_cast<std::size_t>(painted_faces_(found.face, c))], j);
    if (g > 0) result.value.emplace_back(static_cast<int>(j), weight * g);
  }
  return true;
}

void FieldConditions::at(const View& view, const Vec3& x, Prescribed& result) const {
  result.free = 1;
  result.value.clear();
  double paint = 0;
  if (painted_ && radii_.dirichlet > 0 && paint_at(view, x, result, paint)) result.free -= paint;
  if (view.pieces.empty()) return;
  // Equation 15; pieces of one handle come one after another.
  const double radius = radii_.lagrange * grading_.at(x);
  const std::size_t first = result.value.size();
  double largest = 0, sum = 0;
  for (std::size_t p = 0; p < view.pieces.size();) {
    const int column = view.pieces[p].column;
    double distance = 1e300;
    for (; p < view.pieces.size() && view.pieces[p].column == column; ++p)
      distance = std::min(distance, distance_to_segment(view.pieces[p].a, view.pieces[p].b, x));
    const double w = bump(distance, radius);
    if (w == 0) continue;
    result.value.emplace_back(column, w);
    largest = std::max(largest, w);
    sum += w;
  }
  if (sum == 0) return;
  for (std::size_t i = first; i < result.value.size(); ++i)
    result.value[i].second *= (1 - paint) * largest / sum;
  result.free = (1 - paint) * (1 - largest);
}

bool FieldConditions::wall(const Vec3& x, Vec3& p, double& weight) const {
  if (!walls_ || !(radii_.neumann > 0)) return false;
  const ClosestPoint found = walls_->at(x, radii_.neumann);
  if (found.face < 0) return false;
  p = found.point;
  weight = bump(found.distance, radii_.neumann);
  return weight > 0;
}

}  // namespace skinfield
