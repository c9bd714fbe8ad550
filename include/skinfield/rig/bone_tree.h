// The tree of a TGF's bones: which end of a bone is its head, and on which bone it hangs.
#pragma once

#include "skinfield/rig/skeleton.h"

namespace skinfield {

struct BoneTree {
  std::vector<int> head, tail;  ///< joint indices of every bone, in file order
  std::vector<int> parent;      ///< the bone that ends at this one's head, or -1
  std::vector<int> order;       ///< bones, parents first
};

/// The file's own orientation where that is a forest (no joint at the end of two bones, no
/// cycle): libigl's convention. Else edges are oriented away from the first joint of each
/// connected component, breadth first in file order, and a bone that closes a cycle hangs on the
/// bone at whichever end was reached first.
/// Throws InputError for a bone that names a joint that does not exist.
BoneTree bone_tree(const Skeleton& skeleton);

/// The column of a TGF's first bone: its points come before, regions behind the bones.
int first_bone_column(const Skeleton& skeleton);

}  // namespace skinfield
