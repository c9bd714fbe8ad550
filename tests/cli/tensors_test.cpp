// The metric of quasi-harmonic weights as a file.
#include "cli/characters.h"
#include "skinfield/io/npy.h"

namespace skinfield_test {
namespace {

using namespace skinfield;

TEST(Tensors, AreWrittenForEveryElement) {
  const BoxFolder folder;
  const std::string flat =
      "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\n"
      "f 1 5 6\nf 1 6 4\nf 5 2 3\nf 5 3 6\n";
  write_file(folder / "flat.obj", flat);
  write_file(folder / "flat.tgf", "1 0 0 0\n2 2 1 0\n#\n");
  expect_runs(folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "400", "--method",
                       "quasi-harmonic", "-o", "w.npz", "--tensors", "box.npz"});
  expect_runs(folder, {"bind", "flat.obj", "--skeleton", "flat.tgf", "--method", "quasi-harmonic",
                       "-o", "w.npz", "--tensors", "flat.npz"});
  for (const std::string name : {"box.npz", "flat.npz"}) {
    SCOPED_TRACE(name);
    const NpzArrays arrays = parse_npz(read_file(folder / name), name);
    const auto matrix = [&](const char* array) {
      return npy_matrix(*find_array(arrays, array), array);
    };
    const RowMatrix nodes = matrix("nodes"), elements = matrix("elements"),
                    direction = matrix("direction"), condition = matrix("condition");
    EXPECT_EQ(elements.cols(), name == "box.npz" ? 4 : 3);
    ASSERT_EQ(direction.rows(), elements.rows());
    ASSERT_EQ(condition.rows(), elements.rows());
    EXPECT_LT(elements.maxCoeff(), nodes.rows());
    EXPECT_LT((direction.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-12);
    EXPECT_GE(condition.minCoeff(), 1);
    EXPECT_LE(condition.maxCoeff(), 1 + 2 / 0.2);
    EXPECT_NEAR(nodes.col(0).maxCoeff(), name == "box.npz" ? 4 : 2, 1e-12) << "file units";
    if (name == "flat.npz") {
      EXPECT_EQ(direction.col(2).cwiseAbs().maxCoeff(), 0);
    }
  }
}

TEST(Tensors, AreDrawnOnASlice) {
  const BoxFolder folder;
  expect_runs(folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "400", "--method",
                       "quasi-harmonic", "-o", "w.npz", "--tensors", "slice.png"});
  EXPECT_TRUE(read_file(folder / "slice.png").starts_with("\x89PNG"));
}

TEST(Tensors, AreRefusedWhereThereAreNone) {
  const BoxFolder folder;
  const std::vector<std::string> base{"bind", "box.obj", "--skeleton", "box.tgf", "-o", "out.glb"};
  auto other = base, wrong = base;
  other.insert(other.end(), {"--tensors", "t.npz"});
  expect_refused(folder, other, 2, {"--tensors", "bbw", "no tensors"});
  wrong.insert(wrong.end(), {"--method", "quasi-harmonic", "--tensors", "t.csv"});
  expect_refused(folder, wrong, 2, {"t.csv", ".npz"});
}

}  // namespace
}  // namespace skinfield_test
