// From a read character to one that can be bound: its skeleton, its handles, the parts wanted.
#pragma once

#include "skinfield/io/asset.h"
#include "skinfield/rig/handles.h"

namespace skinfield {

/// Keeps the parts of that name (mesh or object) alone; vertices and rows of others go.
/// @throws InputError naming the parts that exist.
void keep_only(Asset& asset, const std::string& name);

/// Another skeleton for a character: its existing weights are dropped.
void give_skeleton(Character& character, const Skeleton& skeleton);

/// Makes the handles by rig's rules (design.md 4): TGF bones as they are; glTF joints by
/// `options`, existing weights, and where the shape's inside is.
/// @throws InputError where no joint deforms.
void make_handles(Character& character, const JointOptions& options = {});

}  // namespace skinfield
