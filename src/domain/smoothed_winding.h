// The smoothed winding number of dirty parts on a trilinear grid (findings E 4): what blocks and
// what is inside where triangles themselves can't be trusted.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/base/types.h"

#include <functional>
#include <vector>

namespace skinfield {

class SmoothedWinding {
 public:
  /// w_eps(x) without a grid, of the dirty parts.
  using Direct = std::function<double(const Vec3& x, double epsilon)>;
  /// @param winding of the dirty triangles, segments or points. @param sources (k,3) their
  /// centroids. @param edge their median edge length (or point distance).
  /// @param samples (s,3) handle samples. @param clean (s) clean parts' winding number there.
  /// @param spacing expected node distance.
  SmoothedWinding(const Direct& winding, const Points& sources, double edge, const Points& samples,
                  const Vector& clean, double spacing, const Progress& progress);

  /// w_eps at x, raised to the level near bones; 0 outside the grid.
  double at(const Vec3& x) const;
  /// lev(x): the winding number that counts as fully inside here.
  double level(const Vec3& x) const;
  double epsilon() const { return epsilon_; }
  /// w_eps + clean at the samples (before raising).
  const Vector& at_samples() const { return at_samples_; }

 private:
  struct Cell {
    int i[3];
    double f[3];
  };
  bool locate(const Vec3& x, Cell& cell) const;
  double blend(const std::vector<float>& values, const Cell& cell) const;
  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(i);
  }

  double epsilon_ = 0;
  Vec3 origin_ = Vec3::Zero();
  int size_[3] = {0, 0, 0};
  std::vector<float> winding_, level_;
  Vector at_samples_;
};

}  // namespace skinfield
