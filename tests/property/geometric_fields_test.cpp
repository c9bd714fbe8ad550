// Geometric fields against exact weights on refined tetrahedra, where the shared data is.
#include "skinfield/methods/geometric_fields.h"

#include "skinfield/io/file.h"
#include "skinfield/io/io.h"
#include "skinfield/io/npy.h"
#include "skinfield/rig/handles.h"
#include "support/data.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

TEST(GeometricFieldsOnTheHand, ConvexIsNearExactWeights) {
  SKINFIELD_NEEDS_DATA(mesh_file, "fem/hand.mesh");
  SKINFIELD_NEEDS_DATA(skeleton_file, "fem/hand.tgf");
  SKINFIELD_NEEDS_DATA(reference_file, "fem/hand-refined-bbw.npz");
  Mesh mesh = read_asset(mesh_file).characters.at(0).mesh;
  Skeleton skeleton = read_skeleton(skeleton_file);
  make_tgf_handles(skeleton);
  const UnitBox box = unit_box(mesh.V);
  mesh.V = box.to(mesh.V);
  mesh.T.resize(0, 4);
  for (Handle& h : skeleton.handles)
    for (auto& [a, b] : h.segments) a = box.to(a), b = box.to(b);
  const std::string name = reference_file.string();
  const NpzArrays arrays = parse_npz(read_file(reference_file), name);
  const RowMatrix reference = npy_matrix(*find_array(arrays, "weights"), name);

  GeometricFieldsOptions options;
  options.points = 1 << 13;
  const GeometricFieldsResult result = geometric_fields(mesh, skeleton.handles, {}, options);
  ASSERT_EQ(result.W.rows(), reference.rows());
  std::vector<char> on_surface(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (Eigen::Index k = 0; k < mesh.F.size(); ++k)
    on_surface[static_cast<std::size_t>(mesh.F.data()[k])] = 1;
  double sum = 0;
  int count = 0;
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    if (!on_surface[static_cast<std::size_t>(v)]) continue;
    sum += 0.5 * (result.W.row(v) - reference.row(v)).cwiseAbs().sum();
    ++count;
  }
  // Measured: 0.038.
  EXPECT_LT(sum / count, 0.045);
  EXPECT_EQ(result.facts.vertices.seen, mesh.V.rows());
  EXPECT_LT(result.stats.relative_gap, 0.1);
}

}  // namespace
}  // namespace skinfield
