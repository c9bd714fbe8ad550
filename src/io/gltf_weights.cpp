// Weights as glTF stores them: four a set, descending, their sum exact.
#include "io/bytes.h"
#include "io/gltf_writing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace skinfield::gltf {
namespace {

constexpr int kUnsignedByte = 5121, kUnsignedShort = 5123, kFloat = 5126;

struct Influence {
  int slot = 0;
  double weight = 0;
  std::int64_t units = 0;
};

/// Non-negative integers that sum to `total` and are closest to the weights (largest remainders).
void quantise(std::vector<Influence>& row, std::int64_t total) {
  double sum = 0;
  for (const Influence& influence : row) sum += influence.weight;
  std::int64_t given = 0;
  std::vector<std::pair<double, std::size_t>> remainders;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double exact = row[i].weight / sum * static_cast<double>(total);
    row[i].units = static_cast<std::int64_t>(std::floor(exact));
    given += row[i].units;
    remainders.emplace_back(exact - std::floor(exact), i);
  }
  std::stable_sort(remainders.begin(), remainders.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  // Rounding of the quotients can leave the rest outside [0, size) by one unit at most.
  for (std::size_t k = 0; given < total; k = (k + 1) % remainders.size(), ++given) {
    ++row[remainders[k].second].units;
  }
  if (given > total) row.front().units -= given - total;
}

std::int64_t units_in_one(GltfWeightFormat format) {
  switch (format) {
    case GltfWeightFormat::unorm16:
      return 65535;
    case GltfWeightFormat::unorm8:
      return 255;
    case GltfWeightFormat::float32:
      break;
  }
  return 1 << 24;
}

void put_weight(std::string& out, std::int64_t units, GltfWeightFormat format) {
  if (format == GltfWeightFormat::unorm16) {
    put_little(out, static_cast<std::uint16_t>(units));
  } else if (format == GltfWeightFormat::unorm8) {
    put_little(out, static_cast<std::uint8_t>(units));
  } else {
    put_little(out, std::ldexp(static_cast<float>(units), -24));
  }
}

/// Number after "JOINTS_" or "WEIGHTS_", or -1.
int weight_set(const std::string& attribute) {
  for (const std::string_view prefix : {"JOINTS_", "WEIGHTS_"}) {
    if (!attribute.starts_with(prefix)) continue;
    const std::string digits = attribute.substr(prefix.size());
    if (!digits.empty() && digits.size() < 4 &&
        digits.find_first_not_of("0123456789") == std::string::npos) {
      return std::atoi(digits.c_str());
    }
  }
  return -1;
}

}  // namespace

PackedWeights pack_weights(const SparseRows& W, int begin, int end,
                           const std::vector<int>& slot_of_column, GltfWeightFormat format,
                           int sets) {
  PackedWeights out;
  out.count = static_cast<std::size_t>(end - begin);
  const std::int64_t total = units_in_one(format);
  std::vector<std::vector<Influence>> rows(out.count);
  int largest_slot = 0;
  for (int v = begin; v < end; ++v) {
    std::vector<Influence>& row = rows[static_cast<std::size_t>(v - begin)];
    for (SparseRows::InnerIterator it(W, v); it; ++it) {
      if (!std::isfinite(it.value()) || it.value() < 0) {
        throw InputError("weight of vertex " + std::to_string(v) + " is negative or not finite");
      }
      if (it.value() > 0) {
        row.push_back({slot_of_column[static_cast<std::size_t>(it.col())], it.value(), 0});
      }
    }
    if (row.empty()) row.push_back({0, 1, 0});
    std::stable_sort(row.begin(), row.end(), [](const Influence& a, const Influence& b) {
      return a.weight > b.weight || (a.weight == b.weight && a.slot < b.slot);
    });
    quantise(row, total);
    while (row.back().units == 0) row.pop_back();
    sets = std::max(sets, static_cast<int>((row.size() + 3) / 4));
    for (const Influence& influence : row) largest_slot = std::max(largest_slot, influence.slot);
  }
  if (largest_slot > 65535) throw InputError("more than 65536 joints do not fit into glTF");
  sets = std::max(sets, 1);
  out.joint_type = largest_slot > 255 ? kUnsignedShort : kUnsignedByte;
  out.weight_type = format == GltfWeightFormat::unorm16  ? kUnsignedShort
                    : format == GltfWeightFormat::unorm8 ? kUnsignedByte
                                                         : kFloat;
  out.joints.resize(static_cast<std::size_t>(sets));
  out.weights.resize(static_cast<std::size_t>(sets));
  for (const std::vector<Influence>& row : rows) {
    for (std::size_t k = 0; k < 4 * static_cast<std::size_t>(sets); ++k) {
      const Influence influence = k < row.size() ? row[k] : Influence{};
      if (largest_slot > 255) {
        put_little(out.joints[k / 4], static_cast<std::uint16_t>(influence.slot));
      } else {
        put_little(out.joints[k / 4], static_cast<std::uint8_t>(influence.slot));
      }
      put_weight(out.weights[k / 4], influence.units, format);
    }
  }
  return out;
}

int count_weight_sets(const Json& primitive) {
  const Json& attributes = primitive.at("attributes");
  int sets = 0;
  while (attributes.contains("JOINTS_" + std::to_string(sets)) &&
         attributes.contains("WEIGHTS_" + std::to_string(sets))) {
    ++sets;
  }
  return sets;
}

void set_weights(Extension& out, Json& primitive, const PackedWeights& packed) {
  Json& attributes = primitive.at("attributes");
  const auto put = [&](const std::string& name, const std::string& bytes, int component_type,
                       bool normalised) {
    Json accessor = {{"componentType", component_type}};
    if (normalised) accessor["normalized"] = true;
    accessor["count"] = packed.count;
    accessor["type"] = "VEC4";
    const auto old = attributes.find(name);
    attributes[name] =
        out.put(bytes, std::move(accessor), 34962, old == attributes.end() ? -1 : old->get<int>());
  };
  for (std::size_t s = 0; s < packed.joints.size(); ++s) {
    put("JOINTS_" + std::to_string(s), packed.joints[s], packed.joint_type, false);
    put("WEIGHTS_" + std::to_string(s), packed.weights[s], packed.weight_type,
        packed.weight_type != kFloat);
  }
  std::vector<std::string> stale;
  for (const auto& [name, value] : attributes.items()) {
    if (weight_set(name) >= static_cast<int>(packed.joints.size())) stale.push_back(name);
  }
  for (const std::string& name : stale) attributes.erase(name);
  // A compressed copy of the primitive would bring the old weights back.
  const auto extensions = primitive.find("extensions");
  if (extensions != primitive.end() && extensions->is_object()) {
    extensions->erase("KHR_draco_mesh_compression");
    if (extensions->empty()) primitive.erase("extensions");
  }
}

}  // namespace skinfield::gltf
