// The function space of geometric fields: N interior points carry K parameters each, and a value
// anywhere is their normalised kernel regression over the points in view ("Robust Biharmonic
// Skinning Using Geometric Fields", section 4.1, equations 2 to 4).
#pragma once

#include "skinfield/domain/grading.h"
#include "skinfield/domain/solid.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace skinfield {

struct KernelFieldOptions {
  /// gaussian: exp(-d^2 / 2 sigma^2) cut at 3 sigma (equation 3). compact: (1 - d^2 / r^2)^3 with
  /// r = 2.1 sigma: a third of the points, and smooths less (docs/methods/geometric_fields.md).
  enum class Kernel : unsigned char { compact, gaussian };
  Kernel kernel = Kernel::compact;
  int neighbour = 9;  ///< sigma is the median distance to this neighbour
  double width = 1;   ///< factor on sigma
};

/// Positions of some points relative to an origin, for many evaluations.
struct LocalPoints {
  std::vector<float> x, y, z;
  std::vector<float> inverse;  ///< of the square of where the kernel ends
};

/// Positions in the unit box. Thread-safe for queries. Refers to the solid, which must outlive it.
class KernelField {
 public:
  /// @param points inside the solid, with exact clearances; at least one. @param grading their
  /// kernels are narrower by its s, for points spread with its density.
  KernelField(const Solid& solid, std::vector<Site> points, const KernelFieldOptions& options = {},
              const Grading& grading = {});
  ~KernelField();
  KernelField(KernelField&&) noexcept;
  KernelField& operator=(KernelField&&) noexcept;

  /// In Morton order, which is not the order that they were given in.
  const std::vector<Site>& points() const;
  /// Of the widest kernels.
  double sigma() const;
  /// Where the widest kernels end.
  double radius() const;
  const Grading& grading() const;
  const Solid& solid() const;

  /// The points nearer to `from` than `reach` that it sees (equation 4), ascending. `reach` is
  /// meant for the widest kernels: points of narrower ones are as much nearer as they end earlier.
  void see(const Site& from, double reach, std::vector<std::int32_t>& seen) const;
  /// The points nearer to `from` than `reach`, seen or not, ascending.
  void near(const Vec3& from, double reach, std::vector<std::int32_t>& found) const;
  /// Normalised kernel weights (equation 2) at x of the points `seen`, into phi (seen.size()):
  /// non-negative, sum 1. The nearest takes all where none is within the radius.
  /// Precondition: seen is not empty.
  void weights(const Vec3& x, const std::vector<std::int32_t>& seen, float* phi) const;
  void gather(const std::vector<std::int32_t>& index, const Vec3& origin, LocalPoints& local) const;
  /// The same at x relative to the origin of `local`.
  void weights(const LocalPoints& local, const Vec3& x, float* phi) const;
  int nearest(const Vec3& x) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
