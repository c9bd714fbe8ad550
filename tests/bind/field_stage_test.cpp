// Geometric fields take any mesh too: without an inside, the surface's rungs stand in.
#include "bind/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/io/sfield.h"
#include "support/data.h"

namespace skinfield {
namespace {

using namespace skinfield_test;

TEST(FieldStage, ShapesWithAnInsideCarryTheField) {
  const BindResult result = bound(character(bar(), bar_bones()), field());
  EXPECT_EQ(result.report.rung, Rung::volume);
  EXPECT_EQ(result.report.domain_kind, "field");
  EXPECT_TRUE(result.report.warnings.empty());
}

TEST(FieldStage, ShapesWithoutAnInsideLiveOnTheirSurface) {
  const std::vector<std::pair<Mesh, std::vector<Handle>>> shapes{
      {moebius_strip(60), ring_of_bones()}, {bar(), three_along_x(0.5, 0.1)}};
  for (const auto& [mesh, bones] : shapes) {
    const Character c = character(mesh, bones);
    const BindResult result = bound(c, field());
    EXPECT_EQ(result.report.rung, Rung::surface);
    EXPECT_NE(result.report.domain_kind, "field");
    ASSERT_FALSE(result.report.warnings.empty());
    EXPECT_NE(result.report.warnings.front().find("on the surface"), std::string::npos);
    for (Eigen::Index b = 0; b < result.weights.W.cols(); ++b)
      EXPECT_GT(result.weights.W.col(b).sum(), 1);
    // The surface's weights are those that were asked for on it.
    BindOptions surface = quick();
    surface.domain = BindOptions::DomainKind::surface;
    EXPECT_LT(tv(result.weights, bound(c, surface).weights), 2e-3);
  }
}

TEST(FieldStage, TheSmallestMeshes) {
  const std::vector<Handle> bones{bone({0, 0, 0}, {1, 0, 0}), bone({1, 0, 0}, {2, 0, 0})};
  const BindResult two =
      bound(character(make_mesh({{0.2, 0.5, 0}, {1.8, 0, 1}}, {}), bones), field());
  EXPECT_EQ(two.report.rung, Rung::nearest_handle);
  EXPECT_EQ(two.weights.W.coeff(0, 0), 1);
  EXPECT_EQ(two.weights.W.coeff(1, 1), 1);
  bound(character(make_mesh({{0.2, 0.5, 0}}, {}), bones), field());
  bound(character(make_mesh({{0.2, 0.5, 0}, {1, 0, 1}, {1.9, 0, 0}}, {{0, 1, 2}}), bones), field());
  bound(character(make_mesh({{0, 1, 0}, {1, 1, 0}, {2, 1, 0}}, {{0, 1, 2}}), bones), field());
  bound(character(make_mesh({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}), bones), field());
}

TEST(FieldStage, PaintHoldsOnTheSurface) {
  BindOptions options = field();
  options.paint = Paint{{0, 1}, RowMatrix::Zero(2, 3)};
  options.paint->weights.col(2).setOnes();
  for (const std::vector<Handle>& bones : {three_along_x(), std::vector<Handle>{}}) {
    const BindResult result = bound(character(flat_strip(), bones), options);
    for (const int v : {0, 1}) EXPECT_DOUBLE_EQ(result.weights.W.coeff(v, 2), 1);
    EXPECT_GT(result.weights.W.coeff(2, 2), 0.1) << "the neighbours follow";
  }
}

TEST(FieldStage, AFieldThatIsToBeSavedMustExist) {
  BindOptions options = field();
  options.keep_field = true;
  EXPECT_THROW(bind(character(moebius_strip(60), ring_of_bones()), options), DomainError);
}

TEST(FieldStage, SavedFieldsAreTheSameFunction) {
  const Character c = character(bar(), bar_bones(2));
  BindOptions options = field();
  options.keep_field = true;
  for (const auto symmetry : {BindOptions::Symmetry::off, BindOptions::Symmetry::x}) {
    options.symmetry = symmetry;
    const BindResult result = bound(c, options);
    const FieldFile file = parse_sfield(format_sfield(*result.field), "test");
    const auto saved = solved_field(file);
    std::map<std::string, std::int64_t> filled, evaluated;
    const SkinWeights own = transfer(*saved, c, &filled, &evaluated);
    EXPECT_LT(tv(own, result.weights), 1e-12);
    EXPECT_EQ(own.names, result.weights.names);
    EXPECT_TRUE(filled.empty());
    EXPECT_EQ(evaluated["seen"], c.mesh.V.rows());
    // Clothes around the bar hold on to it.
    const Character sleeve =
        character(fine_box({-0.1, -0.1, -0.1}, {1.1, 0.3, 0.3}, {9, 2, 2}), bar_bones(2));
    const SkinWeights around = transfer(*saved, sleeve, nullptr, &evaluated);
    EXPECT_EQ(evaluated["passengers"], sleeve.mesh.V.rows());
    for (Eigen::Index v = 0; v < sleeve.mesh.V.rows(); ++v)
      EXPECT_GT(around.W.coeff(v, sleeve.mesh.V(v, 0) < 0.5 ? 0 : 1), 0.3);
  }
}

TEST(FieldStage, AFieldOfPaintAloneIsSavedToo) {
  const Character c = character(bar(), {});
  BindOptions options = field();
  options.keep_field = true;
  options.paint = Paint{{}, RowMatrix::Zero(0, 2)};
  for (int v = 0; v < c.mesh.V.rows(); ++v)
    if (c.mesh.V(v, 0) < 0.01 || c.mesh.V(v, 0) > 0.99) options.paint->vertex.push_back(v);
  options.paint->weights.setZero(static_cast<Eigen::Index>(options.paint->vertex.size()), 2);
  for (std::size_t k = 0; k < options.paint->vertex.size(); ++k)
    options.paint->weights(static_cast<Eigen::Index>(k),
                           c.mesh.V(options.paint->vertex[k], 0) > 0.5 ? 1 : 0) = 1;
  const BindResult result = bound(c, options);
  const FieldFile file = parse_sfield(format_sfield(*result.field), "test");
  EXPECT_LT(tv(transfer(*solved_field(file), c), result.weights), 0.02);
}

TEST(FieldStage, WildMeshesBind) {
  SKINFIELD_NEEDS_DATA(moebius, "wild/moebius.obj");
  for (const char* name : {"moebius", "degenerate_tiny", "fish-oneside", "truck"}) {
    const std::string stem = "wild/" + std::string(name);
    const std::string extension = stem == "wild/fish-oneside" ? ".off" : ".obj";
    const std::filesystem::path folder = moebius.parent_path().parent_path();
    const Character c = read_case(folder / (stem + extension), folder / (stem + ".tgf"));
    const BindResult result = bound(c, field(1000));
    EXPECT_EQ(result.report.rung, stem == "wild/moebius" ? Rung::surface : Rung::volume) << name;
  }
}

}  // namespace
}  // namespace skinfield
