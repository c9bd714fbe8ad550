// What kind of shape is this? Never changes it.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"

#include <cstdint>

namespace skinfield {

struct Diagnosis {
  std::int64_t vertices = 0, faces = 0, tets = 0;
  std::int64_t merged_vertices = 0;  ///< after merging equal positions
  std::int64_t unreferenced_vertices = 0;
  std::int64_t components = 0;          ///< over merged vertices
  std::int64_t boundary_edges = 0;      ///< edges with one face
  std::int64_t nonmanifold_edges = 0;   ///< edges with three or more faces
  std::int64_t inconsistent_edges = 0;  ///< two faces that disagree in orientation
  std::int64_t degenerate_faces = 0;    ///< repeated index or zero area
  std::int64_t duplicate_faces = 0;     ///< same three vertices, either orientation
  std::int64_t non_finite_vertices = 0;
  std::int64_t intersecting_pairs_sampled = 0;  ///< of at most `intersection_samples` faces
  std::int64_t intersection_faces_tested = 0;
  bool watertight = false;
  bool planar = false;  ///< all vertices in one plane (1e-6 of the diagonal)
  bool self_intersecting = false;
  Box3 box = Box3::Zero();
  double area = 0, volume = 0;  ///< volume: signed, meaningful if watertight
};

struct DiagnosisOptions {
  int intersection_samples = 20000;  ///< faces tested for intersections; all if fewer
  std::uint64_t seed = 0;
};

Diagnosis diagnose(const Mesh& mesh, const DiagnosisOptions& options = {},
                   const Progress& progress = {});

}  // namespace skinfield
