// From joints to handles: which joints deform, and which bones they own (design.md section 4).
#pragma once

#include "skinfield/rig/handle_geometry.h"
#include "skinfield/rig/skeleton.h"

#include <string>
#include <vector>

namespace skinfield {

/// TGF: every vertex on no edge is a point handle, every bone line one handle, exactly that
/// segment (a line of zero length: a point). Columns: points in file order, then bone lines in
/// file order. Replaces the skeleton's handles, columns and the joints' parents (`bone_tree`).
/// Throws InputError where there is no joint, a bone names a joint that does not exist, or a
/// position is not finite.
void make_tgf_handles(Skeleton& skeleton);

struct JointOptions {
  /// automatic: the joints that existing weights use; with no weights, all but roots outside the
  /// shape and joints whose names say that they only steer (`is_helper_name`).
  enum class Which { automatic, all, used, match };
  /// What a deforming joint without deforming descendants owns. extend: the segment to its tip
  /// (a child that does not deform and whose name says so), else the continuation of the bone
  /// from the next deforming joint above by half its length. point: its position.
  enum class Leaf { extend, point };

  Which which = Which::automatic;
  std::vector<std::string> patterns = {};  ///< globs, for Which::match
  std::vector<std::string> exclude = {};   ///< globs: these joints never deform
  Leaf leaf = Leaf::extend;
};

/// glTF: one column a joint, in order; handles for the deforming joints only, in order. Joints
/// without a deforming parent's bone or tip, and those whose bones all have zero length, are
/// points. A joint between two deforming ones that does not itself deform is stepped over, so
/// that a helper in the chain neither ends a bone nor lends its direction to a leaf.
/// used: (joints) which joints existing weights use, or empty; all false counts as no weights.
/// inside: of the shape, in bind space, or empty if there is no shape: cuts continued leaves where
/// they leave it and rules on roots. Replaces handles, columns and left_out.
/// Throws InputError where no joint is left, `used` is asked for without weights, a parent index
/// is wrong, or a position is not finite.
void make_joint_handles(Skeleton& skeleton, const JointOptions& options = {},
                        const std::vector<bool>& used = {}, const InsideTest& inside = {});

/// Names of joints that steer and do not deform: the words IK, pole, control (ctrl), target, slot,
/// socket, nub, and names that end with `_end`.
bool is_helper_name(const std::string& name);
/// Names of nodes that mark where a bone ends: the words end, tip, nub.
bool is_tip_name(const std::string& name);

}  // namespace skinfield
