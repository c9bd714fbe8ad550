#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/matrix_file.h"
#include "skinfield/io/npy.h"
#include "skinfield/io/weights_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr double kSumTolerance = 1e-3;

void take_npz(std::string_view bytes, const std::string& name, PaintFile& paint,
              std::vector<double>& index) {
  const NpzArrays arrays = parse_npz(bytes, name);
  const NpyArray *rows = find_array(arrays, "index"), *weights = find_array(arrays, "weights");
  if (!rows || !weights) {
    throw InputError("lacks \"index\" or \"weights\"", name, "save both with numpy.savez");
  }
  const RowMatrix list = npy_matrix(*rows, name);
  index.assign(list.data(), list.data() + list.size());
  paint.weights = npy_matrix(*weights, name);
  if (const NpyArray* names = find_array(arrays, "handle_names")) {
    paint.names = npy_strings(*names, name);
  }
}

void take_csv(std::string_view bytes, const std::string& name, PaintFile& paint,
              std::vector<double>& index) {
  CsvTable table = parse_csv(bytes, name);
  if (table.values.cols() < 2) {
    throw InputError("needs an index and at least one weight a line", name, "add the weights");
  }
  index.assign(table.values.col(0).begin(), table.values.col(0).end());
  paint.weights = table.values.rightCols(table.values.cols() - 1);
  if (!table.header.empty()) paint.names.assign(table.header.begin() + 1, table.header.end());
}

}  // namespace

PaintFile parse_paint(std::string_view bytes, const std::string& extension, Eigen::Index vertices,
                      const std::string& name) {
  PaintFile paint;
  std::vector<double> index;
  if (extension == ".npz") {
    take_npz(bytes, name, paint, index);
  } else if (extension == ".csv") {
    take_csv(bytes, name, paint, index);
  } else {
    throw InputError("unknown format of painted rows", name, "give .npz or .csv");
  }
  RowMatrix& W = paint.weights;
  if (static_cast<Eigen::Index>(index.size()) != W.rows() || W.size() == 0) {
    throw InputError(fmt::format("has {} indices for {} rows of weights", index.size(), W.rows()),
                     name, "give one index a row");
  }
  if (!paint.names.empty() && paint.names.size() != static_cast<std::size_t>(W.cols())) {
    throw InputError("has another number of names than of columns", name, "write it again");
  }
  for (std::size_t k = 0; k < index.size(); ++k) {
    const double v = index[k];
    if (!(v >= 0 && v < static_cast<double>(vertices)) || v != std::floor(v)) {
      throw InputError(fmt::format("row {} paints vertex {} of {}", k + 1, v, vertices), name,
                       "indices count from 0 in the order of the input file");
    }
    paint.index.push_back(static_cast<int>(v));
    auto row = W.row(static_cast<Eigen::Index>(k));
    const double sum = row.sum();
    if (!(row.minCoeff() >= 0) || !(std::abs(sum - 1) <= kSumTolerance)) {
      throw InputError(fmt::format("row {} is negative, not finite, or does not sum to 1", k + 1),
                       name, "normalise the painted rows");
    }
    row /= sum;
  }
  std::vector<int> sorted = paint.index;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    throw InputError(fmt::format("paints vertex {} twice", *twice), name, "keep one row");
  }
  return paint;
}

PaintFile read_paint(const std::filesystem::path& path, Eigen::Index vertices) {
  return parse_paint(read_file(path), lower_extension(path), vertices, path.string());
}

}  // namespace skinfield
