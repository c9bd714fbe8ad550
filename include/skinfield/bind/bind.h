// The one story: a character in, valid skinning weights and an honest report out.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/bind/method.h"
#include "skinfield/domain/domain.h"
#include "skinfield/geometry/diagnosis.h"
#include "skinfield/io/asset.h"
#include "skinfield/io/sfield.h"
#include "skinfield/operators/mass.h"
#include "skinfield/weights/skin_weights.h"

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skinfield {

/// Which domain gave the weights: the ladder of design.md 3, best first.
enum class Rung { volume, surface, nearest_visible_handle, nearest_handle };
std::string name_of(Rung rung);

/// Prescribed rows (Dirichlet) on input vertices; columns are the handles' columns.
struct Paint {
  std::vector<int> vertex;  ///< input vertices, 0-based
  RowMatrix weights;        ///< (k, columns), rows on the simplex
};

/// What geometric fields assume at the surface: nothing, or a vanishing normal derivative.
enum class Boundary { natural, neumann };

/// What blocks the view between two places: findings.md E's rules; every triangle, as in the
/// geometric-fields paper; nothing.
enum class FieldVisibility { counted, any_hit, none };

/// Geometric fields' own parameters, for comparisons (GeometricFieldsOptions). What is absent or 0
/// is the method's own choice.
struct FieldTuning {
  std::optional<FieldVisibility> visibility;
  double kernel_width = 0;     ///< factor on sigma
  double difference_step = 0;  ///< h in units of sigma
  double rows_per_point = 0;   ///< of the convex solver
  int samples_per_step = 0;    ///< M of the Adams
  int levels = 0;
  double judged_step = 0;  ///< not 0: report the energy by axis-aligned differences; unit box
};

struct BindOptions {
  Method method = Method::bounded_biharmonic;
  Solver solver = Solver::automatic;
  enum class DomainKind { automatic, points, surface, tets };
  DomainKind domain = DomainKind::automatic;
  int nodes = 16000;
  /// How masses are lumped, on domains that are meshes: a point domain's nodes have their own.
  MassKind mass = MassKind::barycentric;
  /// Instead of `mass`: over input vertices, > 0, in file units. For methods and domains whose
  /// nodes are the mesh's vertices.
  std::optional<Vector> masses;
  double tolerance = 0;       ///< when the solve stops: see SolverFacts; 0: the solver's own
  int iterations = 0;         ///< at most; 0: the solver's own
  bool keep_history = false;  ///< of solvers that tell (dual, quasi-harmonic), into the report
  double time_limit_s = 0;    ///< of the solve; 0 = none
  std::uint64_t seed = 0;
  int max_influences = 0;  ///< 0 = all
  double prune = 0;        ///< weights below this share of their row go
  bool resolve = true;     ///< solve again on the kept support when influences are cut
  enum class Symmetry { off, x, automatic };
  Symmetry symmetry = Symmetry::off;
  int field_points = 0;              ///< of geometric fields, at the finest level; 0: their own
  std::optional<Boundary> boundary;  ///< of geometric fields [natural, or as resumed]
  FieldTuning field;                 ///< of geometric fields
  std::shared_ptr<const FieldFile> resume;  ///< a saved geometric field to go on from
  bool keep_field = false;                  ///< give the field's state back, to be saved
  bool keep_tensors = false;                ///< give the elements' tensors back
  std::optional<Paint> paint;
  std::optional<SkinWeights> start;  ///< over input vertices, all columns
  std::vector<int> locked_columns;   ///< kept from `start`
};

/// Options that do not go together, or not with this character (exit code 2).
class OptionError : public InputError {
 public:
  using InputError::InputError;
};

struct SolvedDomain;

struct BindReport {
  Diagnosis input;
  double unit_scale = 1;  ///< factor from file lengths to the unit box
  int handles = 0;
  std::vector<std::string> handles_inside, handles_partly_inside, handles_outside, joints_left_out;
  Rung rung = Rung::volume;
  std::string domain_kind;
  int nodes = 0, handle_nodes = 0, node_components = 0, node_components_without_handle = 0;
  std::int64_t neighbours = 0;  ///< pairs of nodes that the energy couples directly
  std::int64_t rays = 0;
  std::string tet_route;  ///< given, split, tetgen, wrap (tetrahedraliser.h); empty without tets
  std::int64_t elements = 0;  ///< tetrahedra
  int split_nodes = 0;        ///< made in a given tet mesh for handles without a vertex
  int clean_parts = 0, dirty_parts = 0, passenger_parts = 0, flipped_faces = 0;
  SolveStats solve;  ///< the energy is the method's own, before anything is clamped
  /// 1/2 tr(W' K M^-1 K W) of the nodal weights as given out: the same measure for every method, in
  /// file units; not a number where no domain carries them.
  double biharmonic_energy = std::numeric_limits<double>::quiet_NaN();
  struct Step {
    int iteration = 0;
    double energy = 0, lower_bound = 0, constraint_violation = 0;
  };
  std::vector<Step> history;  ///< if BindOptions::keep_history
  /// If FieldTuning::judged_step: the integral of squared Laplacians, file units.
  struct Judged {
    std::int64_t iteration = 0, points = 0;
    double energy = 0;
  };
  std::vector<Judged> judged;  ///< along the solve; the last is the result's
  std::int64_t rows = 0, negative = 0, non_finite = 0;
  double row_sum_error = 0;
  std::vector<std::int64_t> influences;  ///< histogram: rows with k influences
  double pruned_mass_mean = 0, pruned_mass_max = 0;
  /// Of methods that bring their rows onto the simplex last: what was below zero in a vertex's row,
  /// and the extrema that there were before (-1 for other methods).
  double clamped_mass_mean = 0, clamped_mass_max = 0;
  std::int64_t extrema_before_projection = -1;
  std::vector<std::string> handles_without_vertices;
  std::map<std::string, std::int64_t> vertices_filled;  ///< by cause
  std::map<std::string, std::int64_t> field_vertices;   ///< of geometric fields, by evaluation
  std::int64_t extrema = 0;
  std::map<std::string, double> seconds, cpu_seconds;
  std::vector<std::string> warnings;
};

/// The metric that the weights are harmonic in, on the elements that were solved on.
struct TensorField {
  Points nodes;  ///< (N,3) in file units
  /// (e,4) or (e,3) rows of `nodes`.
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> elements;
  Points direction;  ///< (e,3) unit, of the largest eigenvalue; zero in degenerate elements
  Vector condition;  ///< (e) largest over smallest eigenvalue
};

struct BindResult {
  SkinWeights weights;  ///< (input vertices, columns)
  BindReport report;
  std::optional<FieldFile> field;              ///< if BindOptions::keep_field
  std::optional<TensorField> tensors;          ///< if BindOptions::keep_tensors
  std::shared_ptr<const SolvedDomain> solved;  ///< for transfer to other meshes
};

/// @throws InputError: no vertices, no handles and no paint, non-finite positions, sizes of paint
/// or start that do not fit. OptionError: options that do not go together. SolveError: a method
/// without bounds whose system is too ill-conditioned. Anything else ends in valid weights.
BindResult bind(const Character& character, const BindOptions& options = {},
                const Progress& progress = {});

/// A saved field, to be transferred. Of the options: max_influences and prune.
/// @throws InputError or DomainError where the file's parts do not fit together.
std::shared_ptr<const SolvedDomain> solved_field(const FieldFile& file,
                                                 const BindOptions& options = {},
                                                 const Progress& progress = {});

/// Weights of another mesh of the same character (level of detail, clothes) through the domain.
/// Positions in the character's units. `vertices_filled`: by cause; `field_vertices`: how many rows
/// of a geometric field came about how (both as in BindReport, or null).
SkinWeights transfer(const SolvedDomain& solved, const Character& target,
                     std::map<std::string, std::int64_t>* vertices_filled = nullptr,
                     std::map<std::string, std::int64_t>* field_vertices = nullptr);

}  // namespace skinfield
