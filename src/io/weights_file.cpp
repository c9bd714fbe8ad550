#include "skinfield/io/weights_file.h"

#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/matrix_file.h"
#include "skinfield/io/npy.h"

#include <fmt/format.h>
#include <cmath>

namespace skinfield {
namespace {

constexpr const char* kWritable = "weights are written as .npz .npy .dmat .csv";
constexpr const char* kReadable = "weights are read from .npz .npy .dmat .csv .mtx";
// Columns are handles; no rig has more, and dense rows of them would not fit memory.
constexpr std::int64_t kMostColumns = 1 << 20;

SparseRows sparse_from(const RowMatrix& W) {
  if (W.size() == 0) return {};
  std::vector<std::int32_t> per_row(static_cast<std::size_t>(W.rows()), 0);
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    per_row[static_cast<std::size_t>(i)] =
        static_cast<std::int32_t>((W.row(i).array() != 0).count());
  }
  SparseRows out(static_cast<std::int32_t>(W.rows()), static_cast<std::int32_t>(W.cols()));
  out.reserve(per_row);
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    for (Eigen::Index j = 0; j < W.cols(); ++j) {
      if (W(i, j) != 0) out.insert(i, j) = W(i, j);
    }
  }
  out.makeCompressed();
  return out;
}

SparseRows sparse_from_csr(const NpzArrays& arrays, const std::string& name) {
  const NpyArray *data = find_array(arrays, "data"), *indices = find_array(arrays, "indices"),
                 *indptr = find_array(arrays, "indptr"), *shape = find_array(arrays, "shape");
  if (!data || !indices || !indptr || !shape) {
    throw InputError("holds neither \"weights\" nor data, indices, indptr and shape", name,
                     "save the matrix as weights");
  }
  if (const NpyArray* format = find_array(arrays, "format");
      format && format->data.find("csr") == std::string::npos &&
      format->type.find('S') != std::string::npos) {
    throw InputError("the sparse matrix is not in CSR form", name, "save it after .tocsr()");
  }
  const RowMatrix values = npy_matrix(*data, name);
  const auto columns = npy_integers(*indices, name), starts = npy_integers(*indptr, name),
             size = npy_integers(*shape, name);
  const auto entries = static_cast<std::int64_t>(columns.size());
  bool good = size.size() == 2 && size[0] >= 0 && size[1] >= 0 && size[1] <= kMostColumns &&
              static_cast<std::int64_t>(starts.size()) == size[0] + 1 && values.size() == entries &&
              starts.front() == 0 && starts.back() == entries;
  for (std::size_t i = 1; good && i < starts.size(); ++i) good = starts[i] >= starts[i - 1];
  for (std::size_t k = 0; good && k < columns.size(); ++k) {
    good = columns[k] >= 0 && columns[k] < size[1];
  }
  if (!good) throw InputError("its CSR parts contradict each other", name, "write the file again");
  std::vector<Eigen::Triplet<double, std::int32_t>> triplets;
  triplets.reserve(columns.size());
  for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
    for (auto k = static_cast<std::size_t>(starts[i]); k < static_cast<std::size_t>(starts[i + 1]);
         ++k) {
      const double value = values.data()[k];
      if (value == 0) continue;
      triplets.emplace_back(static_cast<std::int32_t>(i), static_cast<std::int32_t>(columns[k]),
                            value);
    }
  }
  SparseRows W(static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]));
  W.setFromTriplets(triplets.begin(), triplets.end());
  return W;
}

SkinWeights weights_from_npz(std::string_view bytes, const std::string& name) {
  const NpzArrays arrays = parse_npz(bytes, name);
  SkinWeights out;
  const NpyArray* weights = find_array(arrays, "weights");
  if (!weights && arrays.size() == 1) weights = &arrays.front().second;
  out.W = weights ? sparse_from(npy_matrix(*weights, name)) : sparse_from_csr(arrays, name);
  if (const NpyArray* names = find_array(arrays, "handle_names")) {
    out.names = npy_strings(*names, name);
    if (out.names.size() != static_cast<std::size_t>(out.W.cols())) {
      throw InputError(
          fmt::format("has {} handle_names for {} columns", out.names.size(), out.W.cols()), name,
          "write the file again");
    }
  }
  return out;
}

