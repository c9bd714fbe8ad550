// What is prescribed to a geometric field, hard and by construction: handles keep their value
// (Lagrange property), painted parts of the surface theirs (Dirichlet), and near walls the normal
// derivative vanishes if asked to (zero Neumann). Geometric fields, equations 5 to 9, 15 and 16.
//
// All have one form: alpha(x) = value(x) + free(x) f(x), free + sum of value = 1, so that a field f
// on the simplex stays there. The mollifiers measure distance only to what is in view: a bone
// close to a wall does not bleed through it.
#pragma once

#include "skinfield/domain/grading.h"
#include "skinfield/domain/solid.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/rig/skeleton.h"

#include <optional>
#include <utility>
#include <vector>

namespace skinfield {

/// Rows given on vertices of the surface: Dirichlet conditions.
struct PaintedVertices {
  std::vector<int> vertex;  ///< of the mesh, distinct
  RowMatrix weights;        ///< (k,m) rows on the simplex, the handles' columns
};

/// The bump function of equation 16: 1 at distance 0, 0 from epsilon on, all derivatives 0 at both.
double bump(double distance, double epsilon);

/// alpha = value + free * f at one place. `value` holds (column, share) pairs.
struct Prescribed {
  double free = 1;
  std::vector<std::pair<int, double>> value;
};

struct ConditionRadii {
  double lagrange = 0, dirichlet = 0, neumann = 0;  ///< unit box; 0: none
};

/// Positions in the unit box. Thread-safe for queries. Refers to the solid.
class FieldConditions {
 public:
  /// @param mesh the one that the solid was made of. Handles' parts outside of the solid are cut;
  /// regions count as painted with their own column. Triangles whose corners are all painted, and
  /// a planar solid's segments whose ends are, carry the paint between them.
  /// @throws InputError if a painted vertex does not exist or sizes do not fit.
  FieldConditions(const Solid& solid, const Mesh& mesh, const std::vector<Handle>& handles,
                  const PaintedVertices& paint, bool neumann);

  /// Lagrange's and Dirichlet's are narrower by the grading's s.
  void set_radii(const ConditionRadii& radii, const Grading& grading = {}) {
    radii_ = radii;
    grading_ = grading;
  }
  const ConditionRadii& radii() const { return radii_; }
  bool neumann() const { return walls_.has_value(); }

  /// Parts of handles and painted places that one site sees.
  struct View {
    Site from;
    struct Piece {
      int column;
      Vec3 a, b;
    };
    std::vector<Piece> pieces;
  };
  /// What `from` sees of handles within `reach` of it.
  void look(const Site& from, double reach, View& view) const;
  /// Is anything prescribed in view of `from`, within `reach`?
  bool touches(const Site& from, double reach) const;
  /// Equations 7, 15 and 16 at x, a place near view.from. Paint goes before handles.
  void at(const View& view, const Vec3& x, Prescribed& result) const;
  /// For zero Neumann: the closest point of the wall to x and its weight w(t) in equation 9; false
  /// where there is none within the radius.
  bool wall(const Vec3& x, Vec3& p, double& weight) const;

  /// Inside parts of bones and points (both ends equal), for drawing samples near them.
  const std::vector<std::pair<Vec3, Vec3>>& segments() const { return segments_; }
  /// (m) does anything prescribe this column? The others stay zero.
  const std::vector<char>& bound() const { return bound_; }

 private:
  struct Segment {
    int column;
    Vec3 a, b;
    std::vector<Site> sites;  ///< at the middles of equal parts
  };
  /// Does the view's site see the painted place?
  bool sees_paint(const Site& from, const ClosestPoint& place) const;
  bool paint_at(const View& view, const Vec3& x, Prescribed& result, double& weight) const;

  const Solid& solid_;
  ConditionRadii radii_;
  Grading grading_;
  std::vector<Segment> handles_;
  std::vector<std::pair<Vec3, Vec3>> segments_;
  std::vector<char> bound_;
  Triangles painted_faces_;  // of single vertices: three times the same
  std::vector<int> paint_row_;
  RowMatrix paint_weights_;
  Points inward_;  // (n,3) painted vertices moved a little way into the solid
  std::optional<ClosestPointQuery> painted_, walls_;
};

}  // namespace skinfield
