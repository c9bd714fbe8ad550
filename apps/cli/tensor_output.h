// The metric of quasi-harmonic weights as a file: numbers or a picture.
#pragma once

#include "skinfield/bind/bind.h"

#include <string>

namespace skinfield::cli {

/// Throws UsageError unless the name ends in .npz or .png.
void check_tensor_output(const std::string& path);

/// .npz: nodes (N,3), elements (e,4) or (e,3), direction (e,3), condition (e). .png: condition
/// numbers as a heat map from 1 to the largest seen, of triangles themselves, of tetrahedra where
/// the plane across the box's shortest side, at the middle element, cuts them.
std::string format_tensors(const TensorField& field, const std::string& path);

}  // namespace skinfield::cli
