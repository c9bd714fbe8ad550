// Weights as a geometric field: no mesh of the inside, conditions hard by construction, evaluation
// anywhere ("Robust Biharmonic Skinning Using Geometric Fields", ACM TOG 2025). Three optimisers
// work on the same field; docs/methods/geometric_fields.md says what follows which equation.
#pragma once

#include "skinfield/domain/domain.h"
#include "skinfield/domain/field_conditions.h"
#include "skinfield/domain/kernel_field.h"
#include "skinfield/weights/field_state.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace skinfield {

struct GeometricFieldsOptions {
  /// convex: parameters on the simplex, a convex program over fixed samples, with a certificate.
  /// adam: the paper's, fresh samples each step, softplus. adam_pool: the same, samples reused
  /// within a level.
  enum class Solver : unsigned char { convex, adam, adam_pool };
  enum class Boundary : unsigned char { natural, neumann };
  Solver solver = Solver::convex;
  Boundary boundary = Boundary::natural;
  SolidOptions::Visibility visibility = SolidOptions::Visibility::counted;
  KernelFieldOptions kernel;
  /// At the finest level; 0: 2^14 for convex, else 2^16, of flat shapes 2^13 and 2^14.
  int points = 0;
  /// Kernels beside short bones are narrower down to this share, and as much denser; 1: all alike,
  /// as in the paper. 0: a quarter for convex, 1 for adam and adam_pool.
  double narrowest = 0;
  double step = 0.5;           ///< finite-difference step h in units of sigma
  double rows_per_point = 12;  ///< convex: directional rows for each point
  int levels = 0;  ///< from coarse to fine; 0: the solver's own, 1: all steps at the finest
  double near_handles = 0.5;                      ///< share of the samples drawn near handles
  double winding_low = 0.1, winding_high = 0.25;  ///< equation 11
  int samples_per_step = 0;  ///< adam, adam_pool: M; 0: 2^11, of flat shapes 2^12
  double tolerance = 1e-2;   ///< convex: converged where no weight changes by more in five passes
  std::int64_t max_iterations = 0;  ///< in all, resumed ones too; 0: the solver's own
  double time_limit_s = 0;          ///< 0: none
  /// Not 0: the energy is also estimated by axis-aligned differences of this step (equation 12;
  /// unit box) on samples that no optimiser uses, along the solve and at its end.
  double judged_step = 0;
  std::uint64_t seed = 0;
};

/// The energy of the field after so many iterations, as judged (equations 10 and 12).
struct JudgedEnergy {
  std::int64_t iteration = 0;
  std::int64_t points = 0;  ///< of the level
  double energy = 0;
};

/// How the rows of surface vertices came about (appendix A).
struct FieldEvaluationCounts {
  std::int64_t seen = 0;          ///< the masked kernel, rays from a little way inside
  std::int64_t flood_filled = 0;  ///< from neighbours: outside, or no point in view
  std::int64_t without_rays = 0;  ///< the kernel without visibility
  std::int64_t passengers = 0;    ///< clothes and shells, and what of another surface lies
                                  ///< outside: from the nearest vertices of the solid
};

struct GeometricFieldsFacts {
  double volume = 0;
  double sigma = 0;  ///< at the finest level
  ConditionRadii radii;
  std::int64_t rows = 0, held_out_rows = 0, blind_samples = 0;
  std::int64_t unreached_points = 0;  ///< hang together with nothing prescribed: nearest handle
  std::size_t row_bytes = 0;
  double held_out_energy = 0;  ///< per sampled volume like `energy`, on samples that took no part
  std::vector<JudgedEnergy> judged;  ///< if GeometricFieldsOptions::judged_step, last the result's
  FieldEvaluationCounts vertices;
  std::map<std::string, double> seconds;  ///< wall time of each stage
};

/// The shape as the field's own coordinates have it (methods/field_shape.h).
struct LaidShape;

/// A field that can be evaluated anywhere. Positions in the unit box. Owns all that it needs. A
/// flat shape (triangles, an outline or loose segments in one plane) has a field of its area, in
/// two dimensions: what solid(), conditions() and kernel() hold is laid into the plane z = 0, and
/// places elsewhere are dropped onto the plane.
class GeometricField {
 public:
  /// @throws DomainError if the shape has no inside worth the name or nothing binds it.
  GeometricField(const Mesh& mesh, const std::vector<Handle>& handles, const PaintedVertices& paint,
                 const GeometricFieldsOptions& options, const Progress& progress = {});
  ~GeometricField();
  GeometricField(GeometricField&&) noexcept;

  /// (n,m) rows on the simplex for (n,3) points, unit normals (n,3) or no rows.
  RowMatrix at(const Points& X, const Points& normals, std::vector<Fill>& fill) const;
  /// The vertices of another surface of the same character (a level of detail, clothes): appendix
  /// A's order of rescue inside, and what lies outside holds on to the shape's own surface. F may
  /// have no rows.
  RowMatrix at_surface(const Points& V, const Triangles& F, const Points& normals,
                       std::vector<Fill>& fill, FieldEvaluationCounts& counts) const;
  /// The vertices of the mesh, with appendix A's order of rescue. Painted ones have their paint.
  RowMatrix at_mesh(std::vector<Fill>& fill, FieldEvaluationCounts& counts) const;

  /// Is x inside the shape?
  bool inside(const Vec3& x) const;
  const Solid& solid() const;
  const FieldConditions& conditions() const;
  const KernelField& kernel() const;
  /// (N,m) parameters of kernel().points().
  const FloatRows& parameters() const;

  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  GeometricField(const LaidShape& shape, const PaintedVertices& paint,
                 const GeometricFieldsOptions& options, const Progress& progress);
  std::unique_ptr<Impl> impl_;
};

struct GeometricFieldsResult {
  std::shared_ptr<GeometricField> field;
  RowMatrix W;  ///< (n,m) rows of the mesh's vertices, on the simplex; columns are handles
  std::vector<Fill> fill;
  FieldState state;  ///< to be saved and taken up again
  SolveStats stats;
  GeometricFieldsFacts facts;
};

/// A field as it was saved, to be evaluated. @param state as geometric_fields gives it for these
/// arguments. @throws DomainError as GeometricField, InputError if the state does not fit.
std::shared_ptr<GeometricField> restore_field(const Mesh& mesh, const std::vector<Handle>& handles,
                                              const PaintedVertices& paint,
                                              const GeometricFieldsOptions& options,
                                              const FieldState& state,
                                              const Progress& progress = {});

/// The options by name and back, for saved fields. Unknown names are ignored.
std::vector<std::pair<std::string, double>> settings_of(const GeometricFieldsOptions& options);
void apply_settings(const std::vector<std::pair<std::string, double>>& settings,
                    GeometricFieldsOptions& options);

/// @param mesh in the unit box, equal positions merged. @param paint hard conditions on part of the
/// surface. @param resume a state to go on from (the same shape and handles; paint may differ), or
/// null. A solve that is stopped by a limit returns valid weights with status limit.
/// @throws DomainError as GeometricField, InputError if `resume` does not fit.
GeometricFieldsResult geometric_fields(const Mesh& mesh, const std::vector<Handle>& handles,
                                       const PaintedVertices& paint = {},
                                       const GeometricFieldsOptions& options = {},
                                       const FieldState* resume = nullptr,
                                       const Progress& progress = {});

}  // namespace skinfield
