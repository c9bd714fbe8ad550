// glTF 2.0 (.glb, .gltf) in and out. The source document travels whole with the Asset, so that a
// rigged file differs from its source by our accessors only.
#pragma once

#include "skinfield/io/asset.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace skinfield {

/// Reads a glTF file: one Character per set of joints that skins name, with all primitives under
/// it. Positions are in the POSITION space of the character's first skin; parts of further skins
/// are brought there through the inverse bind matrices. Coincident vertices (1e-6 of the box
/// diagonal) are merged. Without any skin, all mesh nodes of the scene become one character in
/// world space with an empty skeleton. Rows of `Character::weights` are normalised.
/// Throws InputError naming the file and the thing in it: damaged or truncated data, indices or
/// accessors out of range, joint cycles, non-finite positions, geometry that a required extension
/// encodes (Draco, meshopt), no vertices.
Asset read_gltf(const std::filesystem::path& path);

/// The same from memory. `name` stands for the file in messages; buffers in files of their own
/// are looked up in `folder`, and refused where it is empty.
Asset read_gltf_bytes(std::span<const std::byte> bytes, std::string name,
                      const std::filesystem::path& folder = {});

/// The joints of a file's skin, with or without a mesh. Throws InputError, also where there is no
/// skin, or several of different joints.
Skeleton read_gltf_skeleton(const std::filesystem::path& path);

enum class GltfWeightFormat { float32, unorm16, unorm8 };

struct GltfWriteOptions {
  GltfWeightFormat format = GltfWeightFormat::float32;
};

/// Writes `source` with these weights, one matrix a character: (n_input, columns), rows on the
/// simplex; a matrix of no rows leaves its character as it is. As many JOINTS_n/WEIGHTS_n sets are
/// written as the fullest row asks for; within a row influences descend and sum exactly to one
/// after rounding. A row without entries goes to joint 0.
///
/// A glTF source keeps its document. If the character's skeleton is the document's own, only
/// weight accessors change. Any other skeleton becomes new joint nodes and a skin; mesh nodes'
/// world transforms go into the inverse bind matrices, and a mesh under a moved or nested node is
/// shown by a new root node, as skinned meshes should be. TGF bones become a joint at each bone's
/// head, with extra joints without weights at leaf ends. Other sources get a fresh document with
/// positions, normals, texture coordinates and base colours.
///
/// `.gltf` embeds its buffers; image links are kept valid for the new folder. Written atomically.
/// Throws InputError for weights that do not fit the source or a name that ends in neither .glb
/// nor .gltf, IoError where the file cannot be written.
void write_gltf(const Asset& source, std::span<const SkinWeights> weights,
                const std::filesystem::path& path, const GltfWriteOptions& options = {});

/// The same into memory. `folder` is where the file will lie; empty: beside the source.
std::string format_gltf(const Asset& source, std::span<const SkinWeights> weights, bool binary,
                        const GltfWriteOptions& options = {},
                        const std::filesystem::path& folder = {});

/// The meshes alone with a colour a vertex: no skin, nothing of the source's document. colours:
/// (n_input,3) linear RGB from 0 to 1, a matrix a character. Throws InputError where sizes differ.
std::string format_coloured_gltf(const Asset& source, std::span<const Points> colours, bool binary);

}  // namespace skinfield
