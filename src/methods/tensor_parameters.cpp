#include "methods/tensor_parameters.h"

#include "skinfield/base/parallel.h"

namespace skinfield {
namespace {

constexpr std::size_t kBlock = 2048;

/// One column of a block of elements.
template <class Matrix>
auto part(Matrix& A, Eigen::Index column, std::size_t begin, std::size_t end) {
  return A.col(column)
      .segment(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin))
      .array();
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
  const double kappa = model.kappa, epsilon = model.epsilon;
  const bool space = theta.cols() == 6;
  parallel_blocks(static_cast<std::size_t>(theta.rows()), kBlock,
                  [&](std::size_t begin, std::size_t end) {
                    const auto t = [&](Eigen::Index k) { return part(theta, k, begin, end); };
                    const auto out = [&](Eigen::Index k) { return part(A, k, begin, end); };
                    const Eigen::ArrayXd scale = part(model.scale, 0, begin, end);
                    const Eigen::ArrayXd q = scale / t(0).square();
                    const Eigen::ArrayXd second = t(1).square() + t(2).square();  // b^2 + c^2
                    if (!space) {
                      out(0) = q * (1 + kappa * second) + epsilon * scale;
                      out(1) = q * t(1);
                      out(2) = q * (second + kappa) + epsilon * scale;
                      return;
                    }
                    const Eigen::ArrayXd third = t(3).square() + t(4).square() + t(5).square();
                    out(0) = q * (1 + kappa * (second + third)) + epsilon * scale;
                    out(1) = q * t(1);
                    out(2) = q * t(3);
                    out(3) = q * (second + kappa * (1 + third)) + epsilon * scale;
                    out(4) = q * (t(1) * t(3) + t(2) * t(4));
                    out(5) = q * (third + kappa * (1 + second)) + epsilon * scale;
                  });
}

void to_parameters(const TensorModel& model, const Eigen::MatrixXd& theta, Eigen::MatrixXd& D) {
  const double kappa = model.kappa;
  const bool space = theta.cols() == 6;
  parallel_blocks(
      static_cast<std::size_t>(theta.rows()), kBlock, [&](std::size_t begin, std::size_t end) {
        const auto t = [&](Eigen::Index k) { return part(theta, k, begin, end); };
        const auto out = [&](Eigen::Index k) { return part(D, k, begin, end); };
        const Eigen::ArrayXd q = part(model.scale, 0, begin, end) / t(0).square();
        const auto b = t(1), c = t(2);
        if (!space) {
          const Eigen::ArrayXd D00 = out(0), D10 = out(1), D11 = out(2);
          // All of A but epsilon goes with a'^-2.
          const Eigen::ArrayXd second = b.square() + c.square();
          out(0) = -2 * q / t(0) * (D00 * (1 + kappa * second) + D10 * b + D11 * (second + kappa));
          const Eigen::ArrayXd weight = 2 * (kappa * D00 + D11);
          out(1) = q * (weight * b + D10);
          out(2) = q * weight * c;
          return;
        }
        const auto d = t(3), e = t(4), f = t(5);
        const Eigen::ArrayXd D00 = out(0), D10 = out(1), D20 = out(2), D11 = out(3), D21 = out(4),
                             D22 = out(5);
        const Eigen::ArrayXd second = b.square() + c.square();
        const Eigen::ArrayXd third = d.square() + e.square() + f.square();
        out(0) = -2 * q / t(0) *
                 (D00 * (1 + kappa * (second + third)) + D10 * b + D20 * d +
                  D11 * (second + kappa * (1 + third)) + D21 * (b * d + c * e) +
                  D22 * (third + kappa * (1 + second)));
        const Eigen::ArrayXd of_second = 2 * (kappa * D00 + D11 + kappa * D22);
        const Eigen::ArrayXd of_third = 2 * (kappa * D00 + kappa * D11 + D22);
        out(1) = q * (of_second * b + D10 + D21 * d);
        out(2) = q * (of_second * c + D21 * e);
        out(3) = q * (of_third * d + D20 + D21 * b);
        out(4) = q * (of_third * e + D21 * c);
        out(5) = q * of_third * f;
      });
}

}  // namespace skinfield
