// The pieces of the glTF writer. Private to io.
#pragma once

#include "io/gltf_document.h"
#include "skinfield/io/gltf.h"

#include <functional>
#include <map>
#include <set>

namespace skinfield::gltf {

/// JOINTS_n and WEIGHTS_n of some vertices, as bytes, set by set.
struct PackedWeights {
  std::size_t count = 0;
  int joint_type = 0, weight_type = 0;  ///< glTF component types
  std::vector<std::string> joints, weights;
};
/// Influences of rows [begin,end) of W, descending, in at least `sets` sets of four. Integers with
/// the exact sum are spread over a row by largest remainders; float32 weights are such integers
/// too, of 2^-24, so that any order of summation gives exactly one.
PackedWeights pack_weights(const SparseRows& W, int begin, int end,
                           const std::vector<int>& slot_of_column, GltfWeightFormat format,
                           int sets);

/// A document being extended: new bytes go to the end of its first buffer with data.
class Extension {
 public:
  Extension(Json json, std::vector<std::optional<std::string>> buffers);

  Json json;
  std::vector<std::optional<std::string>> buffers;

  /// Marks an accessor as replaced for good, so that its place may be taken once.
  void release(const std::set<int>& accessors);
  /// The accessor of these bytes: in the released place `old` (or -1), an equal one, or a new one.
  /// `target`: 34962 for vertex attributes, 34963 for indices, 0 for others.
  int put(const std::string& bytes, Json accessor, int target, int old = -1);
  int append_node(Json node);

 private:
  int place_view(const std::string& bytes, int target, int old_view);
  std::size_t append_bytes(int buffer, const std::string& bytes);

  int buffer_ = -1;
  std::set<int> free_accessors_, free_views_;
  std::map<std::string, int> known_;
};

/// Puts packed weights into a primitive: replaces its JOINTS_n and WEIGHTS_n.
void set_weights(Extension& out, Json& primitive, const PackedWeights& packed);
/// Sets of weights a primitive has: JOINTS_n with WEIGHTS_n for n = 0, 1, ….
int count_weight_sets(const Json& primitive);

/// Nodes to be made for a skeleton that the document does not have.
struct NewJoint {
  std::string name;
  int parent = -1;                         ///< earlier or later in the list
  Transform bind = Transform::Identity();  ///< a rotation and a translation
};
struct JointTree {
  std::vector<NewJoint> joints;
  std::vector<int> joint_of_column;
};
/// glTF joints keep their tree; TGF bones become one joint each at their head, extra joints at leaf
/// ends, points one joint each; handles without joints one joint each at their middle.
JointTree make_joint_tree(const Skeleton& skeleton, int columns);

/// Appends the nodes of a tree under a new root; gives the node of each of its joints. `root` is
/// to be put into a scene.
struct PlacedTree {
  JointTree tree;
  int root = -1;
  std::vector<int> nodes;
};
PlacedTree place_tree(Extension& out, JointTree tree);
/// Appends a skin for vertices that `to_character` takes to the tree's space.
int append_skin(Extension& out, const PlacedTree& placed, const Transform& to_character,
                const std::string& name);

/// A document for a source that has none. colours: (n_input,3) a character instead of the parts'
/// materials, or none.
Extension fresh_document(const Asset& source, std::span<const SkinWeights> weights,
                         const GltfWriteOptions& options, std::span<const Points> colours = {});
/// The source's document with new weights.
Extension patched_document(const Asset& source, const GltfDocument& document,
                           std::span<const SkinWeights> weights, const GltfWriteOptions& options);

}  // namespace skinfield::gltf
