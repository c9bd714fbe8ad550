#include "domain/alpha_wrap.h"

#include "domain/element_bytes.h"
#include "domain/shielded.h"

#ifdef SKINFIELD_HAVE_CGAL
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <stdexcept>
#include <vector>
#endif

namespace skinfield {

#ifdef SKINFIELD_HAVE_CGAL
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Wrapped = CGAL::Surface_mesh<Kernel::Point_3>;

/// In the child.
std::string wrap(const Mesh& mesh, double alpha, double offset) {
  std::vector<Kernel::Point_3> points;
  points.reserve(static_cast<std::size_t>(mesh.V.rows()));
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) {
    points.emplace_back(mesh.V(i, 0), mesh.V(i, 1), mesh.V(i, 2));
  }
  Wrapped wrapped;
  if (mesh.F.rows() > 0) {
    std::vector<std::array<std::size_t, 3>> faces(static_cast<std::size_t>(mesh.F.rows()));
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (int c = 0; c < 3; ++c) {
        faces[f][static_cast<std::size_t>(c)] =
            static_cast<std::size_t>(mesh.F(static_cast<Eigen::Index>(f), c));
      }
    }
    CGAL::alpha_wrap_3(points, faces, alpha, offset, wrapped);
  } else {
    CGAL::alpha_wrap_3(points, alpha, offset, wrapped);
  }
  if (wrapped.number_of_faces() == 0) throw std::runtime_error("the wrap is empty");
  std::vector<std::int32_t> number(wrapped.num_vertices(), -1);
  Points V(static_cast<Eigen::Index>(wrapped.number_of_vertices()), 3);
  std::int32_t next = 0;
  for (const auto v : wrapped.vertices()) {
    const Kernel::Point_3& p = wrapped.point(v);
    V.row(next) << p.x(), p.y(), p.z();
    number[static_cast<std::size_t>(v)] = next++;
  }
  Triangles F(static_cast<Eigen::Index>(wrapped.number_of_faces()), 3);
  Eigen::Index row = 0;
  for (const auto f : wrapped.faces()) {
    int c = 0;
    for (const auto v : wrapped.vertices_around_face(wrapped.halfedge(f))) {
      F(row, c++) = number[static_cast<std::size_t>(v)];
    }
    ++row;
  }
  std::string bytes;
  append_bytes(V, bytes);
  append_bytes(F, bytes);
  return bytes;
}

}  // namespace

bool have_alpha_wrap() { return true; }

AlphaWrap alpha_wrap(const Mesh& mesh, double alpha, double offset, double time_limit_s,
                     const Progress& progress) {
  AlphaWrap result;
  const Shielded made =
      run_shielded([&] { return wrap(mesh, alpha, offset); }, time_limit_s, progress);
  result.good = made.good;
  result.why = made.why;
  if (!made.good) return result;
  std::size_t at = 0;
  result.surface.V = take_bytes<Points>(made.bytes, at);
  result.surface.F = take_bytes<Triangles>(made.bytes, at);
  return result;
}

#else

bool have_alpha_wrap() { return false; }

AlphaWrap alpha_wrap(const Mesh&, double, double, double, const Progress&) {
  AlphaWrap result;
  result.why = "this build has no CGAL";
  return result;
}

#endif

}  // namespace skinfield
