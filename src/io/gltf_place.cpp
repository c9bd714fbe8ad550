// Bringing the parts of several skins into one bind space.
#include "io/gltf_document.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace skinfield::gltf {
namespace {

bool invertible(const Transform& T) {
  const Eigen::Matrix3d L = T.topLeftCorner<3, 3>();
  const double size = L.norm();
  return std::abs(L.determinant()) > 1e-12 * size * size * size;
}

Transform affine_inverse(const Transform& T) {
  Transform inverse = Transform::Identity();
  inverse.topLeftCorner<3, 3>() = T.topLeftCorner<3, 3>().inverse();
  inverse.topRightCorner<3, 1>() = -inverse.topLeftCorner<3, 3>() * T.topRightCorner<3, 1>();
  return inverse;
}

/// The largest distance that the corners of `box` move apart under A and B.
double corner_distance(const Box3& box, const Transform& A, const Transform& B) {
  double worst = 0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector4d corner(box(k & 1, 0), box(k >> 1 & 1, 1), box(k >> 2 & 1, 2), 1);
    worst = std::max(worst, ((A - B) * corner).norm());
  }
  return worst;
}

/// How the pieces' vertices follow their weights from their own bind pose to the character's.
void blend(const std::vector<Transform>& T, const Transform& otherwise, PrimitiveData& piece) {
  std::vector<Transform> of_vertex(static_cast<std::size_t>(piece.V.rows()), Transform::Zero());
  std::vector<double> sum(of_vertex.size(), 0.0);
  for (const auto& entry : piece.weights) {
    const auto v = static_cast<std::size_t>(entry.row());
    of_vertex[v] += entry.value() * T[static_cast<std::size_t>(entry.col())];
    sum[v] += entry.value();
  }
  for (Eigen::Index v = 0; v < piece.V.rows(); ++v) {
    const auto k = static_cast<std::size_t>(v);
    PrimitiveData one;
    one.V = piece.V.row(v);
    if (piece.N.rows() > 0) one.N = piece.N.row(v);
    move_piece(sum[k] > 0 ? of_vertex[k] : otherwise, one);
    piece.V.row(v) = one.V.row(0);
    if (piece.N.rows() > 0) piece.N.row(v) = one.N.row(0);
  }
}

}  // namespace

std::string skin_key(const Skin& skin) {
  std::string key(reinterpret_cast<const char*>(skin.joints.data()),
                  skin.joints.size() * sizeof(int));
  for (const Transform& T : skin.inverse_bind) {
    key.append(reinterpret_cast<const char*>(T.data()), sizeof(double) * 16);
  }
  return key;
}

void move_piece(const Transform& T, PrimitiveData& piece) {
  if (T.isIdentity(0)) return;
  const Eigen::Matrix3d L = T.topLeftCorner<3, 3>();
  const Eigen::RowVector3d t = T.topRightCorner<3, 1>().transpose();
  piece.V = ((piece.V * L.transpose()).rowwise() + t).eval();
  if (piece.N.rows() > 0 && invertible(T)) piece.N = (piece.N * L.inverse()).eval();
}

Transform place_in_bind_space(const Skin& first, const Skin& skin,
                              const std::vector<int>& slot_of_column,
                              std::vector<PrimitiveData>& pieces, bool& posed) {
  if (skin_key(skin) == skin_key(first) || pieces.empty()) return Transform::Identity();
  std::vector<char> used(skin.joints.size(), 0);
  Box3 box = bounding_box(pieces.front().V);
  for (const PrimitiveData& piece : pieces) {
    for (const auto& entry : piece.weights) used[static_cast<std::size_t>(entry.col())] = 1;
    const Box3 other = bounding_box(piece.V);
    box.row(0) = box.row(0).cwiseMin(other.row(0));
    box.row(1) = box.row(1).cwiseMax(other.row(1));
  }
  const bool any_used = std::find(used.begin(), used.end(), 1) != used.end();
  std::vector<Transform> T(skin.joints.size(), Transform::Identity());
  int reference = -1;
  bool consistent = true;
  for (std::size_t j = 0; j < slot_of_column.size(); ++j) {
    const auto slot = static_cast<std::size_t>(slot_of_column[j]);
    if ((any_used && !used[slot]) || !invertible(first.inverse_bind[j])) continue;
    T[slot] = affine_inverse(first.inverse_bind[j]) * skin.inverse_bind[slot];
    if (reference < 0) reference = static_cast<int>(slot);
    const Transform& R = T[static_cast<std::size_t>(reference)];
    const double size = R.topLeftCorner<3, 3>().norm() * diagonal(box);
    if (corner_distance(box, T[slot], R) > 1e-3 * size) consistent = false;
  }
  if (reference < 0) return Transform::Identity();
  Transform common = T[static_cast<std::size_t>(reference)];
  const Transform identity = Transform::Identity();
  if (corner_distance(box, common, identity) <= 1e-5 * diagonal(box)) common = identity;
  posed = !consistent;
  for (PrimitiveData& piece : pieces) {
    if (consistent) {
      move_piece(common, piece);
    } else {
      blend(T, common, piece);
    }
  }
  return common;
}

}  // namespace skinfield::gltf
