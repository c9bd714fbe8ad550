// How good a field is, for comparisons: the standard axis-aligned estimator of its energy, on
// samples that no optimiser uses (geometric fields, equations 10 to 12; the paper's figure 13).
#pragma once

#include "methods/field_impl.h"

namespace skinfield {

/// Samples and step stay the same while a solve goes from level to level. Refers to the field.
class FieldJudge {
 public:
  FieldJudge(const GeometricField::Impl& field, const GeometricFieldsOptions& options,
             const Progress& progress);
  /// What the samples see of the field's kernel and conditions as they are now.
  void look(const Progress& progress);
  /// The integral over the shape of the squared Laplacians' sum over handles; unit box.
  double energy(const FloatRows& F, const Progress& progress) const;

 private:
  const GeometricField::Impl& field_;
  double step_;
  std::vector<WeightedSite> samples_;
  std::vector<FieldStencil> stencils_;  // no places: the sample sees nothing
};

}  // namespace skinfield
