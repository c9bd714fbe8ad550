#include "methods/field_rows.h"

#include "domain/fixtures.h"
#include "methods/adam_field.h"
#include "methods/convex_field.h"
#include "skinfield/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield {
namespace {

using namespace skinfield_test;

/// A ball with two bones, 400 points.
struct Ball {
  Mesh mesh = sphere_mesh(0.5, 12);
  std::vector<Handle> handles{bone({0, 0, -0.3}, {0, 0, -0.02}), bone({0, 0, 0.02}, {0, 0, 0.3})};
  Solid solid{mesh, Points::Zero(1, 3)};
  InteriorSampler sampler{solid, 1};
  KernelField field{solid, sampler.spread({400}, 1, {})};
};

const Ball& ball() {
  static const Ball b;
  return b;
}

/// Its conditions and 600 samples.
struct Case {
  const KernelField& field = ball().field;
  FieldConditions conditions;
  std::vector<WeightedSite> samples;
  double h = 0.5 * field.sigma();

  explicit Case(bool conditioned, bool neumann = false)
      : conditions(ball().solid, ball().mesh, ball().handles, {}, neumann) {
    const double radius = conditioned ? 0.5 * field.sigma() : 0;
    conditions.set_radii({radius, radius, neumann ? radius : 0});
    samples = InteriorSamples(ball().sampler, ball().solid, conditions.segments(), field.sigma(),
                              conditioned ? 0.5 : 0)
                  .draw(600, 2, 0);
  }
  FieldRows rows() const { return FieldRows(field, conditions, samples, h, 2, 1, 1u << 20, {}); }
  FloatRows random_rows(std::uint64_t seed) const {
    FloatRows F(static_cast<Eigen::Index>(field.points().size()), 2);
    for (Eigen::Index i = 0; i < F.rows(); ++i) {
      F(i, 0) = static_cast<float>(Random(seed, static_cast<std::uint64_t>(i)).uniform());
      F(i, 1) = 1 - F(i, 0);
    }
    return F;
  }
};

TEST(FieldRows, DirectionsAreOrthonormalAndSeeTheHessian) {
  // E[(v'Hv)^2] = (2 |H|^2 + (tr H)^2) / 15: what equation 13's square estimates in 3D.
  Eigen::Matrix3d H;
  H << 1, 0.3, -0.5, 0.3, -2, 0.7, -0.5, 0.7, 0.4;
  const auto f = [&](const Vec3& x) { return 0.5 * x.dot(H * x) + x[0] - 2 * x[2]; };
  const Vec3 y(0.3, -0.2, 0.9);
  const double h = 0.05;
  double mean = 0;
  constexpr int frames = 40000;
  for (int k = 0; k < frames; ++k) {
    Random random(7, static_cast<std::uint64_t>(k));
    const auto frame = random_frame(random);
    double trace = 0;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b <= a; ++b)
        ASSERT_NEAR(frame[static_cast<std::size_t>(a)].dot(frame[static_cast<std::size_t>(b)]),
                    a == b ? 1 : 0, 1e-12);
      const Vec3& v = frame[static_cast<std::size_t>(a)];
      // The difference of equation 13 is exact for quadratic functions.
      const double d = (f(y + h * v) + f(y - h * v) - 2 * f(y)) / (h * h);
      ASSERT_NEAR(d, v.dot(H * v), 1e-9);
      trace += d;
      mean += d * d / (3 * frames);
    }
    ASSERT_NEAR(trace, H.trace(), 1e-8);
  }
  const double exact = (2 * H.squaredNorm() + H.trace() * H.trace()) / 15;
  EXPECT_NEAR(mean, exact, 0.02 * exact);
}

TEST(FieldRows, WindingWeightIsClippedToOne) {
  EXPECT_EQ(winding_weight(1, 0.1, 0.25), 1);
  EXPECT_EQ(winding_weight(0.05, 0.1, 0.25), 0);
  EXPECT_NEAR(winding_weight(0.175, 0.1, 0.25), 0.5, 1e-12);
}

