// SVG paths against areas worked out by hand.
#include "skinfield/io/svg.h"

#include "skinfield/base/error.h"
#include "skinfield/io/io.h"
#include "support/data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

constexpr double kPi = std::numbers::pi;

MeshFile parse(const std::string& body) {
  return parse_svg("<svg xmlns='http://www.w3.org/2000/svg'>" + body + "</svg>", "test");
}

/// Signed area of all loops as they run, by the shoelace formula over their segments; y is up, so
/// that a loop drawn clockwise on the screen, y down, is negative here.
double area(const MeshFile& file) {
  double sum = 0;
  const Segments& E = file.outline.E;
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    const Eigen::RowVector3d a = file.V.row(E(e, 0)), b = file.V.row(E(e, 1));
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

double path_area(const std::string& d) { return area(parse("<path d='" + d + "'/>")); }

TEST(Svg, LinesAbsoluteAndRelative) {
  EXPECT_DOUBLE_EQ(path_area("M0 0 L4 0 L4 3 L0 3 Z"), -12);
  EXPECT_DOUBLE_EQ(path_area("m1 1 l4 0 l0 3 l-4 0 z"), -12);
  EXPECT_DOUBLE_EQ(path_area("M1,1h4v3H1V1z"), -12);
  EXPECT_DOUBLE_EQ(path_area("M0 0 4 0 4 3 0 3"), -12);  // pairs after M are lines; fill closes
  EXPECT_DOUBLE_EQ(path_area("m0 0 4 0 0 3-4 0z"), -12);
  EXPECT_DOUBLE_EQ(path_area("M.5.5L4.5.5 4.5,3.5.5,3.5Z"), -12);
  EXPECT_DOUBLE_EQ(path_area("M0 0L40e-1 0 4 3E0-0 3z"), -12);
  // After Z, the next subpath starts where the last one did.
  EXPECT_DOUBLE_EQ(path_area("M1 1h2v2h-2zh-1v-1z"), -4 + 0.5 * -1);
}

TEST(Svg, HolesAndTheirPlace) {
  const MeshFile file = parse("<path d='M0 0H10V10H0Z M2 2V8H8V2Z'/>");
  EXPECT_DOUBLE_EQ(area(file), -100 + 36);
  EXPECT_EQ(file.V.rows(), 8);
  EXPECT_EQ(file.outline.E.rows(), 8);
  EXPECT_EQ(Eigen::RowVector3d(file.V.row(2)), Eigen::RowVector3d(10, -10, 0));  // y upward
}

TEST(Svg, CurvesAreWithinTheirTolerance) {
  // A cubic from (0,0) by (0,1), (1,1) to (1,0): area 3/5 under it.
  EXPECT_NEAR(path_area("M0 0C0 1 1 1 1 0Z"), 0.6, 1e-3);
  EXPECT_NEAR(path_area("M0 0c0 1 1 1 1 0z"), 0.6, 1e-3);
  // A quadratic from (0,0) by (1,2) to (2,0): 2/3 of the triangle's 2.
  EXPECT_NEAR(path_area("M0 0Q1 2 2 0Z"), 4.0 / 3, 2e-3);
  EXPECT_NEAR(path_area("M0 0q1 2 2 0z"), 4.0 / 3, 2e-3);
  // S and T mirror the control point: an S shape whose halves cancel.
  EXPECT_NEAR(path_area("M0 0Q1 2 2 0T4 0Z"), 0, 1e-9);
  EXPECT_NEAR(path_area("M0 0C0 1 1 1 1 0S2-1 2 0Z"), 0, 1e-9);
  EXPECT_NEAR(path_area("M0 0c0 1 1 1 1 0s1-1 1 0z"), 0, 1e-9);
  // Without a curve before it, S starts along its own first point.
  EXPECT_NEAR(path_area("M0 0S1 1 1 0Z"), path_area("M0 0C0 0 1 1 1 0Z"), 1e-12);
}

TEST(Svg, Arcs) {
  EXPECT_NEAR(path_area("M-1 0A1 1 0 0 1 1 0Z"), -kPi / 2, 2e-3);
  EXPECT_NEAR(path_area("M-1 0A1 1 0 0 0 1 0Z"), kPi / 2, 2e-3);
  // A quarter circle, small and large: chord from (1,0) to (0,1).
  EXPECT_NEAR(path_area("M1 0A1 1 0 0 1 0 1Z"), -(kPi / 4 - 0.5), 1e-3);
  EXPECT_NEAR(path_area("M1 0A1 1 0 1 0 0 1Z"), 3 * kPi / 4 + 0.5, 5e-3);
  // Flags without blanks; radii too small grow; radius 0 is a line.
  EXPECT_NEAR(path_area("M-1 0a1 1 0 012 0z"), -kPi / 2, 2e-3);
  EXPECT_NEAR(path_area("M-2 0A1 1 0 0 1 2 0Z"), -2 * kPi, 1e-2);
  EXPECT_DOUBLE_EQ(path_area("M0 0H1A0 5 0 0 1 1 1Z"), -0.5);
  // An ellipse turned by 90 degrees: rx = 2 lies along y, so the half width is 1.
  EXPECT_NEAR(path_area("M-1 0A2 1 90 0 1 1 0Z"), -kPi, 5e-3);
}

TEST(Svg, BasicShapes) {
  EXPECT_DOUBLE_EQ(area(parse("<rect x='1' y='2' width='3' height='4px'/>")), -12);
  EXPECT_NEAR(area(parse("<rect width='4' height='4' rx='1'/>")), -(16 - 4 + kPi), 1e-2);
  EXPECT_NEAR(area(parse("<rect width='4' height='4' rx='9' ry='9'/>")), -4 * kPi, 2.4e-2);
  EXPECT_NEAR(area(parse("<circle cx='3' cy='1' r='2'/>")), -4 * kPi, 2.4e-2);
  EXPECT_NEAR(area(parse("<ellipse rx='2' ry='1'/>")), -2 * kPi, 1e-2);
  EXPECT_DOUBLE_EQ(area(parse("<polygon points='0,0 4,0 4,3'/>")), -6);
  EXPECT_DOUBLE_EQ(area(parse("<polyline points='0 0 4 0 4 3'/>")), -6);
}

TEST(Svg, TransformsOfGroupsAndElements) {
  const std::string unit = "<rect width='1' height='1'";
  const auto with = [&](const std::string& t) {
    return std::abs(area(parse(unit + " transform='" + t + "'/>")));
  };
  EXPECT_DOUBLE_EQ(with("scale(2,3)"), 6);
  EXPECT_DOUBLE_EQ(with("scale(2)"), 4);
  EXPECT_NEAR(with("rotate(33) translate(5)"), 1, 1e-12);
  EXPECT_NEAR(with("skewX(40)"), 1, 1e-12);
  EXPECT_NEAR(with("skewY(-20), scale(2 1)"), 2, 1e-12);
  EXPECT_NEAR(with("matrix(1 2 3 4 5 6)"), 2, 1e-12);
  // Order and nesting: the inner one acts first.
  const MeshFile nested = parse("<g transform='translate(10,0)'><g transform='rotate(90)'>" + unit +
                                " transform='translate(2 0)'/></g></g>");
  EXPECT_NEAR(nested.V(0, 0), 10, 1e-12);
  EXPECT_NEAR(nested.V(0, 1), -2, 1e-12);
  const MeshFile around = parse(unit + " transform='rotate(180, 1, 1)'/>");
  EXPECT_NEAR(around.V(0, 0), 2, 1e-12);
  EXPECT_NEAR(around.V(0, 1), -2, 1e-12);
  EXPECT_THROW(with("turn(3)"), InputError);
  EXPECT_THROW(with("scale(1,2"), InputError);
}

TEST(Svg, ElementsAreShapesAndParts) {
  const MeshFile file = parse(
      "<defs><rect width='1' height='1'/></defs><rect id='body' width='4' height='4'/>"
      "<g display='none'><circle r='9'/></g><text>no</text>"
      "<polygon id='eye' points='1,1 2,1 2,2'/><path d='M0 0L1 1' style='fill: none'/>");
  ASSERT_EQ(file.parts.size(), 2u);
  EXPECT_EQ(file.parts[0].name, "body");
  EXPECT_EQ(file.parts[1].name, "eye");
  EXPECT_EQ(file.parts[1].begin, 4);
  EXPECT_EQ(file.outline.shape, (std::vector<int>{0, 0, 0, 0, 1, 1, 1}));
  EXPECT_EQ(file.warnings.size(), 2u);  // text, and the open path
}

TEST(Svg, WhatCannotBeReadIsRefused) {
  EXPECT_THROW(parse_svg("<svg><path d='M0 0'", "test"), InputError);
  EXPECT_THROW(parse_svg("<html/>", "test"), InputError);
  EXPECT_THROW(parse(""), InputError);
  EXPECT_THROW(parse("<path d='M0 0L1 1' fill='none'/>"), InputError);
  EXPECT_THROW(parse("<path d='L1 1 2 2'/>"), InputError);
  EXPECT_THROW(parse("<path d='M0 0L1e200 0L0 1Z'/>"), InputError);
  EXPECT_THROW(parse("<rect width='50%' height='1'/>"), InputError);
  EXPECT_THROW(parse("<svg x='3' y='t'><rect width='1' height='1'/></svg>"), InputError);
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "<g>";
  EXPECT_THROW(parse_svg("<svg>" + deep, "test"), InputError);
  for (int i = 0; i < 5000; ++i) deep += "</g>";
  EXPECT_THROW(parse(deep), InputError);
  // An error in a path ends it there, as browsers do.
  const MeshFile broken = parse("<path d='M0 0H4V4 X3'/>");
  EXPECT_DOUBLE_EQ(area(broken), -8);
  EXPECT_EQ(broken.warnings.size(), 1u);
}

TEST(Svg, IsKnownByItsBytes) {
  EXPECT_EQ(format_of_bytes("<?xml version='1.0'?>\n<!-- a --><svg/>"), FileFormat::svg);
  EXPECT_EQ(format_of_bytes("<svg:svg xmlns:svg='http://www.w3.org/2000/svg'/>"), FileFormat::svg);
  EXPECT_EQ(format_of_bytes("<html/>"), FileFormat::unknown);
  EXPECT_EQ(format_of_extension("a.SVG"), FileFormat::svg);
}

TEST(Svg, DataAgreesWithItsOutlines) {
  for (const char* name : {"alligator", "annulus", "comb", "snake", "star"}) {
    SKINFIELD_NEEDS_DATA(svg, std::string("planar/") + name + ".svg");
    SKINFIELD_NEEDS_DATA(obj, std::string("planar/") + name + "-outline.obj");
    const Mesh a = read_asset(svg).characters.front().mesh;
    const Mesh b = read_asset(obj).characters.front().mesh;
    ASSERT_EQ(a.V.rows(), b.V.rows()) << name;
    EXPECT_EQ(a.outline.E.rows(), b.outline.E.rows()) << name;
    EXPECT_TRUE(a.is_outline());
    EXPECT_LT((a.V - b.V).cwiseAbs().maxCoeff(), 1e-5 * diagonal(bounding_box(b.V))) << name;
  }
}

}  // namespace
}  // namespace skinfield
