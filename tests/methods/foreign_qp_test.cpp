// The weights by another program altogether: SciPy.
#include "methods/box_case.h"
#include "skinfield/methods/bounded_biharmonic_active_set.h"
#include "skinfield/methods/bounded_biharmonic_dual.h"
#include "skinfield/methods/decoupled_biharmonic.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace skinfield {
namespace {

RowMatrix read(std::istream& in, Eigen::Index rows, Eigen::Index columns) {
  RowMatrix W(rows, columns);
  for (double& w : W.reshaped<Eigen::RowMajor>()) in >> w;
  return W;
}

TEST(ForeignQp, SciPyAgrees) {
  const skinfield_test::BoxCase box(3, 5);
  const auto folder = std::filesystem::path(::testing::TempDir());
  const auto in = folder / "foreign_qp_in.txt", out = folder / "foreign_qp_out.txt";
  const Eigen::MatrixXd A = box.M.cwiseSqrt().cwiseInverse().asDiagonal() * Eigen::MatrixXd(box.K);
  {
    std::ofstream file(in);
    file.precision(17);
    file << A.rows() << ' ' << 3 << ' ' << box.fixed.node.size() << '\n' << A << '\n';
    for (std::size_t k = 0; k < box.fixed.node.size(); ++k) {
      file << box.fixed.node[k] << ' ' << box.fixed.weights.row(static_cast<Eigen::Index>(k))
           << '\n';
    }
  }
  const std::string source = SKINFIELD_SOURCE_DIR;
  const std::string command = "'" + source + "/tools/with_python.sh' '" + source +
                              "/tests/methods/foreign_qp.py' '" + in.string() + "' '" +
                              out.string() + "'";
  const int status = std::system(command.c_str());
  if (WEXITSTATUS(status) != 0) {
    ASSERT_TRUE(WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 1) << command;
    const int python = std::system(("'" + source +
                                    "/tools/with_python.sh' -c 'import scipy' "
                                    "2>/dev/null")
                                       .c_str());
    ASSERT_NE(python, 0) << "SciPy is there, but failed: " << command;
    GTEST_SKIP() << "no Python with SciPy";
  }
  std::ifstream file(out);
  const RowMatrix coupled = read(file, A.rows(), 3), bounded = read(file, A.rows(), 3);
  ASSERT_TRUE(file.good());
  std::filesystem::remove(in);
  std::filesystem::remove(out);
  ASSERT_GT((coupled - bounded).cwiseAbs().maxCoeff(), 1e-3);  // two programs, not one

  const auto difference = [](const RowMatrix& X, const RowMatrix& Y) {
    return (X - Y).cwiseAbs().maxCoeff();
  };
  BoundedBiharmonicOptions primal;
  primal.tolerance = 1e-7;
  primal.max_iterations = 3000;
  EXPECT_LT(difference(bounded_biharmonic(box.problem(), primal).W, coupled), 1e-5);
  BoundedBiharmonicDualOptions dual;
  dual.dual.relative_gap = 1e-9;
  EXPECT_LT(difference(bounded_biharmonic_dual(box.problem(), dual).W, coupled), 1e-3);
  EXPECT_LT(difference(bounded_biharmonic_active_set(box.problem()).W, coupled), 1e-5);
  DecoupledBiharmonicOptions decoupled;
  decoupled.tolerance = 1e-7;
  decoupled.max_iterations = 3000;
  EXPECT_LT(difference(decoupled_biharmonic(box.problem(), decoupled).raw, bounded), 1e-5);
  decoupled.solver = DecoupledSolver::dual;
  decoupled.dual.relative_gap = 1e-9;
  EXPECT_LT(difference(decoupled_biharmonic(box.problem(), decoupled).raw, bounded), 1e-3);
}

}  // namespace
}  // namespace skinfield
