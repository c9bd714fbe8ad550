#include "skinfield/geometry/winding_number.h"

#include "geometry/dipole_tree.h"
#include "skinfield/base/parallel.h"

#include <Eigen/Dense>

#include <array>
#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

constexpr double kFourPi = 4 * std::numbers::pi;

/// tan(solid angle / 2) = opposite / adjacent (van Oosterom and Strackee 1983, eq. 8).
struct HalfAngle {
  double opposite, adjacent;
};

HalfAngle half_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return {a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb};
}

/// Four triangles side by side, so that the compiler computes them in vector registers.
/// Missing ones have three equal corners: their angle is 0.
struct FourTriangles {
  double corner[9][4];
};

/// Adds up half angles as the argument of a product of complex numbers: one arc tangent a sum.
class AngleSum {
 public:
  void add(double adjacent, double opposite) {
    if (adjacent == 0 && opposite == 0) return;  // seen from its own edge: no angle
    const double re = re_ * adjacent - im_ * opposite, im = re_ * opposite + im_ * adjacent;
    if (im_ >= 0 && opposite >= 0 && im < 0) ++turns_;
    if (im_ < 0 && opposite < 0 && im >= 0) --turns_;
    re_ = re;
    im_ = im;
  }
  /// Keeps the product within range; call every few terms.
  void rescale() {
    const double size = std::abs(re_) + std::abs(im_);
    if (size > 0) {
      re_ /= size;
      im_ /= size;
    }
  }
  double total() const { return std::atan2(im_, re_) + 2 * std::numbers::pi * turns_; }

 private:
  double re_ = 1, im_ = 0;
  int turns_ = 0;
};

void add_four(const FourTriangles& four, const Vec3& x, AngleSum& sum) {
  const auto& p = four.corner;
  double opposite[4], adjacent[4];
  for (int i = 0; i < 4; ++i) {
    const double ax = p[0][i] - x[0], ay = p[1][i] - x[1], az = p[2][i] - x[2];
    const double bx = p[3][i] - x[0], by = p[4][i] - x[1], bz = p[5][i] - x[2];
    const double cx = p[6][i] - x[0], cy = p[7][i] - x[1], cz = p[8][i] - x[2];
    const double la = std::sqrt(ax * ax + ay * ay + az * az);
    const double lb = std::sqrt(bx * bx + by * by + bz * bz);
    const double lc = std::sqrt(cx * cx + cy * cy + cz * cz);
    const double ab = ax * bx + ay * by + az * bz;
    const double bc = bx * cx + by * cy + bz * cz;
    const double ca = cx * ax + cy * ay + cz * az;
    opposite[i] = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
    adjacent[i] = la * lb * lc + ab * lc + bc * la + ca * lb;
    const double size = std::abs(opposite[i]) + std::abs(adjacent[i]);
    const double scale = size > 0 ? 1 / size : 0;
    opposite[i] *= scale;
    adjacent[i] *= scale;
  }
  for (int i = 0; i < 4; ++i) sum.add(adjacent[i], opposite[i]);
  sum.rescale();
}

}  // namespace

double solid_angle_fraction(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const HalfAngle h = half_angle(a - x, b - x, c - x);
  return 2 * std::atan2(h.opposite, h.adjacent) / kFourPi;
}

double winding_number_direct(const Points& V, const Triangles& F, const Vec3& x) {
  double sum = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    sum += solid_angle_fraction(V.row(F(f, 0)).transpose(), V.row(F(f, 1)).transpose(),
                                V.row(F(f, 2)).transpose(), x);
  return sum;
}

struct WindingNumber::Impl {
  DipoleTree tree;
  std::vector<FourTriangles> near;  // of the leaves, in their order; empty for points
  std::vector<int> first_near;      // per node: its first block

  Impl(const Points& V, const Triangles& F, double accuracy) : tree(V, F, accuracy) {
    first_near.resize(tree.nodes().size() + 1, 0);
    for (std::size_t n = 0; n < tree.nodes().size(); ++n) {
      first_near[n] = static_cast<int>(near.size());
      const DipoleTree::Node& node = tree.nodes()[n];
      if (!node.is_leaf()) continue;
      for (int i = node.begin; i < node.end; i += 4) near.push_back(gather(V, F, i, node.end));
    }
    first_near.back() = static_cast<int>(near.size());
  }

  Impl(const Points& P, const Points& N, const Vector& area, double accuracy)
      : tree(P, N, area, accuracy) {}

  FourTriangles gather(const Points& V, const Triangles& F, int begin, int end) const {
    FourTriangles four;
    for (int lane = 0; lane < 4; ++lane) {
      const bool there = begin + lane < end;
      const int f = tree.items()[there ? begin + lane : begin].number;
      for (int k = 0; k < 9; ++k) four.corner[k][lane] = V(F(f, there ? k / 3 : 0), k % 3);
    }
    return four;
  }

  double at(const Vec3& x) const {
    double far = 0;
    if (near.empty()) {
      tree.walk(x, 0, far, [&](std::size_t n) { far += tree.leaf_sum(n, x, 0); });
      return far / kFourPi;
    }
    AngleSum angles;
    tree.walk(x, 0, far, [&](std::size_t n) {
      for (int i = first_near[n]; i < first_near[n + 1]; ++i) add_four(near[i], x, angles);
    });
    return (far + 2 * angles.total()) / kFourPi;
  }
};

WindingNumber::WindingNumber(const Points& V, const Triangles& F,
                             const WindingNumberOptions& options)
    : impl_(std::make_unique<Impl>(V, F, options.accuracy)) {}

WindingNumber::WindingNumber(const Points& P, const Points& N, const Vector& area,
                             const WindingNumberOptions& options)
    : impl_(std::make_unique<Impl>(P, N, area, options.accuracy)) {}

WindingNumber::~WindingNumber() = default;
WindingNumber::WindingNumber(WindingNumber&&) noexcept = default;
WindingNumber& WindingNumber::operator=(WindingNumber&&) noexcept = default;

double WindingNumber::at(const Vec3& x) const { return impl_->at(x); }

Vector WindingNumber::at(const Points& X) const {
  Vector w(X.rows());
  parallel_for(static_cast<std::size_t>(X.rows()), 64, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    w[row] = impl_->at(X.row(row).transpose());
  });
  return w;
}

double WindingNumber::smoothed(const Vec3& x, double epsilon) const {
  const DipoleTree& tree = impl_->tree;
  double sum = 0;
  const double e2 = epsilon * epsilon;
  tree.walk(x, e2, sum, [&](std::size_t n) { sum += tree.leaf_sum(n, x, e2); });
  return sum / kFourPi;
}

}  // namespace skinfield
