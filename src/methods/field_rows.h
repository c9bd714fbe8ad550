// The energy of a geometric field that is affine in its parameters, as rows over a fixed set of
// samples: 1/2 |A F + C|^2 (equations 10 to 13 with the affine form of the conditions).
#pragma once

#include "skinfield/base/random.h"
#include "skinfield/domain/field_stencil.h"
#include "skinfield/domain/interior_sampler.h"
#include "skinfield/weights/field_state.h"

#include <array>
#include <span>

namespace skinfield {

/// Three orthonormal directions, each uniform on the sphere (equation 13's v; those of a sample
/// share its rays). In the plane the first two, uniform on the circle.
std::array<Vec3, 3> random_frame(Random& random, int dimension = 3);

/// Equation 11 for a winding number of 1 inside, clipped to [0,1].
double winding_weight(double winding, double low, double high);

/// Samples grouped by place into blocks of 24 rows, as many a sample as there are dimensions: dense
/// over the points that they use.
class FieldRows {
 public:
  /// @param samples with weights that already hold equation 11's factor. @param h the
  /// finite-difference step, times the field's grading. Sample i's directions depend on (seed,
  /// stream + i).
  FieldRows(const KernelField& field, const FieldConditions& conditions,
            std::span<const WeightedSite> samples, double h, int columns, std::uint64_t seed,
            std::uint64_t stream, const Progress& progress);

  /// 1/2 |A F + C|^2; its gradient into G (N,m) if not null. Columns that are zero on all points
  /// of a block cost nothing there.
  double energy(const FloatRows& F, FloatRows* G, const Progress& progress) const;
  /// The diagonal of a majorant: A'A <= diag(D), D_i = sum_r |a_ri| |a_r|_1.
  Vector majorant() const;
  /// Largest eigenvalue of D^-1/2 A'A D^-1/2 by power iterations from `v` (updated), at most 1.
  double largest_eigenvalue(const Vector& D, int iterations, Vector& v,
                            const Progress& progress) const;
  Eigen::Index points() const { return points_; }
  std::int64_t rows() const { return rows_; }
  std::int64_t blind_samples() const { return blind_; }  ///< that see no point: left out
  std::size_t bytes() const;

 private:
  struct Constant {
    int row;
    int column;
    float value;
  };
  struct Tile {
    std::vector<std::int32_t> node;
    std::vector<float> R;  // (node, 24)
    std::vector<Constant> constants;
  };
  void fill(const KernelField& field, const FieldConditions& conditions,
            std::span<const WeightedSite> samples, std::span<const int> order, double h,
            std::uint64_t seed, std::uint64_t stream, Tile& tile, std::int64_t& blind) const;

  Eigen::Index points_ = 0;
  int columns_ = 0, directions_ = 3;
  std::int64_t rows_ = 0, blind_ = 0;
  std::vector<Tile> tiles_;
};

}  // namespace skinfield
