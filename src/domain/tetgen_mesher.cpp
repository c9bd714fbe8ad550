#include "domain/tetgen_mesher.h"

#include "domain/element_bytes.h"
#include "domain/shielded.h"

#ifdef SKINFIELD_HAVE_TETGEN
#define TETLIBRARY
#include <tetgen.h>

#include <cstdio>
#include <stdexcept>
#endif

namespace skinfield {

#ifdef SKINFIELD_HAVE_TETGEN
namespace {

/// terminatetetgen's codes.
const char* meaning(int code) {
  switch (code) {
    case 1:
      return "out of memory";
    case 3:
      return "the surface intersects itself";
    case 4:
      return "a feature is too small";
    case 5:
      return "two faces lie nearly on each other";
    default:
      return "an internal error";
  }
}

void fill_points(const Points& X, tetgenio& io) {
  io.numberofpoints = static_cast<int>(X.rows());
  io.pointlist = new REAL[static_cast<std::size_t>(X.size())];  // tetgenio's destructor frees it
  std::copy(X.data(), X.data() + X.size(), io.pointlist);
}

void fill_facets(const Triangles& F, tetgenio& io) {
  io.numberoffacets = static_cast<int>(F.rows());
  io.facetlist = new tetgenio::facet[static_cast<std::size_t>(F.rows())];
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    tetgenio::facet& facet = io.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    for (int c = 0; c < 3; ++c) polygon.vertexlist[c] = F(f, c);
  }
}

/// In the child.
std::string tetgen(const TetgenInput& input) {
  tetgenio in, out;
  in.firstnumber = 0;
  // Points that no face names become vertices as they are. (The switch i, which adds points to a
  // finished mesh, crashes on one surface in five.)
  Points all_points(input.V.rows() + input.inside.rows(), 3);
  all_points << input.V, input.inside;
  fill_points(all_points, in);
  fill_facets(input.F, in);
  // p: the surface bounds it. Y: no new vertices on it (without, fine and thin surfaces end in five
  // times the tets, or never). J: keep every vertex, so that numbers stay. Q: say nothing.
  char switches[128];
  std::snprintf(switches, sizeof switches, "pYJQq%.3g/%.3g", input.radius_edge, input.min_dihedral);
  std::string all = switches;
  if (input.max_volume > 0) {
    std::snprintf(switches, sizeof switches, "a%.12f", input.max_volume);
    all += switches;
  }
  try {
    tetrahedralize(all.data(), &in, &out);
  } catch (int code) {
    throw std::runtime_error(meaning(code));
  }
  if (out.numberoftetrahedra <= 0) throw std::runtime_error("the surface encloses nothing");
  const Points V = Eigen::Map<const Points>(out.pointlist, out.numberofpoints, 3);
  Tetrahedra T(out.numberoftetrahedra, 4);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int c = 0; c < 4; ++c) T(t, c) = out.tetrahedronlist[t * out.numberofcorners + c];
  }
  std::string bytes;
  append_bytes(V, bytes);
  append_bytes(T, bytes);
  return bytes;
}

}  // namespace

bool have_tetgen() { return true; }

TetgenOutput run_tetgen(const TetgenInput& input, const Progress& progress) {
  TetgenOutput output;
  const Shielded made =
      run_shielded([&input] { return tetgen(input); }, input.time_limit_s, progress);
  output.good = made.good;
  output.why = made.why;
  if (!made.good) return output;
  std::size_t at = 0;
  output.V = take_bytes<Points>(made.bytes, at);
  output.T = take_bytes<Tetrahedra>(made.bytes, at);
  for (Eigen::Index t = 0; t < output.T.rows(); ++t) {
    const auto corner = [&](int c) { return Vec3(output.V.row(output.T(t, c)).transpose()); };
    const Vec3 a = corner(0);
    // TetGen's own order is the other way round.
    if ((corner(1) - a).cross(corner(2) - a).dot(corner(3) - a) < 0) {
      std::swap(output.T(t, 2), output.T(t, 3));
    }
  }
  // J keeps numbers: checked, as rows would go to wrong vertices.
  if (output.V.rows() < input.V.rows() || output.V.topRows(input.V.rows()) != input.V) {
    output.good = false;
    output.why = "its vertices are not the surface's";
  }
  return output;
}

#else

bool have_tetgen() { return false; }

TetgenOutput run_tetgen(const TetgenInput&, const Progress&) {
  TetgenOutput output;
  output.why = "this build has no TetGen";
  return output;
}

#endif

}  // namespace skinfield
