// A character with weights, put into a pose: what `pose`, `render` and `compare` share.
#pragma once

#include "cli.h"

#include "skinfield/rig/skeleton.h"

#include <span>

namespace skinfield::cli {

/// Weights over the merged vertices of the mesh (its rows: the first input vertex of each).
SkinWeights merged_weights(const Character& character, const SkinWeights& input_weights);

/// The character's own weights, or those of `weights_path`.
/// @throws InputError where there are none, or sizes differ.
SkinWeights weights_of(const Asset& asset, int character, const std::string& weights_path);

/// One transform a column. `pose`: demo, rest, FILE.json, FILE.dmat, or ANIMATION@SECONDS
/// (a name or a number) of a glTF file.
std::vector<Transform> pose_transforms(const Asset& asset, int character, const std::string& pose);

/// How a glTF viewer turns the character from its bind space at rest (the skins of many exporters
/// lie on their backs there): a rotation, the identity for everything else.
Eigen::Matrix3d turn_to_world(const Asset& asset, int character);

/// Rows of merged weights moved by linear blend (`lbs`) or dual quaternions (`dqs`).
Points deformed(const Points& V, const SkinWeights& weights, std::span<const Transform> columns,
                const std::string& skinning);

}  // namespace skinfield::cli
