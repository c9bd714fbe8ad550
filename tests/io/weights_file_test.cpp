#include "skinfield/io/weights_file.h"

#include "io/zip.h"
#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/matrix_file.h"
#include "skinfield/io/npy.h"
#include "support/data.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace skinfield {
namespace {

void expect_refused(const std::function<void()>& body, const std::string& part) {
  try {
    body();
    ADD_FAILURE() << "nothing was thrown for: " << part;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

SkinWeights sample(bool names) {
  RowMatrix W(3, 4);
  W << 1.0 / 3, 2.0 / 3, 0, 0, 0, 0.1, 0.2, 0.7, 0, 0, 0, 1;
  SkinWeights out;
  out.W = W.sparseView();
  if (names) out.names = {"Arm", "Bein, \"links\"", "骨\xF0\x9F\xA6\xB4", "4"};
  return out;
}

TEST(WeightsFile, EveryFormatIsARoundTrip) {
  for (const bool names : {false, true}) {
    const SkinWeights weights = sample(names);
    for (const char* extension : {".npz", ".npy", ".dmat", ".csv"}) {
      for (const WeightsLayout layout : {WeightsLayout::dense, WeightsLayout::csr}) {
        const std::string bytes = format_weights(weights, extension, layout);
        const SkinWeights back = parse_weights(bytes, extension, "a");
        EXPECT_EQ(RowMatrix(back.W), RowMatrix(weights.W)) << extension;
        const std::string kind = extension;
        if (kind == ".npz" || kind == ".csv") {
          EXPECT_EQ(back.names, weights.names) << extension;
        }
        EXPECT_EQ(format_weights(weights, extension, layout), bytes) << "not deterministic";
      }
    }
  }
}

TEST(WeightsFile, WritesAtomicallyAndRefusesOtherNames) {
  const auto path = std::filesystem::temp_directory_path() / "skinfield-weights-test.NPZ";
  write_weights(path, sample(true));
  EXPECT_EQ(read_weights(path).names, sample(true).names);
  std::filesystem::remove(path);
  expect_refused([] { write_weights("a.txt", sample(false)); }, "written as .npz");
  EXPECT_THROW(write_weights("/absent-folder/a.npz", sample(false)), IoError);
}

TEST(WeightsFile, RefusesNonFiniteAndEmpty) {
  expect_refused([] { parse_weights("2 1\n0.5\nnan\n", ".dmat", "a"); }, "row 1, column 2 is nan");
  expect_refused([] { parse_weights("0 0\n", ".dmat", "a"); }, "empty");
  expect_refused([] { parse_weights("x", ".txt", "a"); }, "unknown format");
}

TEST(Npy, HeaderIsWhatNumpyWrites) {
  const std::string bytes = format_npy(npy_from_matrix(RowMatrix::Identity(2, 3)));
  EXPECT_EQ(bytes.substr(0, 10), std::string("\x93NUMPY\1\0\x76\0", 10));
  EXPECT_EQ(bytes.size(), 128u + 48u);
  EXPECT_EQ(bytes[127], '\n');
  EXPECT_NE(bytes.find("{'descr': '<f8', 'fortran_order': False, 'shape': (2,3), }"),
            std::string::npos);
}

std::string npy(const std::string& type, bool fortran, const std::string& shape,
                const std::string& data, bool version_two = false) {
  std::string header = "{'descr': '" + type +
                       "', 'fortran_order': " + (fortran ? "True" : "False") +
                       ", 'shape': " + shape + ", }\n";
  std::string out("\x93NUMPY");
  out.append(version_two ? std::string("\2\0", 2) : std::string("\1\0", 2));
  out.push_back(static_cast<char>(header.size()));
  out.append(version_two ? 3 : 1, '\0');
  return out + header + data;
}

TEST(Npy, TypesOrdersAndVersions) {
  const std::string bytes123456("\1\2\3\4\5\6", 6);
  RowMatrix C(2, 3), F(2, 3);
  C << 1, 2, 3, 4, 5, 6;
  F << 1, 3, 5, 2, 4, 6;
  EXPECT_EQ(npy_matrix(parse_npy(npy("|u1", false, "(2, 3)", bytes123456), "a"), "a"), C);
  EXPECT_EQ(npy_matrix(parse_npy(npy("|i1", true, "(2, 3)", bytes123456, true), "a"), "a"), F);
  const auto scalar = [](const std::string& type, const std::string& data) {
    return npy_matrix(parse_npy(npy(type, false, "()", data), "a"), "a")(0, 0);
  };
  EXPECT_EQ(scalar("<i2", std::string("\xFE\xFF", 2)), -2);
  EXPECT_EQ(scalar(">u2", std::string("\1\2", 2)), 258);
  EXPECT_EQ(scalar(">f4", std::string("\x3F\x80\0\0", 4)), 1);
  EXPECT_EQ(scalar("<i8", std::string("\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF", 8)), -1);
  EXPECT_EQ(scalar("|b1", "\1"), 1);
  EXPECT_EQ(npy_matrix(parse_npy(npy("|u1", false, "(2,)", "\1\2"), "a"), "a").rows(), 2);
}

TEST(Npy, RefusesDamage) {
  const auto parse = [](const std::string& bytes) { return [bytes] { parse_npy(bytes, "a"); }; };
  expect_refused(parse("PK"), "no .npy array");
  expect_refused(parse(npy("<f8", false, "(2000000000,)", "12345678")), "claims more");
  expect_refused(parse(npy("<f8", false, "(99999, 99999, 99999)", "12345678")), "claims more");
  expect_refused(parse(npy("|O", false, "(1,)", "12345678")), "not read");
  expect_refused(parse(npy("<c16", false, "(1,)", "1234567812345678")), "not read");
  expect_refused(parse(npy("<f8", false, "(-1,)", "12345678")), "shape");
  expect_refused(parse(npy("<f8", false, "7", "12345678")), "shape");
  const std::string good = npy("<f8", false, "(1,)", "12345678");
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_THROW(parse_npy(good.substr(0, size), "a"), InputError) << size;
  }
  const NpyArray cube = parse_npy(npy("|u1", false, "(1,1,1)", "x"), "a");
  expect_refused([&] { npy_matrix(cube, "a"); }, "two dimensions");
}

TEST(Npz, DamageIsNoticed) {
  const std::string good = format_weights(sample(true), ".npz");
  for (std::size_t size = 0; size < good.size(); size += 3) {
    EXPECT_THROW(parse_weights(good.substr(0, size), ".npz", "a"), InputError) << size;
  }
  std::string flipped = good;
  flipped[60] = static_cast<char>(flipped[60] ^ 0x10);
  EXPECT_THROW(parse_weights(flipped, ".npz", "a"), InputError);
  const auto contradict = [](const std::vector<std::int64_t>& indices,
                             const std::vector<std::int64_t>& indptr) {
    return [=] {
      parse_weights(format_npz({{"data", npy_from_vector({1, 1})},
                                {"indices", npy_from_integers(indices)},
                                {"indptr", npy_from_integers(indptr)},
                                {"shape", npy_from_integers({2, 2})}}),
                    ".npz", "a");
    };
  };
  contradict({0, 1}, {0, 1, 2})();
  expect_refused(contradict({0, 2}, {0, 1, 2}), "contradict");
  expect_refused(contradict({0, 1}, {0, 3, 2}), "contradict");
  expect_refused(contradict({0, 1}, {0, 2}), "contradict");
  expect_refused(
      [] {
        parse_weights(format_npz({{"x", npy_from_vector({1})}, {"y", npy_from_vector({1})}}),
                      ".npz", "a");
      },
      "holds neither");
  expect_refused(
      [] {
        parse_weights(format_npz({{"weights", npy_from_matrix(RowMatrix::Ones(1, 2))},
                                  {"handle_names", npy_from_strings({"one"})}}),
                      ".npz", "a");
      },
      "1 handle_names for 2 columns");
}

TEST(Dmat, BothFormsAreIdentities) {
  RowMatrix W(2, 3);
  W << 0.1, -2, 3e-300, 1.0 / 3, std::numeric_limits<double>::denorm_min(), 1e300;
  for (const bool binary : {false, true}) {
    EXPECT_EQ(parse_dmat(format_dmat(W, binary), "a"), W);
    expect_refused([&] { parse_dmat("4000000000 4000000000\n1", "a"); }, "impossible");
    expect_refused(
        [&] { parse_dmat((binary ? "0 0\n" : "") + std::string("60000 60000\n1"), "a"); },
        binary ? "more than the file" : "can hold");
  }
  EXPECT_EQ(format_dmat(W).substr(0, 24), "3 2\n0.10000000000000001\n");
  expect_refused([] { parse_dmat("1 2\n1\nx\n", "a.dmat"); }, "a.dmat:3");
}

TEST(Csv, HeadersQuotesAndSeparators) {
  const CsvTable plain = parse_csv("1;2\r\n# comment\n\n3; 4\n", "a");
  EXPECT_TRUE(plain.header.empty());
  EXPECT_EQ(plain.values(1, 1), 4);
  const CsvTable named = parse_csv("\xEF\xBB\xBF\"1\", a ,\"x,\"\"y\"\"\"\n1,2,3\n", "a");
  EXPECT_EQ(named.header, (std::vector<std::string>{"1", "a", "x,\"y\""}));
  EXPECT_EQ(named.values, Eigen::RowVector3d(1, 2, 3));
  EXPECT_EQ(parse_csv("1 2\t\n3 4", "a").values.rows(), 2);
  expect_refused([] { parse_csv("1,2\n3\n", "a.csv"); }, "a.csv:2: has 1 fields, not 2");
  expect_refused([] { parse_csv("1,2\n3,x\n", "a"); }, "\"x\" is not a number");
  expect_refused([] { parse_csv("a,b\n", "a"); }, "no numbers");
}

TEST(MatrixMarket, ArrayAndCoordinate) {
  const SparseRows array =
      parse_matrix_market("%%MatrixMarket matrix array real general\n% c\n2 2\n1\n0\n3\n4\n", "a");
  EXPECT_EQ(RowMatrix(array), (RowMatrix(2, 2) << 1, 3, 0, 4).finished());
  const SparseRows symmetric = parse_matrix_market(
      "%%MatrixMarket matrix coordinate integer symmetric\n3 3 2\n1 1 5\n3 1 -7\n", "a");
  EXPECT_EQ(symmetric.coeff(0, 2), -7);
  EXPECT_EQ(symmetric.coeff(2, 0), -7);
  expect_refused([] { parse_matrix_market("1 1\n1\n", "a"); }, "%%MatrixMarket");
  expect_refused(
      [] {
        parse_matrix_market(
            "%%MatrixMarket matrix coordinate real general\n"
            "2000000000 2 1\n1 1 1\n",
            "a");
      },
      "cannot fill");
  expect_refused(
      [] {
        parse_matrix_market(
            "%%MatrixMarket matrix coordinate real general\n"
            "2 2 1\n3 1 1\n",
            "a");
      },
      "outside the matrix");
}

TEST(Paint, RowsAndTheirRefusals) {
  const PaintFile csv = parse_paint("vertex,a,b\n3,0.25,0.7501\n0,0,1\n", ".csv", 4, "a");
  EXPECT_EQ(csv.index, (std::vector<int>{3, 0}));
  EXPECT_EQ(csv.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_NEAR(csv.weights.row(0).sum(), 1, 1e-15);
  const PaintFile npz =
      parse_paint(format_npz({{"index", npy_from_integers({2})},
                              {"weights", npy_from_matrix(RowMatrix::Constant(1, 2, 0.5))}}),
                  ".npz", 4, "a");
  EXPECT_EQ(npz.index, std::vector<int>{2});
  const auto parse = [](const std::string& bytes) {
    return [bytes] { parse_paint(bytes, ".csv", 4, "a"); };
  };
  expect_refused(parse("4,1\n"), "row 1 paints vertex 4 of 4");
  expect_refused(parse("-1,1\n"), "vertex -1");
  expect_refused(parse("0.5,1\n"), "vertex 0.5");
  expect_refused(parse("nan,1\n"), "vertex nan");
  expect_refused(parse("1,1\n1,1\n"), "paints vertex 1 twice");
  expect_refused(parse("1,0.5\n"), "does not sum to 1");
  expect_refused(parse("1,-0.5,1.5\n"), "negative");
  expect_refused(parse("1,nan\n"), "not finite");
  expect_refused(parse("1\n"), "at least one weight");
}

TEST(WeightsFile, SharedDataHasRowsThatSumToOne) {
  struct Case {
    const char* file;
    int rows, columns;
  };
  for (const Case& c :
       {Case{"fem/hand-refined-bbw.npz", 7234, 20}, Case{"fem/arm-weights.dmat", 8311, 4},
        Case{"surface/elephant-weights.dmat", 6034, 24},
        Case{"surface/armadillo-86k-weights.dmat", 43243, 5}}) {
    SKINFIELD_NEEDS_DATA(path, c.file);
    const SkinWeights weights = read_weights(path);
    EXPECT_EQ(weights.vertices(), c.rows) << c.file;
    EXPECT_EQ(weights.columns(), c.columns) << c.file;
    const Vector sums = weights.W * Vector::Ones(c.columns);
    EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-4) << c.file;
  }
  SKINFIELD_NEEDS_DATA(mass, "fem/tibiman-mv.mtx");
  const Vector M = read_vector(mass);
  EXPECT_EQ(M.size(), 22263);
  EXPECT_GT(M.minCoeff(), 0);
  SKINFIELD_NEEDS_DATA(fixed, "fem/tibiman-BC.mtx");
  EXPECT_EQ(read_matrix(fixed).cols(), 16);
  expect_refused([&] { read_vector(fixed); }, "not a vector");
}

TEST(Zip, StoredEntriesAreRead) {
  // "a.txt" holding "hi", stored, as any archiver writes it.
  const std::string deflated = write_zip({{"a.txt", "hi"}, {"b", ""}});
  const auto entries = read_zip(deflated, "a");
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[0].bytes, "hi");
  EXPECT_EQ(entries[1].bytes, "");
  std::string stored = deflated;
  // A deflated "hi" is cb c8 04 00; as a stored block of the zip it would be "hi" itself: rewrite
  // method, size and data of the only entry.
  stored = write_zip({{"a.txt", "hi"}});
  const std::size_t data = 30 + 5, central = data + 4;
  ASSERT_EQ(stored.substr(data, 4), std::string("\xCB\xC8\4\0", 4));
  stored.replace(data, 4, "hi");
  const std::size_t directory = central - 2;
  stored[8] = stored[directory + 10] = 0;
  stored[18] = stored[directory + 20] = 2;
  stored[stored.size() - 6] = static_cast<char>(directory);
  EXPECT_EQ(read_zip(stored, "a")[0].bytes, "hi");
}

}  // namespace
}  // namespace skinfield
