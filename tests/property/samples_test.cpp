// The samples bound, and random input of every kind: always valid weights.
#include "bind/fixtures.h"
#include "skinfield/bind/handles.h"
#include "skinfield/sample/sample.h"

namespace skinfield {
namespace {

using namespace skinfield_test;

Character sample_character(std::string_view name) {
  SampleOptions options;
  options.resolution = 8000;
  Asset asset = sample_asset(make_sample(name, options));
  make_handles(asset.characters.at(0));
  return asset.characters.at(0);
}

TEST(Samples, GeckoIsOneCleanVolume) {
  const BindResult result = bound(sample_character("gecko"), quick(2000));
  EXPECT_EQ(result.report.rung, Rung::volume);
  EXPECT_EQ(result.report.clean_parts, 1);
  EXPECT_EQ(result.report.dirty_parts, 0);
  EXPECT_EQ(result.report.node_components, 1);
  EXPECT_TRUE(result.report.handles_outside.empty());
  EXPECT_TRUE(result.report.handles_without_vertices.empty());
  EXPECT_EQ(result.report.solve.status, SolveStats::Status::converged);
}

TEST(Samples, RobotIsWeightedThroughoutItsParts) {
  SampleOptions options;
  options.resolution = 8000;
  const SampleCharacter sample = make_sample("robot", options);
  const Character c = sample_character("robot");
  const BindResult result = bound(c, quick(3000));
  EXPECT_EQ(result.report.rung, Rung::volume);
  EXPECT_EQ(result.report.dirty_parts, 0);
  EXPECT_EQ(result.report.clean_parts + result.report.passenger_parts,
            static_cast<int>(sample.parts.size()));
  EXPECT_EQ(result.report.node_components_without_handle, 0);
  // Overlapping parts share influences: some part holds more than one bone that matters, and some
  // bone matters in more than one part.
  std::vector<std::vector<char>> matters(sample.parts.size(),
                                         std::vector<char>(result.weights.W.cols(), 0));
  for (std::size_t p = 0; p < sample.parts.size(); ++p)
    for (int f = sample.parts[p].face_begin; f < sample.parts[p].face_end; ++f)
      for (int k = 0; k < 3; ++k)
        for (SparseRows::InnerIterator it(result.weights.W, sample.mesh.F(f, k)); it; ++it)
          if (it.value() > 0.2) matters[p][static_cast<std::size_t>(it.col())] = 1;
  int mixed = 0, crossing = 0;
  for (const auto& part : matters) mixed += std::count(part.begin(), part.end(), 1) > 1;
  for (std::size_t j = 0; j < matters[0].size(); ++j) {
    int parts = 0;
    for (const auto& part : matters) parts += part[j];
    crossing += parts > 1;
  }
  EXPECT_GT(mixed, 3);
  EXPECT_GT(crossing, 3);
}

TEST(Samples, ScanIsNearlyTheGecko) {
  const Character gecko = sample_character("gecko"), scan = sample_character("scan");
  const BindResult clean = bound(gecko, quick(3000)), result = bound(scan, quick(3000));
  EXPECT_EQ(result.report.rung, Rung::volume);
  EXPECT_EQ(result.report.clean_parts, 0);
  EXPECT_TRUE(result.report.handles_without_vertices.empty());
  const Comparison apart = compare(transfer(*clean.solved, scan), result.weights);
  EXPECT_LT(apart.mean, 0.06);
  EXPECT_LT(apart.p99, 0.3);
}

TEST(Samples, DamageHurtsGracefully) {
  const Character gecko = sample_character("gecko");
  const BindResult clean = bound(gecko, quick(2000));
  for (double removed : {0.1, 0.4, 0.7}) {
    const Character soup =
        character(soup_of(gecko.mesh, removed, 0.004, 11), gecko.skeleton.handles);
    const BindResult result = bound(soup, quick(2000));
    EXPECT_EQ(result.report.rung, Rung::volume);
    EXPECT_LT(tv(transfer(*clean.solved, soup), result.weights), 0.05 + 0.08 * removed)
        << removed << " removed";
  }
}

TEST(RandomInput, AlwaysGivesValidWeights) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Random random(seed, 99);
    std::vector<Handle> handles;
    const int count = 1 + static_cast<int>(random.below(6));
    const double spread = seed % 3 == 0 ? 0.2 : seed % 3 == 1 ? 1 : 3;
    const auto anywhere = [&] {
      return Vec3(Vec3::Constant(0.5) + spread * random.direction() * random.uniform());
    };
    for (int h = 0; h < count; ++h)
      handles.push_back(random.below(4) == 0 ? point_handle(anywhere())
                                             : bone(anywhere(), anywhere()));
    Mesh mesh;
    switch (seed % 4) {
      case 0:
        mesh = random_soup(3 + static_cast<int>(random.below(200)), 0.02 + 0.3 * random.uniform(),
                           seed);
        break;
      case 1:
        mesh.V = random_points(2 + static_cast<int>(random.below(300)), 0, 1, seed);
        break;
      case 2:
        mesh = together(moved(sphere_mesh(0.4, 10, 0.4 * random.uniform()), anywhere()),
                        randomly_flipped(moved(torus_mesh(0.4, 0.1, 20, 10), anywhere()), seed));
        break;
      default:
        mesh = together(moved(turned_inside_out(sphere_mesh(0.3, 8)), anywhere()),
                        random_soup(40, 0.2, seed));
        mesh.F(0, 0) = mesh.F(0, 1);
    }
    SCOPED_TRACE("seed " + std::to_string(seed));
    BindOptions options = quick(300);
    options.seed = seed;
    options.max_influences = seed % 2 == 0 ? 0 : 2;
    bound(character(mesh, handles), options);
  }
}

}  // namespace
}  // namespace skinfield
