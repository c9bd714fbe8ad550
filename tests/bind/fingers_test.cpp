// The fingers of a whole human (the geometric-fields paper's open failure, its figure 19): thin
// parts far smaller than the body keep their weights to themselves, and bend where the joints are.
#include "bind/fixtures.h"
#include "skinfield/io/file.h"
#include "skinfield/io/tgf.h"
#include "skinfield/rig/handle_geometry.h"
#include "support/data.h"

#include <numeric>

namespace skinfield {
namespace {

using namespace skinfield_test;

constexpr int fingers = 5;

/// The skeleton of surface/human_man with two bones in each finger of the left hand, after its own.
Skeleton with_fingers(const std::filesystem::path& tgf) {
  const std::string text = read_file(tgf);
  const std::size_t bones = text.find('#');
  std::string joints = text.substr(0, bones), lines = "#\n" + text.substr(bones + 2);
  lines.resize(lines.rfind('#'));
  const char* places[fingers][3] = {
      {"0.78725 1.42694 0.01141", "0.81212 1.42538 0.02794", "0.82455 1.42692 0.04265"},
      {"0.83321 1.43658 -0.02566", "0.86766 1.43720 -0.02155", "0.90345 1.43461 -0.02206"},
      {"0.84137 1.44131 -0.05169", "0.87994 1.43975 -0.05744", "0.91479 1.43823 -0.06058"},
      {"0.82727 1.43711 -0.07187", "0.85993 1.43733 -0.08068", "0.89588 1.43672 -0.08935"},
      {"0.80935 1.43209 -0.09385", "0.82920 1.43339 -0.10624", "0.85752 1.43016 -0.12144"}};
  int joint = 22;
  for (const auto& finger : places) {
    for (const char* place : finger) joints += std::to_string(++joint) + " " + place + "\n";
    for (const int tip : {joint - 1, joint})
      lines += std::to_string(tip - 1) + " " + std::to_string(tip) + " 1 0 0\n";
  }
  return parse_tgf(joints + lines, "fingers");
}

TEST(FieldFingers, KeepToThemselvesOnAWholeHuman) {
  SKINFIELD_NEEDS_DATA(body, "surface/human_man.obj");
  SKINFIELD_NEEDS_DATA(bones, "surface/human_man.tgf");
  const Character c = read_case(body, with_fingers(bones));
  const auto handles = static_cast<int>(c.skeleton.handles.size());
  const int first = handles - 2 * fingers;
  BindOptions options;
  options.method = Method::geometric_fields;
  options.field_points = 1 << 12;
  const BindResult result = bound(c, options);
  const BindResult reference = bound(c, quick(8000));
  std::vector<int> seen(fingers, 0);
  double apart = 0;
  for (Eigen::Index v = 0; v < c.mesh.V.rows(); ++v) {
    // The outer half of a finger: what is nearest to its outer bone.
    int nearest = -1;
    double least = 0.02;
    for (int h = first; h < handles; ++h) {
      const double d = handle_distance(c.skeleton.handles[static_cast<std::size_t>(h)],
                                       c.mesh.V.row(v).transpose(), c.mesh.V);
      if (d < least) least = d, nearest = h;
    }
    if (nearest < 0 || (nearest - first) % 2 == 0) continue;
    const int finger = (nearest - first) / 2;
    ++seen[static_cast<std::size_t>(finger)];
    double others = 0;
    for (int h = first; h < handles; ++h)
      if ((h - first) / 2 != finger) others += result.weights.W.coeff(v, h);
    EXPECT_LT(others, 0.05) << "vertex " << v << " of finger " << finger;
    apart += 0.5 * (RowMatrix(result.weights.W.row(v)) - RowMatrix(reference.weights.W.row(v)))
                       .cwiseAbs()
                       .sum();
  }
  // Points of one density everywhere leave the fingers all but rigid: 0.07 and more.
  EXPECT_LT(apart / std::accumulate(seen.begin(), seen.end(), 0.0), 0.05);
  for (const int count : seen) EXPECT_GT(count, 30);
}

}  // namespace
}  // namespace skinfield
