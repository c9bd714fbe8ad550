// NumPy's .npy (versions 1 to 3) and .npz, without NumPy.
#pragma once

#include "skinfield/base/types.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skinfield {

struct NpyArray {
  std::string type;                 ///< numpy's, e.g. "<f8", "<i4", "|b1", "<U12"
  bool fortran = false;             ///< column by column
  std::vector<std::int64_t> shape;  ///< empty: a scalar
  std::string data;                 ///< exactly the elements, as in the file

  std::int64_t size() const;  ///< number of elements
};

/// Throws InputError for damaged headers, object arrays, and shapes that the data does not fill.
NpyArray parse_npy(std::string_view bytes, const std::string& name);
std::string format_npy(const NpyArray& array);

/// (n) becomes (n,1), a scalar (1,1); floats of 4 or 8 bytes and all integers. `name` is for
/// messages. Throws InputError for more than two dimensions or other types.
RowMatrix npy_matrix(const NpyArray& array, const std::string& name);
/// One-dimensional integers, checked to be whole.
std::vector<std::int64_t> npy_integers(const NpyArray& array, const std::string& name);
/// Unicode arrays as UTF-8.
std::vector<std::string> npy_strings(const NpyArray& array, const std::string& name);

NpyArray npy_from_matrix(const RowMatrix& W);
NpyArray npy_from_vector(const std::vector<double>& values);
NpyArray npy_from_integers(const std::vector<std::int64_t>& values);
NpyArray npy_from_strings(const std::vector<std::string>& utf8);

/// The arrays of an .npz by name, in file order. Throws InputError; InputError too for entries
/// that are no arrays.
using NpzArrays = std::vector<std::pair<std::string, NpyArray>>;
NpzArrays parse_npz(std::string_view bytes, const std::string& name);
std::string format_npz(const NpzArrays& arrays);
/// Null where there is none of that name.
const NpyArray* find_array(const NpzArrays& arrays, std::string_view name);

}  // namespace skinfield
