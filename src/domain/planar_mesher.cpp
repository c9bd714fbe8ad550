#include "skinfield/domain/planar_mesher.h"

#include "skinfield/base/error.h"
#include "skinfield/geometry/plane.h"

#ifdef SKINFIELD_HAVE_CGAL
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#endif

namespace skinfield {

#ifdef SKINFIELD_HAVE_CGAL
namespace {

constexpr const char* kWhere = "outline";
constexpr double kFlat = 1e-6;    // of the diagonal, as Diagnosis has it
constexpr double kSnap = 0.5e-6;  // of the diagonal: a handle's end and a vertex are one
constexpr double kRadiusToEdge =
    0.125;                 // CGAL's bound B: angles of asin(1/2 B^-1/2) = 20.7 degrees
constexpr int kTries = 5;  // to reach the number of nodes
constexpr double kNearEnough = 0.1;
constexpr std::size_t kStepsACheck = 4096;

/// Number of a vertex in PlanarMesh::V.
struct Number {
  int value = -1;
};
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase =
    CGAL::Delaunay_mesh_vertex_base_2<Kernel,
                                      CGAL::Triangulation_vertex_base_with_info_2<Number, Kernel>>;
using FaceBase = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>, CGAL::Exact_predicates_tag>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Triangulation>;
using Point = Kernel::Point_2;
using Vertex = Triangulation::Vertex_handle;
using Face = Triangulation::Face_handle;

/// The outline in its plane; answers what is inside.
class FlatOutline {
 public:
  FlatOutline(const Mesh& mesh, const Plane& plane) : outline_(mesh.outline) {
    for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) p_.push_back(plane.to(mesh.V.row(i)));
    for (const int s : outline_.shape) shapes_ = std::max(shapes_, s + 1);
  }

  const Eigen::Vector2d& point(int v) const { return p_[static_cast<std::size_t>(v)]; }

  /// Even-odd in any shape. Half-open crossings, so that vertices on the ray count once.
  bool inside(const Eigen::Vector2d& x) const {
    std::vector<char> odd(static_cast<std::size_t>(std::max(1, shapes_)), 0);
    for (Eigen::Index e = 0; e < outline_.E.rows(); ++e) {
      const Eigen::Vector2d &a = point(outline_.E(e, 0)), &b = point(outline_.E(e, 1));
      if ((a.y() > x.y()) == (b.y() > x.y())) continue;
      if (x.x() < a.x() + (x.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
        odd[static_cast<std::size_t>(outline_.shape[static_cast<std::size_t>(e)])] ^= 1;
      }
    }
    return std::find(odd.begin(), odd.end(), 1) != odd.end();
  }

 private:
  const Outline& outline_;
  std::vector<Eigen::Vector2d> p_;
  int shapes_ = 0;
};

class Mesher {
 public:
  Mesher(const Mesh& mesh, const std::vector<Handle>& handles, const Plane& plane)
      : mesh_(mesh), plane_(plane), flat_(mesh, plane) {
    snap_ = kSnap * diagonal(bounding_box(mesh.V));
    insert_outline();
    crossings_ = unnumbered();
    for (const Handle& handle : handles) insert_handle(handle);
    mark_inside();
    for (const Face face : cdt_.finite_face_handles()) {
      if (face->is_in_domain()) area_ += std::abs(cdt_.triangle(face).area());
    }
  }

  double area() const { return area_; }

  void refine(double size, std::size_t most, const Progress& progress) {
    CGAL::Delaunay_mesher_2<Triangulation, Criteria> mesher(cdt_, Criteria(kRadiusToEdge, size));
    mesher.init(true);
    for (std::size_t step = 0; mesher.try_one_step_refine_mesh(); ++step) {
      if (step % kStepsACheck == 0) progress.check();
      if (cdt_.number_of_vertices() > most) break;
    }
  }

