// Weight matrices in files, painted rows, by extension.
#pragma once

#include "skinfield/weights/skin_weights.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

/// (n,m) weights from .npz (`weights` dense, or CSR `data indices indptr shape`, with optional
/// `handle_names`), .npy, .dmat, .csv or .mtx. Values as in the file (zeros dropped), so that rows
/// need not be on the simplex. Throws InputError for non-finite values and empty matrices.
SkinWeights read_weights(const std::filesystem::path& path);
/// The same from bytes; `extension` in lower case with its dot, `name` for messages.
SkinWeights parse_weights(std::string_view bytes, const std::string& extension,
                          const std::string& name);

enum class WeightsLayout { dense, csr };  ///< of an .npz; other formats are dense

/// .npz, .npy, .dmat, .csv: float64 (text with 17 significant digits), written atomically.
/// Throws InputError for another extension, IoError where the file cannot be written.
void write_weights(const std::filesystem::path& path, const SkinWeights& weights,
                   WeightsLayout layout = WeightsLayout::dense);
std::string format_weights(const SkinWeights& weights, const std::string& extension,
                           WeightsLayout layout = WeightsLayout::dense);
/// True for the extensions that `write_weights` knows.
bool is_weights_extension(const std::string& extension);

/// Prescribed rows on input vertices.
struct PaintFile {
  std::vector<int> index;          ///< (k) 0-based, each once
  RowMatrix weights;               ///< (k,m) rows on the simplex
  std::vector<std::string> names;  ///< (m) or empty
};

/// .npz with `index` (k) and `weights` (k,m), or .csv of an index and m weights a line. Rows may
/// miss a sum of 1 by 1e-3 and are then scaled. Throws InputError for an index outside
/// [0, vertices), a repeated one, negative or non-finite weights, other sums.
PaintFile read_paint(const std::filesystem::path& path, Eigen::Index vertices);
PaintFile parse_paint(std::string_view bytes, const std::string& extension, Eigen::Index vertices,
                      const std::string& name);

}  // namespace skinfield
