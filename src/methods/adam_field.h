// The paper's optimiser of geometric fields: Adam (Kingma and Ba 2014) on parameters behind a
// softplus and a normalisation, energies from few samples a step (sections 4.2 and 5, appendix A).
#pragma once

#include "skinfield/domain/field_stencil.h"
#include "skinfield/weights/field_state.h"

#include <span>
#include <vector>

namespace skinfield {

/// A sample y with what y, y + h v and y - h v see.
struct FieldSample {
  FieldStencil stencil;
  double weight = 0;  ///< volume that it stands for; 0: sees nothing
  double h = 1;       ///< finite-difference step
};

/// Softplus and logistic of n values, to about 1e-6.
void softplus_and_slope(const float* f, int n, float* value, float* slope);

/// The parameters of one level under optimisation. Columns are padded to eights inside.
class AdamField {
 public:
  /// first, second: Adam's moments, or empty for zero. Columns where `bound` is 0 stay as they are
  /// and have no share.
  AdamField(const FloatRows& F, const FloatRows& first, const FloatRows& second,
            const std::vector<char>& bound);

  /// One step on the samples' energy 1/2 sum of weight |eq. 13|^2; its value. `t`: 1 for the first
  /// step ever.
  double step(std::span<const FieldSample* const> samples, double rate, std::int64_t t);
  /// The energy alone.
  double energy(std::span<const FieldSample* const> samples);

  FloatRows parameters() const { return unpad(F_); }
  FloatRows first() const { return unpad(first_); }
  FloatRows second() const { return unpad(second_); }

 private:
  FloatRows pad(const FloatRows& rows) const;
  FloatRows unpad(const FloatRows& rows) const { return rows.leftCols(columns_); }
  /// Energy of one sample; the derivative by f at its places into g (places, padded).
  double forward(const FieldSample& sample, std::vector<float>* g) const;

  Eigen::Index columns_, padded_;
  std::vector<float> mask_;  // (padded) 1 for bound columns
  FloatRows F_, first_, second_;
  std::vector<std::vector<float>> g_;
};

}  // namespace skinfield