  PlanarMesh result() {
    std::vector<Vec3> added;
    const auto n = static_cast<int>(mesh_.V.rows());
    std::vector<std::array<int, 3>> faces;
    std::set<int> used;
    for (const Vertex v : cdt_.finite_vertex_handles()) {
      if (v->info().value < 0 && touches_inside(v)) {
        v->info().value = n + static_cast<int>(added.size());
        added.push_back(plane_.from({v->point().x(), v->point().y()}));
      }
    }
    PlanarMesh out;
    for (const Face face : cdt_.finite_face_handles()) {
      if (!face->is_in_domain()) continue;
      faces.push_back({face->vertex(0)->info().value, face->vertex(1)->info().value,
                       face->vertex(2)->info().value});
    }
    out.V.resize(n + static_cast<Eigen::Index>(added.size()), 3);
    out.V.topRows(n) = mesh_.V;
    for (std::size_t i = 0; i < added.size(); ++i) {
      out.V.row(n + static_cast<Eigen::Index>(i)) = added[i].transpose();
    }
    out.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (int c = 0; c < 3; ++c) {
        out.F(static_cast<Eigen::Index>(f), c) = faces[f][static_cast<std::size_t>(c)];
      }
    }
    out.crossings = crossings_;
    return out;
  }

  int vertices_inside() const {
    int count = 0;
    for (const Vertex v : cdt_.finite_vertex_handles()) count += touches_inside(v);
    return count;
  }

 private:
  Vertex at(int v) {
    const auto [found, fresh] = vertex_of_.try_emplace(v);
    if (fresh) {
      found->second = cdt_.insert(Point(flat_.point(v).x(), flat_.point(v).y()), hint_);
      if (found->second->info().value < 0) found->second->info().value = v;
      hint_ = found->second->face();
    }
    return found->second;
  }

  void insert_outline() {
    const Segments& E = mesh_.outline.E;
    // All vertices first: an edge through one is cut there.
    for (Eigen::Index e = 0; e < E.rows(); ++e) at(E(e, 0)), at(E(e, 1));
    for (Eigen::Index e = 0; e < E.rows(); ++e) {
      const Vertex a = at(E(e, 0)), b = at(E(e, 1));
      if (a != b) cdt_.insert_constraint(a, b);
    }
  }

  int unnumbered() const {
    int count = 0;
    for (const Vertex v : cdt_.finite_vertex_handles()) count += v->info().value < 0;
    return count;
  }

  Vertex insert(const Eigen::Vector2d& p) {
    const Point point(p.x(), p.y());
    if (const Vertex near = cdt_.number_of_vertices() > 0 ? nearest(point) : Vertex();
        near != Vertex() && std::sqrt(CGAL::squared_distance(near->point(), point)) <= snap_) {
      return near;
    }
    return cdt_.insert(point);
  }

  /// A vertex of the triangle at the point or around it: enough to find one within snap_.
  Vertex nearest(const Point& point) {
    const Face face = cdt_.locate(point);
    Vertex best;
    double least = 1e300;
    for (int c = 0; c < 3; ++c) {
      const Vertex v = face->vertex(c);
      if (cdt_.is_infinite(v)) continue;
      const double d = CGAL::squared_distance(v->point(), point);
      if (d < least) least = d, best = v;
    }
    return best;
  }

  void insert_handle(const Handle& handle) {
    if (handle.kind == Handle::Kind::point) {
      const Eigen::Vector2d p = plane_.to(handle.point);
      if (flat_.inside(p)) insert(p);
    }
    for (const auto& [from, to] : handle.segments) {
      const Eigen::Vector2d a = plane_.to(from), b = plane_.to(to);
      if (!reaches_inside(a, b)) continue;
      const Vertex first = insert(a), second = insert(b);
      if (first != second) cdt_.insert_constraint(first, second);
    }
  }

