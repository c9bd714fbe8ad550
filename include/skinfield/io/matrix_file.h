// Matrices from .npy .npz .dmat .csv .mtx, and out again where that makes sense.
#pragma once

#include "skinfield/base/types.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

/// A dense matrix by extension; an .npz must hold exactly one array. Throws InputError.
RowMatrix read_matrix(const std::filesystem::path& path);
/// A vector (n): one row or column of the above, or the diagonal of a sparse square .mtx.
Vector read_vector(const std::filesystem::path& path);

/// DMAT: `columns rows`, then values column by column; binary after a first line `0 0`.
RowMatrix parse_dmat(std::string_view bytes, const std::string& name);
/// 17 significant digits, or binary.
std::string format_dmat(const RowMatrix& W, bool binary = false);

struct CsvTable {
  std::vector<std::string> header;  ///< empty where the first line is numbers
  RowMatrix values;
};
/// Separated by commas, semicolons, tabs or blanks (the first line decides). A first line with
/// anything quoted or not a number is a header. Throws InputError for ragged or empty tables.
CsvTable parse_csv(std::string_view bytes, const std::string& name);
/// Commas, 17 significant digits, header fields in quotes.
std::string format_csv(const CsvTable& table);

/// Matrix Market: array or coordinate; real, integer or pattern; general or symmetric.
SparseRows parse_matrix_market(std::string_view bytes, const std::string& name);

}  // namespace skinfield