TEST(FieldRows, ConstantsHaveNoEnergy) {
  for (const bool neumann : {false, true}) {
    const Case c(false, neumann);
    const FieldRows rows = c.rows();
    EXPECT_EQ(rows.rows(), 3 * static_cast<std::int64_t>(c.samples.size()));
    FloatRows F(400, 2);
    F.col(0).setConstant(0.25f);
    F.col(1).setConstant(0.75f);
    const double scale = rows.energy(c.random_rows(1), nullptr, {});
    EXPECT_LT(rows.energy(F, nullptr, {}), 1e-9 * scale);
  }
}

TEST(FieldRows, GradientIsTheEnergysDerivative) {
  for (const bool neumann : {false, true}) {
    const Case c(true, neumann);
    const FieldRows rows = c.rows();
    const FloatRows F = c.random_rows(1), D = c.random_rows(2) - c.random_rows(3);
    FloatRows G;
    const double e = rows.energy(F, &G, {});
    // The energy is quadratic: a central difference is exact.
    const double plus = rows.energy(F + D, nullptr, {}), minus = rows.energy(F - D, nullptr, {});
    const double slope = (G.cast<double>().array() * D.cast<double>().array()).sum();
    EXPECT_NEAR(slope, 0.5 * (plus - minus), 1e-4 * e);
  }
}

TEST(FieldRows, EnergyIsTheSumOverItsStencils) {
  const Case c(true, true);
  const FloatRows F = c.random_rows(5);
  double energy = 0;
  FieldStencil st;
  for (std::size_t i = 0; i < c.samples.size(); ++i) {
    Random random(1, (1u << 20) + i);
    const auto frame = random_frame(random);
    for (const Vec3& v : frame) {
      const Vec3 x = c.samples[i].site.x;
      Eigen::Vector2d d = Eigen::Vector2d::Zero();
      for (const auto& [place, factor] :
           {std::pair{x, -2.0}, {Vec3(x + c.h * v), 1.0}, {Vec3(x - c.h * v), 1.0}}) {
        ASSERT_TRUE(
            make_stencil(c.field, c.conditions, c.samples[i].site, std::span(&place, 1), st));
        const auto hat = [&](std::size_t q) {
          Eigen::Vector2d value = Eigen::Vector2d::Zero();
          for (std::size_t k = 0; k < st.node.size(); ++k)
            value +=
                static_cast<double>(st.row(q)[k]) * F.row(st.node[k]).transpose().cast<double>();
          value *= st.place[q].free;
          for (const auto& [column, share] : st.place[q].value) value[column] += share;
          return value;
        };
        Eigen::Vector2d alpha = hat(0);
        if (st.twin[0] >= 0)
          alpha += st.blend[0] * (hat(static_cast<std::size_t>(st.twin[0])) - hat(0));
        EXPECT_NEAR(alpha.sum(), 1, 1e-5);
        d += factor / (c.h * c.h) * alpha;
      }
      energy += 0.5 * c.samples[i].weight / 3 * d.squaredNorm();
    }
  }
  EXPECT_NEAR(c.rows().energy(F, nullptr, {}), energy, 1e-3 * energy);
}

TEST(FieldRows, TheMajorantBoundsTheQuadraticForm) {
  const Case c(false);
  const FieldRows rows = c.rows();
  const Vector D = rows.majorant();
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const FloatRows F = c.random_rows(seed);
    const double form = 2 * rows.energy(F, nullptr, {});
    const Vector norms = F.rowwise().squaredNorm().cast<double>();
    EXPECT_LE(form, D.dot(norms) * (1 + 1e-6));
  }
  Vector v = Vector::Random(D.size());
  const double value = rows.largest_eigenvalue(D, 30, v, {});
  EXPECT_GT(value, 0.01);
  EXPECT_LE(value, 1);
}

