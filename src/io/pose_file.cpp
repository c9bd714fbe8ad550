#include "skinfield/io/pose_file.h"

#include "io/text.h"
#include "skinfield/io/file.h"
#include "skinfield/io/matrix_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace skinfield {
namespace {

using Json = nlohmann::ordered_json;

Eigen::Quaterniond checked(const Eigen::Vector4d& xyzw, const std::string& where) {
  const double norm = xyzw.norm();
  if (!std::isfinite(norm) || norm < 1e-12) {
    throw InputError("a rotation is no quaternion", where, "give x, y, z, w of length 1");
  }
  Eigen::Quaterniond q;
  q.coeffs() = xyzw / norm;
  return q;
}

template <int kSize>
Eigen::Matrix<double, kSize, 1> numbers(const Json& list, const std::string& where) {
  Eigen::Matrix<double, kSize, 1> out;
  if (!list.is_array() || list.size() != kSize) {
    throw InputError("needs a list of " + std::to_string(kSize) + " numbers", where,
                     "rotation is [x, y, z, w], translation [x, y, z]");
  }
  for (std::size_t i = 0; i < kSize; ++i) {
    if (!list[i].is_number()) {
      throw InputError("holds something that is not a number", where, "give numbers only");
    }
    out[static_cast<Eigen::Index>(i)] = list[i].get<double>();
  }
  if (!out.allFinite()) throw InputError("holds an infinite number", where, "give finite ones");
  return out;
}

std::vector<PoseEntry> parse_frame(const Json& object, const std::string& name) {
  if (!object.is_object()) {
    throw InputError("a frame is no object", name, "give {\"joint\": {\"rotation\": [...]}}");
  }
  std::vector<PoseEntry> frame;
  for (const auto& [key, value] : object.items()) {
    const std::string where = name + ": " + text::quoted(key);
    PoseEntry entry;
    const bool digits = !key.empty() && key.find_first_not_of("0123456789") == std::string::npos;
    const auto index = digits ? text::to_integer(key) : std::nullopt;
    if (index && *index <= INT32_MAX) {
      entry.index = static_cast<int>(*index);
    } else {
      entry.name = key;
    }
    if (!value.is_object()) {
      throw InputError("is no object", where, "give rotation and translation");
    }
    for (const auto& [member, list] : value.items()) {
      if (member == "rotation") {
        entry.rotation = checked(numbers<4>(list, where), where);
      } else if (member == "translation") {
        entry.translation = numbers<3>(list, where);
      } else {
        throw InputError("unknown member " + text::quoted(member), where,
                         "members are rotation and translation");
      }
    }
    frame.push_back(std::move(entry));
  }
  return frame;
}

/// The weight column that an entry moves.
std::size_t column_of(const PoseEntry& entry, const Skeleton& skeleton) {
  const auto columns = static_cast<std::size_t>(skeleton.columns);
  if (entry.name.empty()) {
    if (entry.index >= 0 && entry.index < skeleton.columns) {
      return static_cast<std::size_t>(entry.index);
    }
    throw InputError(
        "the pose moves handle " + std::to_string(entry.index) + " of " + std::to_string(columns),
        {}, "handles count from 0");
  }
  for (std::size_t j = 0; j < std::min(columns, skeleton.column_names.size()); ++j) {
    if (skeleton.column_names[j] == entry.name) return j;
  }
  for (std::size_t h = 0; h < std::min(skeleton.handles.size(), skeleton.column.size()); ++h) {
    if (skeleton.handles[h].name == entry.name) {
      return static_cast<std::size_t>(skeleton.column[h]);
    }
  }
  throw InputError("the pose moves " + text::quoted(entry.name) + ", which is not in the skeleton",
                   {}, "name a joint of this skeleton");
}

/// Quaternions of length 1, as far as the digits of a file tell.
bool rows_are_unit(const RowMatrix& Q) {
  return ((Q.rowwise().norm().array() - 1).abs() < 1e-3).all();
}

}  // namespace

PoseFile parse_pose_json(std::string_view bytes, const std::string& name) {
  const auto too_deep = [](int depth, Json::parse_event_t, Json&) {
    if (depth > 8) throw InputError("is nested too deeply", {}, "give frames of joints");
    return true;
  };
  Json document;
  try {
    document = Json::parse(bytes.begin(), bytes.end(), too_deep);
  } catch (const InputError& error) {
    throw InputError(error.message(), name, error.remedy());
  } catch (const Json::parse_error& error) {
    throw InputError("is no valid JSON near byte " + std::to_string(error.byte), name,
                     "correct the file");
  } catch (const Json::exception&) {
    throw InputError("holds a number that is out of range", name, "correct the file");
  }
  const Json* frames = &document;
  if (document.is_object() && document.size() == 1 && document.contains("frames")) {
    frames = &document["frames"];
  }
  PoseFile pose;
  if (frames->is_array()) {
    for (const Json& frame : *frames) pose.frames.push_back(parse_frame(frame, name));
  } else {
    pose.frames.push_back(parse_frame(*frames, name));
  }
  if (pose.frames.empty()) throw InputError("has no frames", name, "give at least one");
  return pose;
}

PoseFile parse_pose_dmat(std::string_view bytes, const std::string& name) {
  RowMatrix Q = parse_dmat(bytes, name);
  const bool one_a_row = Q.cols() == 4 && (Q.rows() % 4 != 0 || rows_are_unit(Q));
  if (one_a_row) Q = RowMatrix(Q.reshaped<Eigen::RowMajor>());
  if (Q.rows() == 0 || Q.cols() == 0 || Q.rows() % 4 != 0) {
    throw InputError("is no list of quaternions", name, "give x y z w a handle, a column a frame");
  }
  PoseFile pose;
  pose.quaternions = true;
  for (Eigen::Index f = 0; f < Q.cols(); ++f) {
    std::vector<PoseEntry>& frame = pose.frames.emplace_back();
    for (Eigen::Index i = 0; i < Q.rows(); i += 4) {
      PoseEntry entry;
      entry.index = static_cast<int>(i / 4);
      entry.rotation = checked(Q.block<4, 1>(i, f), name);
      frame.push_back(std::move(entry));
    }
  }
  return pose;
}

Pose pose_for(const PoseFile& file, std::size_t frame, const Skeleton& skeleton) {
  if (frame >= file.frames.size()) {
    throw InputError("has no frame " + std::to_string(frame), {},
                     "frames count from 0 to " + std::to_string(file.frames.size() - 1));
  }
  const std::vector<PoseEntry>& entries = file.frames[frame];
  if (file.quaternions) {
    std::vector<double> xyzw;
    for (const PoseEntry& entry : entries) {
      for (const double c : entry.rotation.coeffs()) xyzw.push_back(c);
    }
    return pose_from_quaternions(skeleton, xyzw);
  }
  Pose pose = rest_pose(skeleton);
  for (const PoseEntry& entry : entries) {
    JointPose& joint = pose.joints.at(column_of(entry, skeleton));
    joint.rotation = entry.rotation;
    joint.translation = entry.translation;
  }
  return pose;
}

PoseFile read_pose(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path), name = path.string();
  if (extension == ".json") return parse_pose_json(read_file(path), name);
  if (extension == ".dmat") return parse_pose_dmat(read_file(path), name);
  throw InputError("unknown pose format", name, "poses are read from .json and .dmat");
}

}  // namespace skinfield