  /// Does any part of the segment lie inside? Between the places where it crosses the outline.
  bool reaches_inside(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    std::vector<double> cuts{0, 1};
    const Eigen::Vector2d d = b - a;
    for (Eigen::Index e = 0; e < mesh_.outline.E.rows(); ++e) {
      const Eigen::Vector2d p = flat_.point(mesh_.outline.E(e, 0)) - a;
      const Eigen::Vector2d r = flat_.point(mesh_.outline.E(e, 1)) - a - p;
      const double across = d.x() * r.y() - d.y() * r.x();
      if (across == 0) continue;
      const double t = (p.x() * r.y() - p.y() * r.x()) / across;
      const double s = (p.x() * d.y() - p.y() * d.x()) / across;
      if (t > 0 && t < 1 && s >= 0 && s <= 1) cuts.push_back(t);
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t k = 1; k < cuts.size(); ++k) {
      if (cuts[k] - cuts[k - 1] > 1e-9 && flat_.inside(a + 0.5 * (cuts[k] + cuts[k - 1]) * d)) {
        return true;
      }
    }
    return false;
  }

  /// Regions between constraints are inside or not as a whole; their largest triangle says which.
  void mark_inside() {
    std::set<Face> seen;
    for (const Face start : cdt_.finite_face_handles()) {
      if (!seen.insert(start).second) continue;
      std::vector<Face> region{start};
      Face largest = start;
      double most = -1;
      for (std::size_t k = 0; k < region.size(); ++k) {
        const Face face = region[k];
        const double area = std::abs(cdt_.triangle(face).area());
        if (area > most) most = area, largest = face;
        for (int c = 0; c < 3; ++c) {
          const Face next = face->neighbor(c);
          if (face->is_constrained(c) || cdt_.is_infinite(next)) continue;
          if (seen.insert(next).second) region.push_back(next);
        }
      }
      const Point centre = CGAL::centroid(cdt_.triangle(largest));
      const bool inside = flat_.inside({centre.x(), centre.y()});
      for (const Face face : region) face->set_in_domain(inside);
    }
  }

  bool touches_inside(Vertex v) const {
    auto face = cdt_.incident_faces(v), done = face;
    if (face == nullptr) return false;
    do {
      if (face->is_in_domain()) return true;
    } while (++face != done);
    return false;
  }

  const Mesh& mesh_;
  Plane plane_;
  FlatOutline flat_;
  double snap_ = 0, area_ = 0;
  int crossings_ = 0;
  Triangulation cdt_;
  std::map<int, Vertex> vertex_of_;
  Face hint_;
};

}  // namespace

bool can_mesh_outlines() { return true; }

PlanarMesh mesh_outline(const Mesh& mesh, const std::vector<Handle>& handles,
                        const PlanarMesherOptions& options, const Progress& progress) {
  const auto plane = plane_of(mesh.V, kFlat * diagonal(bounding_box(mesh.V)));
  if (!plane) throw DomainError("the outline does not lie in one plane", kWhere, "flatten it");
  double size = 0;
  for (int tries = 0;; ++tries) {
    progress.check();
    Mesher mesher(mesh, options.nodes > 0 ? handles : std::vector<Handle>(), *plane);
    if (!(mesher.area() > 0)) throw DomainError("the outline has no inside", kWhere);
    if (options.nodes <= 0) return mesher.result();
    // Edges end at about two thirds of the bound, and an equilateral mesh of edge h has a vertex
    // for every sqrt(3)/2 h^2.
    if (tries == 0) size = 1.5 * std::sqrt(mesher.area() / (0.866 * options.nodes));
    mesher.refine(size, 20 * static_cast<std::size_t>(options.nodes) + 100000, progress);
    const double ratio = mesher.vertices_inside() / static_cast<double>(options.nodes);
    if (std::abs(ratio - 1) <= kNearEnough || tries + 1 == kTries) return mesher.result();
    size *= std::clamp(std::sqrt(ratio), 0.25, 4.0);
  }
}

#else

bool can_mesh_outlines() { return false; }

PlanarMesh mesh_outline(const Mesh&, const std::vector<Handle>&, const PlanarMesherOptions&,
                        const Progress&) {
  throw DomainError("outlines need CGAL, which the permissive profile leaves out", "outline",
                    "give the shape as a triangulated OBJ or OFF, or use the full profile");
}

#endif

}  // namespace skinfield
