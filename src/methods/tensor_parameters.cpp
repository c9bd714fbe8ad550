#include "methods/tensor_parameters.h"

#include "base/vector_clones.h"
#include "skinfield/base/parallel.h"

namespace skinfield {
namespace {

constexpr std::size_t kBlock = 2048;

/// Columns of one quantity an element, `stride` apart.
struct Columns {
  double kappa, epsilon;
  const double* scale;
  const double* theta;
  std::ptrdiff_t stride;
};

SKINFIELD_VECTOR_CLONES
void flat_tensors(const Columns& of, double* A, std::ptrdiff_t begin, std::ptrdiff_t end) {
  const double kappa = of.kappa, epsilon = of.epsilon, *s = of.scale, *a = of.theta,
               *b = a + of.stride, *c = b + of.stride;
  double* __restrict A00 = A, * __restrict A10 = A + of.stride, * __restrict A11 = A + 2 * of.stride;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double q = s[i] / (a[i] * a[i]), second = b[i] * b[i] + c[i] * c[i];
    A00[i] = q * (1 + kappa * second) + epsilon * s[i];
    A10[i] = q * b[i];
    A11[i] = q * (second + kappa) + epsilon * s[i];
  }
}

SKINFIELD_VECTOR_CLONES
void solid_tensors(const Columns& of, double* A, std::ptrdiff_t begin, std::ptrdiff_t end) {
  const std::ptrdiff_t n = of.stride;
  const double kappa = of.kappa, epsilon = of.epsilon, *s = of.scale, *a = of.theta, *b = a + n,
               *c = b + n, *d = c + n, *e = d + n, *f = e + n;
  double* __restrict A00 = A, * __restrict A10 = A + n, * __restrict A20 = A + 2 * n, * __restrict A11 = A + 3 * n, * __restrict A21 = A + 4 * n, * __restrict A22 = A + 5 * n;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double q = s[i] / (a[i] * a[i]), least = epsilon * s[i];
    const double second = b[i] * b[i] + c[i] * c[i];
    const double third = d[i] * d[i] + e[i] * e[i] + f[i] * f[i];
    A00[i] = q * (1 + kappa * (second + third)) + least;
    A10[i] = q * b[i];
    A20[i] = q * d[i];
    A11[i] = q * (second + kappa * (1 + third)) + least;
    A21[i] = q * (b[i] * d[i] + c[i] * e[i]);
    A22[i] = q * (third + kappa * (1 + second)) + least;
  }
}

SKINFIELD_VECTOR_CLONES
void flat_parameters(const Columns& of, double* D, std::ptrdiff_t begin, std::ptrdiff_t end) {
  const double kappa = of.kappa, *s = of.scale, *a = of.theta, *b = a + of.stride,
               *c = b + of.stride;
  double* __restrict p0 = D, * __restrict p1 = D + of.stride, * __restrict p2 = D + 2 * of.stride;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double q = s[i] / (a[i] * a[i]), D00 = p0[i], D10 = p1[i], D11 = p2[i];
    // All of A but epsilon goes with a'^-2.
    const double second = b[i] * b[i] + c[i] * c[i], weight = 2 * (kappa * D00 + D11);
    p0[i] = -2 * q / a[i] * (D00 * (1 + kappa * second) + D10 * b[i] + D11 * (second + kappa));
    p1[i] = q * (weight * b[i] + D10);
    p2[i] = q * weight * c[i];
  }
}

SKINFIELD_VECTOR_CLONES
void solid_parameters(const Columns& of, double* D, std::ptrdiff_t begin, std::ptrdiff_t end) {
  const std::ptrdiff_t n = of.stride;
  const double kappa = of.kappa, *s = of.scale, *pa = of.theta, *pb = pa + n, *pc = pb + n,
               *pd = pc + n, *pe = pd + n, *pf = pe + n;
  double* __restrict p0 = D, * __restrict p1 = D + n, * __restrict p2 = D + 2 * n, * __restrict p3 = D + 3 * n, * __restrict p4 = D + 4 * n, * __restrict p5 = D + 5 * n;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double b = pb[i], c = pc[i], d = pd[i], e = pe[i], f = pf[i];
    const double D00 = p0[i], D10 = p1[i], D20 = p2[i], D11 = p3[i], D21 = p4[i], D22 = p5[i];
    const double q = s[i] / (pa[i] * pa[i]);
    const double second = b * b + c * c, third = d * d + e * e + f * f;
    p0[i] = -2 * q / pa[i] *
            (D00 * (1 + kappa * (second + third)) + D10 * b + D20 * d +
             D11 * (second + kappa * (1 + third)) + D21 * (b * d + c * e) +
             D22 * (third + kappa * (1 + second)));
    const double of_second = 2 * (kappa * D00 + D11 + kappa * D22);
    const double of_third = 2 * (kappa * D00 + kappa * D11 + D22);
    p1[i] = q * (of_second * b + D10 + D21 * d);
    p2[i] = q * (of_second * c + D21 * e);
    p3[i] = q * (of_third * d + D20 + D21 * b);
    p4[i] = q * (of_third * e + D21 * c);
    p5[i] = q * of_third * f;
  }
}

using Kernel = void (*)(const Columns&, double*, std::ptrdiff_t, std::ptrdiff_t);

void run(Kernel kernel, const TensorModel& model, const Eigen::MatrixXd& theta, double* out) {
  const Columns columns{model.kappa, model.epsilon, model.scale.data(), theta.data(), theta.rows()};
  parallel_blocks(
      static_cast<std::size_t>(theta.rows()), kBlock, [&](std::size_t begin, std::size_t end) {
        kernel(columns, out, static_cast<std::ptrdiff_t>(begin), static_cast<std::ptrdiff_t>(end));
      });
}

}  // namespace

Eigen::MatrixXd identity_parameters(Eigen::Index elements, int dimension) {
  Eigen::MatrixXd theta = Eigen::MatrixXd::Zero(elements, dimension * (dimension + 1) / 2);
  theta.col(0).setOnes();
  theta.col(2).setOnes();
  if (dimension == 3) theta.col(5).setOnes();
  return theta;
}

void tensors(const TensorModel& model, const Eigen::MatrixXd& theta, Eigen::MatrixXd& A) {
  A.resize(theta.rows(), theta.cols());
  run(theta.cols() == 6 ? solid_tensors : flat_tensors, model, theta, A.data());
}

void to_parameters(const TensorModel& model, const Eigen::MatrixXd& theta, Eigen::MatrixXd& D) {
  run(theta.cols() == 6 ? solid_parameters : flat_parameters, model, theta, D.data());
}

}  // namespace skinfield