void check_weights(const SkinWeights& weights, const std::string& name) {
  if (weights.W.rows() == 0 || weights.W.cols() == 0) {
    throw InputError("the weight matrix is empty", name, "name another file");
  }
  for (Eigen::Index i = 0; i < weights.W.outerSize(); ++i) {
    for (SparseRows::InnerIterator entry(weights.W, i); entry; ++entry) {
      if (!std::isfinite(entry.value())) {
        throw InputError(fmt::format("the weight in row {}, column {} is {}", entry.row() + 1,
                                     entry.col() + 1, entry.value()),
                         name, "repair or remove the row");
      }
    }
  }
}

NpzArrays csr_arrays(const SparseRows& W) {
  std::vector<double> data;
  std::vector<std::int64_t> indices, indptr = {0};
  for (Eigen::Index i = 0; i < W.outerSize(); ++i) {
    for (SparseRows::InnerIterator entry(W, i); entry; ++entry) {
      data.push_back(entry.value());
      indices.push_back(entry.col());
    }
    indptr.push_back(static_cast<std::int64_t>(data.size()));
  }
  return {{"data", npy_from_vector(data)},
          {"indices", npy_from_integers(indices)},
          {"indptr", npy_from_integers(indptr)},
          {"shape", npy_from_integers({W.rows(), W.cols()})},
          {"format", NpyArray{"|S3", false, {}, "csr"}}};  // scipy.sparse.load_npz asks for it
}

}  // namespace

bool is_weights_extension(const std::string& extension) {
  return extension == ".npz" || extension == ".npy" || extension == ".dmat" || extension == ".csv";
}

SkinWeights parse_weights(std::string_view bytes, const std::string& extension,
                          const std::string& name) {
  SkinWeights out;
  if (extension == ".npz") {
    out = weights_from_npz(bytes, name);
  } else if (extension == ".npy") {
    out.W = sparse_from(npy_matrix(parse_npy(bytes, name), name));
  } else if (extension == ".dmat") {
    out.W = sparse_from(parse_dmat(bytes, name));
  } else if (extension == ".csv") {
    CsvTable table = parse_csv(bytes, name);
    out.W = sparse_from(table.values);
    out.names = std::move(table.header);
  } else if (extension == ".mtx") {
    out.W = parse_matrix_market(bytes, name);
  } else {
    throw InputError("unknown format of weights", name, kReadable);
  }
  check_weights(out, name);
  return out;
}

SkinWeights read_weights(const std::filesystem::path& path) {
  return parse_weights(read_file(path), lower_extension(path), path.string());
}

std::string format_weights(const SkinWeights& weights, const std::string& extension,
                           WeightsLayout layout) {
  if (extension == ".npz") {
    NpzArrays arrays;
    if (layout == WeightsLayout::csr) {
      arrays = csr_arrays(weights.W);
    } else {
      arrays.emplace_back("weights", npy_from_matrix(RowMatrix(weights.W)));
    }
    if (!weights.names.empty()) {
      arrays.emplace_back("handle_names", npy_from_strings(weights.names));
    }
    return format_npz(arrays);
  }
  if (extension == ".npy") return format_npy(npy_from_matrix(RowMatrix(weights.W)));
  if (extension == ".dmat") return format_dmat(RowMatrix(weights.W));
  if (extension == ".csv") return format_csv({weights.names, RowMatrix(weights.W)});
  throw InputError("unknown format of weights: " + extension, {}, kWritable);
}

void write_weights(const std::filesystem::path& path, const SkinWeights& weights,
                   WeightsLayout layout) {
  const std::string extension = lower_extension(path);
  if (!is_weights_extension(extension)) {
    throw InputError("unknown format of weights", path.string(), kWritable);
  }
  write_file_atomically(path, format_weights(weights, extension, layout));
}

}  // namespace skinfield
