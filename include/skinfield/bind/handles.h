// From a read character to one that can be bound: its skeleton, its handles, the parts wanted.
#pragma once

#include "skinfield/io/asset.h"
#include "skinfield/rig/handles.h"

namespace skinfield {

/// Keeps the parts of that name (mesh or object) alone; vertices and rows of others go.
/// @throws InputError naming the parts that exist.
void keep_only(Asset& asset, const std::string& name);

/// The other way round, for writing a glTF whose other meshes stay as they are: a matrix for each
/// character of `whole`, with the rows of the parts of that name from `kept` (a matrix for each
/// character that keep_only leaves) and all others as `whole` has them; no rows for a character
/// without such parts.
/// @throws InputError where other parts of a character have no weights for these columns.
std::vector<SkinWeights> weights_among_others(const Asset& whole, const std::string& name,
                                              const std::vector<SkinWeights>& kept);

/// Another skeleton for a character: its existing weights are dropped.
void give_skeleton(Character& character, const Skeleton& skeleton);

/// Makes the handles by rig's rules (design.md 4): TGF bones as they are; glTF joints by
/// `options`, existing weights, and where the shape's inside is.
/// @throws InputError where no joint deforms.
void make_handles(Character& character, const JointOptions& options = {});

/// Sets of vertices as handles, behind those that the character has: a column of `regions`
/// (n_input, m) each, 1 where the vertex belongs to it and 0 elsewhere. Vertices of equal position
/// belong together; a vertex of k regions is shared by them, 1/k each. Names are those of
/// `regions`, else region_0, region_1, ... Behind a glTF's joints each becomes a root joint at the
/// mean of its vertices.
/// @throws InputError where the rows are not the character's vertices, an entry is neither 0 nor 1,
/// or a region has no vertex.
void add_regions(Character& character, const SkinWeights& regions);

}  // namespace skinfield
