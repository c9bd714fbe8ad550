#include "skinfield/bind/report.h"

#include <nlohmann/json.hpp>

#include <sys/resource.h>
#include <cmath>
#include <ctime>

namespace skinfield {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity; a value that is none becomes null.
Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

const char* name_of(SolveStats::Status status) {
  switch (status) {
    case SolveStats::Status::converged:
      return "converged";
    case SolveStats::Status::limit:
      return "limit";
    case SolveStats::Status::cancelled:
      return "cancelled";
  }
  return "";
}

Json input_json(const BindReport& r) {
  const Diagnosis& d = r.input;
  return {{"vertices", d.vertices},
          {"faces", d.faces},
          {"tets", d.tets},
          {"merged_vertices", d.merged_vertices},
          {"components", d.components},
          {"boundary_edges", d.boundary_edges},
          {"nonmanifold_edges", d.nonmanifold_edges},
          {"inconsistent_edges", d.inconsistent_edges},
          {"self_intersections_sampled", d.intersecting_pairs_sampled},
          {"self_intersection_faces_tested", d.intersection_faces_tested},
          {"degenerate_faces", d.degenerate_faces},
          {"duplicate_faces", d.duplicate_faces},
          {"watertight", d.watertight},
          {"planar", d.planar},
          {"box_diagonal", number(diagonal(d.box))},
          {"unit_scale", number(r.unit_scale)},
          {"handles", r.handles},
          {"handles_inside", r.handles_inside},
          {"handles_partly_inside", r.handles_partly_inside},
          {"handles_outside", r.handles_outside},
          {"joints_left_out", r.joints_left_out}};
}

Json character_json(const BindReport& r) {
  Json json;
  json["input"] = input_json(r);
  json["domain"] = {{"kind", r.domain_kind},
                    {"rung", name_of(r.rung)},
                    {"nodes", r.nodes},
                    {"handle_nodes", r.handle_nodes},
                    {"neighbours", r.neighbours},
                    {"components", r.node_components},
                    {"components_without_handle", r.node_components_without_handle},
                    {"elements", r.elements},
                    {"route", r.tet_route.empty() ? Json(nullptr) : Json(r.tet_route)},
                    {"split_nodes", r.split_nodes},
                    {"rays", r.rays},
                    {"clean_parts", r.clean_parts},
                    {"dirty_parts", r.dirty_parts},
                    {"passenger_parts", r.passenger_parts},
                    {"flipped_faces", r.flipped_faces}};
  json["solve"] = {{"status", name_of(r.solve.status)},
                   {"iterations", r.solve.iterations},
                   {"energy", number(r.solve.energy)},
                   {"lower_bound", number(r.solve.lower_bound)},
                   {"relative_gap", number(r.solve.relative_gap)},
                   {"kkt_residual", number(r.solve.kkt_residual)},
                   {"largest_change", number(r.solve.largest_change)},
                   {"biharmonic_energy", number(r.biharmonic_energy)}};
  if (r.solve.factor_entries > 0) json["solve"]["factor_entries"] = r.solve.factor_entries;
  if (!r.history.empty()) {
    Json& history = json["solve"]["history"];
    history = {{"columns", {"iteration", "energy", "lower_bound", "constraint_violation"}},
               {"rows", Json::array()}};
    for (const BindReport::Step& s : r.history)
      history["rows"].push_back(
          {s.iteration, number(s.energy), number(s.lower_bound), number(s.constraint_violation)});
  }
  if (!r.judged.empty()) {
    Json& judged = json["solve"]["judged"];
    judged = {{"energy", number(r.judged.back().energy)},
              {"columns", {"iteration", "points", "energy"}},
              {"rows", Json::array()}};
    for (const BindReport::Judged& j : r.judged)
      judged["rows"].push_back({j.iteration, j.points, number(j.energy)});
  }
  Json histogram = Json::object();
  for (std::size_t k = 0; k < r.influences.size(); ++k)
    if (r.influences[k] > 0) histogram[std::to_string(k)] = r.influences[k];
  json["weights"] = {{"rows", r.rows},
                     {"row_sum_error", number(r.row_sum_error)},
                     {"negative", r.negative},
                     {"non_finite", r.non_finite},
                     {"influences", histogram},
                     {"pruned_mass_mean", number(r.pruned_mass_mean)},
                     {"pruned_mass_max", number(r.pruned_mass_max)},
                     {"clamped_mass_mean", number(r.clamped_mass_mean)},
                     {"clamped_mass_max", number(r.clamped_mass_max)},
                     {"handles_without_vertices", r.handles_without_vertices},
                     {"vertices_filled", Json(r.vertices_filled)},
                     {"extrema", r.extrema}};
  if (r.extrema_before_projection >= 0)
    json["weights"]["extrema_before_projection"] = r.extrema_before_projection;
  if (!r.field_vertices.empty()) json["weights"]["field_vertices"] = Json(r.field_vertices);
  json["timings_s"] = Json(r.seconds);
  json["cpu_s"] = Json(r.cpu_seconds);
  json["warnings"] = r.warnings;
  return json;
}

}  // namespace

std::string report_json(const std::vector<BindReport>& characters, const ReportContext& context) {
  Json json;
  json["schema"] = 1;
  json["file"] = context.input_path;
  json["output"] = context.output_path;
  json["method"] = facts_of(context.method).name;
  json["options"] = Json(context.options);
  json["seed"] = context.seed;
  json["threads"] = context.threads;
  json["profile"] = context.profile;
  // One character, the usual case, stands at the top level; several in a list.
  if (characters.size() == 1) {
    json.update(character_json(characters.front()));
  } else {
    json["characters"] = Json::array();
    for (const BindReport& r : characters) json["characters"].push_back(character_json(r));
  }
  json["total_s"] = number(context.total_s);
  json["total_cpu_s"] = number(context.total_cpu_s);
  json["peak_memory_bytes"] = context.peak_memory_bytes;
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::int64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

double process_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace skinfield
