// One primitive's arrays: vertices, triangles of any mode, and weights from all their sets.
#include "io/gltf_document.h"

#include <algorithm>
#include <cmath>

namespace skinfield::gltf {
namespace {

enum Mode { kTriangles = 4, kStrip = 5, kFan = 6 };

Points to_points(const AccessorValues& values) {
  return Eigen::Map<const Points>(values.values.data(), static_cast<Eigen::Index>(values.count), 3);
}

void read_faces(const GltfDocument& document, const Json& primitive, PrimitiveData& out,
                const std::string& who) {
  const std::int64_t mode = document.integer(primitive, "mode", kTriangles, who);
  if (mode > kFan) document.fail(who + ": unknown mode " + std::to_string(mode), "export it again");
  if (mode < kTriangles) return;  // points and lines have vertices to weight, but no faces
  const int accessor = document.index(primitive, "indices", "accessors", who);
  std::vector<std::int32_t> corner;
  if (accessor >= 0) {
    const AccessorValues indices = read_accessor(document, accessor, {"SCALAR"}, who + ": indices");
    corner.reserve(indices.count);
    for (const double value : indices.values) {
      if (!(value >= 0 && value < static_cast<double>(out.V.rows()))) {
        document.fail(who + ": index " + std::to_string(static_cast<std::int64_t>(value)) +
                          " is out of range of its " + std::to_string(out.V.rows()) + " vertices",
                      "export it again");
      }
      corner.push_back(static_cast<std::int32_t>(value));
    }
  } else {
    corner.resize(static_cast<std::size_t>(out.V.rows()));
    for (std::size_t i = 0; i < corner.size(); ++i) corner[i] = static_cast<std::int32_t>(i);
  }
  const std::size_t n = corner.size();
  const std::size_t faces = mode == kTriangles ? n / 3 : (n < 3 ? 0 : n - 2);
  out.F.resize(static_cast<Eigen::Index>(faces), 3);
  for (std::size_t f = 0; f < faces; ++f) {
    const auto row = static_cast<Eigen::Index>(f);
    if (mode == kTriangles) {
      out.F.row(row) << corner[3 * f], corner[3 * f + 1], corner[3 * f + 2];
    } else if (mode == kStrip) {  // every other triangle of a strip is turned (glTF 2.0, 3.7.2.1)
      out.F.row(row) << corner[f], corner[f + 1 + f % 2], corner[f + 2 - f % 2];
    } else {
      out.F.row(row) << corner[f + 1], corner[f + 2], corner[0];
    }
  }
}

/// The accessors of JOINTS_n and WEIGHTS_n for n = 0, 1, … as far as both are there.
std::vector<std::pair<int, int>> weight_sets(const GltfDocument& document, const Json& attributes,
                                             const std::string& who) {
  std::vector<std::pair<int, int>> sets;
  for (int n = 0;; ++n) {
    const std::string joints = "JOINTS_" + std::to_string(n);
    const std::string weights = "WEIGHTS_" + std::to_string(n);
    if (!attributes.contains(joints) || !attributes.contains(weights)) return sets;
    sets.emplace_back(document.index(attributes, joints.c_str(), "accessors", who),
                      document.index(attributes, weights.c_str(), "accessors", who));
  }
}

/// Reads one vertex's influences into `row`; says whether the file had something wrong there.
void add_set(const GltfDocument& document, const AccessorValues& joints,
             const AccessorValues& weights, std::size_t vertex, int slots,
             std::vector<std::pair<int, double>>& row, bool& finite, bool& negative,
             const std::string& who) {
  for (int c = 0; c < weights.components; ++c) {
    const double weight = weights(vertex, c), slot = joints(vertex, c);
    if (!std::isfinite(weight)) finite = false;
    if (weight < 0) negative = true;
    if (!std::isfinite(weight) || weight <= 0) continue;
    if (!(slot >= 0 && slot < slots)) {
      document.fail(who + ": vertex " + std::to_string(vertex) + " names joint " +
                        std::to_string(slot >= 0 ? static_cast<std::int64_t>(slot) : -1) +
                        " of the skin's " + std::to_string(slots),
                    "export it again");
    }
    row.emplace_back(static_cast<int>(slot), weight);
  }
}

void read_weights(const GltfDocument& document, const Json& attributes, int slots,
                  PrimitiveData& out, const std::string& who) {
  const auto sets = weight_sets(document, attributes, who);
  if (sets.empty() || slots == 0) return;
  out.weighted = true;
  const auto n = static_cast<std::size_t>(out.V.rows());
  std::vector<std::pair<AccessorValues, AccessorValues>> data;
  for (const auto& [joints, weights] : sets) {
    data.emplace_back(read_accessor(document, joints, {"VEC4"}, who + ": JOINTS"),
                      read_accessor(document, weights, {"VEC4"}, who + ": WEIGHTS"));
    if (data.back().first.count < n || data.back().second.count < n) {
      document.fail(who + ": fewer joints or weights than vertices", "export it again");
    }
  }
  std::vector<std::pair<int, double>> row;
  for (std::size_t v = 0; v < n; ++v) {
    row.clear();
    bool finite = true, negative = false;
    for (const auto& [joints, weights] : data) {
      add_set(document, joints, weights, v, slots, row, finite, negative, who);
    }
    out.negative_rows += negative;
    if (!finite) {
      ++out.non_finite_rows;
      continue;
    }
    double sum = 0;
    for (const auto& [slot, weight] : row) sum += weight;
    for (const auto& [slot, weight] : row) {
      out.weights.emplace_back(static_cast<int>(v), slot, weight / sum);
    }
  }
}

}  // namespace

PrimitiveData read_primitive(const GltfDocument& document, const Json& primitive, int slots,
                             const std::string& who) {
  PrimitiveData out;
  const auto attributes = primitive.find("attributes");
  if (attributes == primitive.end() || !attributes->is_object()) {
    document.fail(who + " has no attributes", "export it again");
  }
  const int position = document.index(*attributes, "POSITION", "accessors", who);
  if (position < 0) return out;
  const auto extensions = primitive.find("extensions");
  const Json& accessor = document.item("accessors", position, who);
  if (extensions != primitive.end() && extensions->is_object() &&
      extensions->contains("KHR_draco_mesh_compression") && !accessor.contains("bufferView")) {
    document.fail(who + " is compressed with KHR_draco_mesh_compression, which is not read",
                  "decompress it first: npx @gltf-transform/cli copy IN.glb OUT.glb");
  }
  out.V = to_points(read_accessor(document, position, {"VEC3"}, who + ": POSITION"));
  for (Eigen::Index v = 0; v < out.V.rows(); ++v) {
    if (!out.V.row(v).allFinite()) {
      document.fail(who + ": vertex " + std::to_string(v) + " has a position that is not finite",
                    "repair it in the program that made it and export it again");
    }
  }
  const int normal = document.index(*attributes, "NORMAL", "accessors", who);
  if (normal >= 0) {
    const AccessorValues values = read_accessor(document, normal, {"VEC3"}, who + ": NORMAL");
    if (static_cast<Eigen::Index>(values.count) < out.V.rows()) {
      document.fail(who + ": fewer normals than vertices", "export it again");
    }
    out.N = to_points(values).topRows(out.V.rows());
  }
  read_faces(document, primitive, out, who);
  read_weights(document, *attributes, slots, out, who);
  return out;
}

}  // namespace skinfield::gltf
