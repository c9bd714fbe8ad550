// Meshes as bytes, for the way between processes.
#pragma once

#include "skinfield/base/types.h"

#include <cstring>
#include <string>

namespace skinfield {

template <class Matrix>
void append_bytes(const Matrix& X, std::string& to) {
  const auto rows = static_cast<std::int64_t>(X.rows());
  to.append(reinterpret_cast<const char*>(&rows), sizeof rows);
  to.append(reinterpret_cast<const char*>(X.data()),
            static_cast<std::size_t>(X.size()) * sizeof(typename Matrix::Scalar));
}

/// Reads what append_bytes wrote at `at` and moves `at` on. Precondition: it was written there.
template <class Matrix>
Matrix take_bytes(const std::string& from, std::size_t& at) {
  std::int64_t rows = 0;
  std::memcpy(&rows, from.data() + at, sizeof rows);
  at += sizeof rows;
  Matrix X(rows, Matrix::ColsAtCompileTime);
  const std::size_t bytes = static_cast<std::size_t>(X.size()) * sizeof(typename Matrix::Scalar);
  if (bytes > 0) std::memcpy(X.data(), from.data() + at, bytes);
  at += bytes;
  return X;
}

}  // namespace skinfield
