#include "skinfield/io/matrix_file.h"

#include "io/bytes.h"
#include "io/text.h"
#include "skinfield/io/file.h"
#include "skinfield/io/npy.h"

#include <fmt/format.h>

namespace skinfield {
namespace {

// What a dense matrix may take; a sparse file of a few bytes can claim any size.
constexpr std::int64_t kLargestDense = std::int64_t{1} << 28;

void parse_size(text::Tokens& tokens, std::int64_t& columns, std::int64_t& rows) {
  columns = tokens.integer("the number of columns");
  rows = tokens.integer("the number of rows");
  if (columns < 0 || rows < 0 || columns > INT32_MAX || rows > INT32_MAX) {
    tokens.fail("an impossible size", "the file is damaged");
  }
}

RowMatrix dense(const SparseRows& sparse, const std::string& name) {
  if (std::int64_t{sparse.rows()} * sparse.cols() > kLargestDense) {
    throw InputError("the matrix is too large to be dense", name, "save it as a vector");
  }
  return RowMatrix(sparse);
}

const NpyArray& only_array(const NpzArrays& arrays, const std::string& name) {
  if (arrays.size() != 1) {
    throw InputError("holds " + std::to_string(arrays.size()) + " arrays, not one", name,
                     "save the one array as .npy");
  }
  return arrays.front().second;
}

}  // namespace

RowMatrix parse_dmat(std::string_view bytes, const std::string& name) {
  text::Tokens tokens(bytes, name);
  std::int64_t columns = 0, rows = 0;
  parse_size(tokens, columns, rows);
  const bool binary = columns == 0 && rows == 0 && !tokens.done();
  if (binary) {
    parse_size(tokens, columns, rows);
    const std::string rest(tokens.rest_of_line());
    if (!rest.empty()) tokens.fail("text after the size of a binary DMAT", "the file is damaged");
    ByteReader reader(bytes.substr(bytes.size() - tokens.remaining()), name);
    if (rows > 0) reader.expect(static_cast<std::uint64_t>(rows), 8, "rows");
    if (columns > 0) {
      reader.expect(static_cast<std::uint64_t>(columns), 8 * static_cast<std::size_t>(rows),
                    "columns");
    }
    RowMatrix W(rows, columns);
    for (std::int64_t j = 0; W.size() > 0 && j < columns; ++j) {
      for (std::int64_t i = 0; i < rows; ++i) W(i, j) = reader.get<double>("the matrix");
    }
    return W;
  }
  const auto left = static_cast<std::int64_t>(tokens.remaining() / 2 + 1);
  if (rows > 0 && columns > left / rows) {
    tokens.fail("claims more numbers than the file can hold", "it is truncated or damaged");
  }
  RowMatrix W(rows, columns);
  for (std::int64_t j = 0; W.size() > 0 && j < columns; ++j) {
    for (std::int64_t i = 0; i < rows; ++i) W(i, j) = tokens.number("an entry of the matrix");
  }
  return W;
}

std::string format_dmat(const RowMatrix& W, bool binary) {
  std::string head = std::to_string(W.cols()) + " " + std::to_string(W.rows()) + "\n";
  if (binary) {
    std::string out = "0 0\n" + head;
    for (Eigen::Index j = 0; j < W.cols(); ++j) {
      for (Eigen::Index i = 0; i < W.rows(); ++i) put_little(out, W(i, j));
    }
    return out;
  }
  fmt::memory_buffer out;
  out.append(head);
  for (Eigen::Index j = 0; j < W.cols(); ++j) {
    for (Eigen::Index i = 0; i < W.rows(); ++i) {
      fmt::format_to(std::back_inserter(out), "{:.17g}\n", W(i, j));
    }
  }
  return fmt::to_string(out);
}

SparseRows parse_matrix_market(std::string_view bytes, const std::string& name) {
  text::Tokens tokens(bytes, name, '%');
  if (!bytes.starts_with("%%MatrixMarket")) {
    tokens.fail("does not begin with %%MatrixMarket", "it is no Matrix Market file");
  }
  const std::string_view first = bytes.substr(0, bytes.find('\n'));
  std::vector<std::string_view> fields;
  text::split(first, fields);
  if (fields.size() < 5 || text::lower(fields[1]) != "matrix") tokens.fail("is no matrix");
  const std::string layout = text::lower(fields[2]), field = text::lower(fields[3]),
                    symmetry = text::lower(fields[4]);
  const bool coordinate = layout == "coordinate", pattern = field == "pattern",
             symmetric = symmetry == "symmetric";
  if ((!coordinate && layout != "array") ||
      (!pattern && field != "real" && field != "integer" && field != "double") ||
      (!symmetric && symmetry != "general") || (!coordinate && (pattern || symmetric))) {
    tokens.fail("a kind of matrix that is not read", "save it as general and real");
  }
  const std::int64_t rows = tokens.integer("the number of rows");
  const std::int64_t columns = tokens.integer("the number of columns");
  const auto most = static_cast<std::int64_t>(16 * bytes.size());
  if (rows < 0 || columns < 0 || rows > most || columns > most || rows > INT32_MAX ||
      columns > INT32_MAX) {
    tokens.fail("a size that the file cannot fill", "the file is truncated or damaged");
  }
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  if (coordinate) {
    const std::int64_t count = tokens.count("the number of entries", pattern ? 4 : 6);
    entries.reserve(static_cast<std::size_t>(count));
    for (std::int64_t k = 0; k < count; ++k) {
      const std::int64_t i = tokens.integer("a row"), j = tokens.integer("a column");
      const double value = pattern ? 1.0 : tokens.number("an entry");
      if (i < 1 || j < 1 || i > rows || j > columns || (symmetric && (j > rows || i > columns))) {
        tokens.fail("an entry outside the matrix", "the file is damaged");
      }
      const auto r = static_cast<std::int32_t>(i - 1), c = static_cast<std::int32_t>(j - 1);
      entries.emplace_back(r, c, value);
      if (symmetric && r != c) entries.emplace_back(c, r, value);
    }
  } else {
    const auto left = static_cast<std::int64_t>(tokens.remaining() / 2 + 1);
    if (rows > 0 && columns > left / rows) {
      tokens.fail("claims more numbers than the file can hold", "it is truncated or damaged");
    }
    for (std::int64_t j = 0; rows > 0 && j < columns; ++j) {
      for (std::int64_t i = 0; i < rows; ++i) {
        const double value = tokens.number("an entry");
        if (value == 0) continue;
        entries.emplace_back(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j), value);
      }
    }
  }
  SparseRows out(static_cast<std::int32_t>(rows), static_cast<std::int32_t>(columns));
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

RowMatrix read_matrix(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path), bytes = read_file(path);
  const std::string name = path.string();
  if (extension == ".npy") return npy_matrix(parse_npy(bytes, name), name);
  if (extension == ".npz") return npy_matrix(only_array(parse_npz(bytes, name), name), name);
  if (extension == ".dmat") return parse_dmat(bytes, name);
  if (extension == ".csv") return parse_csv(bytes, name).values;
  if (extension == ".mtx") return dense(parse_matrix_market(bytes, name), name);
  throw InputError("unknown matrix format", name,
                   "matrices are read from .npy .npz .dmat .csv .mtx");
}

Vector read_vector(const std::filesystem::path& path) {
  const std::string name = path.string();
  if (lower_extension(path) == ".mtx") {
    const SparseRows sparse = parse_matrix_market(read_file(path), name);
    if (sparse.rows() == sparse.cols() && sparse.rows() > 1) return sparse.diagonal();
    if (sparse.cols() == 1 || sparse.rows() == 1) {
      const RowMatrix W = dense(sparse, name);
      return Eigen::Map<const Vector>(W.data(), W.size());
    }
  } else {
    const RowMatrix W = read_matrix(path);
    if (W.cols() == 1 || W.rows() == 1) return Eigen::Map<const Vector>(W.data(), W.size());
  }
  throw InputError("is a matrix, not a vector", name, "give one row or one column");
}

}  // namespace skinfield