TEST(ConvexField, FindsTheMinimumAndCertifiesIt) {
  const Case c(true);
  const FieldRows rows = c.rows();
  const std::vector<char> bound{1, 1};
  FloatRows F = FloatRows::Constant(400, 2, 0.5f);
  ConvexOptions options;
  options.max_steps = 600;
  options.tolerance = 0;
  options.held_out_gain = -1;
  double eigenvalue = 0;
  SolveStats stats = minimise_convex(rows, rows, bound, options, eigenvalue, F, {});
  certify(rows, bound, F, stats, {});
  EXPECT_GE(F.minCoeff(), 0);
  EXPECT_LT((F.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-5f);
  EXPECT_LE(stats.lower_bound, stats.energy);
  EXPECT_LT(stats.relative_gap, 0.02);
  // No feasible point is below the bound.
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    EXPECT_GE(rows.energy(0.99f * F + 0.01f * c.random_rows(seed), nullptr, {}), stats.lower_bound);
}

TEST(ConvexField, ColumnsThatNothingBindsStayZero) {
  const Case c(true);
  FloatRows F = FloatRows::Zero(400, 2);
  F.col(0).setOnes();
  double eigenvalue = 0;
  ConvexOptions options;
  options.max_steps = 10;
  const FieldRows rows = c.rows();
  minimise_convex(rows, rows, {1, 0}, options, eigenvalue, F, {});
  EXPECT_EQ(F.col(1).maxCoeff(), 0);
}

TEST(AdamField, SoftplusAndItsSlope) {
  std::vector<float> f;
  for (int k = -200; k <= 200; ++k) f.push_back(0.5f * static_cast<float>(k));
  std::vector<float> value(f.size()), slope(f.size());
  softplus_and_slope(f.data(), static_cast<int>(f.size()), value.data(), slope.data());
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double x = static_cast<double>(f[i]);
    const double exact = x > 30 ? x : std::log1p(std::exp(x));
    EXPECT_NEAR(static_cast<double>(value[i]), exact, 2e-5 * exact + 1e-30) << x;
    EXPECT_NEAR(static_cast<double>(slope[i]), 1 / (1 + std::exp(-x)), 2e-5) << x;
  }
}

TEST(AdamField, GoesDownhillAlongItsGradient) {
  // Adam's first step moves every parameter by the rate against the gradient's sign: the energy's
  // change shows whether signs are right; small steps that it is the derivative.
  for (const bool neumann : {false, true}) {
    const Case c(true, neumann);
    std::vector<FieldSample> samples(c.samples.size());
    std::vector<const FieldSample*> all;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Vec3 x = c.samples[i].site.x, v = Random(4, i).direction();
      const std::array<Vec3, 3> places{x, x + c.h * v, x - c.h * v};
      ASSERT_TRUE(
          make_stencil(c.field, c.conditions, c.samples[i].site, places, samples[i].stencil));
      samples[i].weight = c.samples[i].weight;
      samples[i].h = c.h;
      all.push_back(&samples[i]);
    }
    AdamField adam(4 * c.random_rows(9), {}, {}, {1, 1});
    const FloatRows before = adam.parameters();
    const double first = adam.step(all, 1e-3, 1);
    // first moments after one step: (1 - beta1) g.
    const FloatRows g = adam.first() / 0.1f;
    const FloatRows moved = adam.parameters() - before;
    const double predicted = (g.cast<double>().array() * moved.cast<double>().array()).sum();
    EXPECT_LT(predicted, 0);
    EXPECT_NEAR(adam.energy(all) - first, predicted, 0.1 * std::abs(predicted));
    double last = first;
    for (int t = 2; t < 200; ++t) last = adam.step(all, 0.1, t);
    EXPECT_LT(last, 0.2 * first);
  }
}

}  // namespace
}  // namespace skinfield
