// Harmonic, biharmonic and triharmonic weights without bounds: linear systems with the handles'
// rows given, one sparse factor for all columns. For comparison, and where speed is all.
// - Harmonic: Joshi, Meyer, DeRose, Green, Sanocki 2007, "Harmonic coordinates for character
//   articulation"; equation 1, in the interior.
// - Biharmonic and triharmonic: Botsch, Kobbelt 2004, "An intuitive framework for real-time
//   freeform modeling"; Jacobson, Tosun, Sorkine, Zorin 2010, "Mixed finite elements for
//   variational surface modeling", with lumped masses.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"

#include <vector>

namespace skinfield {

struct PolyharmonicOptions {
  int order = 1;            ///< 1: K, 2: K M^-1 K, 3: K M^-1 K M^-1 K
  FixedRows paint;          ///< more fixed rows; they win over the problem's
  RowMatrix start;          ///< (N,m) the values of locked columns, or empty
  std::vector<int> locked;  ///< columns kept from `start`
};

struct PolyharmonicResult {
  /// (N,m) raw nodal weights: rows sum to one (linearity), entries may leave [0,1]. Order 1 stays
  /// in it where K has no positive entry off the diagonal (maximum principle).
  RowMatrix W;
  std::vector<int> unreached;  ///< nodes whose component has no fixed row: zero rows in W
  SolveStats stats;            ///< energy 1/2 tr(W' A W) over the columns not locked
};

/// Each column minimises its energy with the fixed rows given. Locked columns hold `start` (scaled
/// down where they sum to more than 1); in fixed rows the other columns get what they leave, and
/// are then solved as ever: valid_weights() makes their sum right in between.
/// @throws SolveError if no row is fixed, sizes do not fit, or rounding makes A indefinite.
PolyharmonicResult polyharmonic(const BoundedBiharmonicProblem& problem,
                                const PolyharmonicOptions& options = {},
                                const Progress& progress = {});

/// The nearest thing to raw weights (n,m) that is valid, as everyone makes it: negative entries
/// become zero, rows are scaled to sum to one. Locked columns stay as they are, if they sum to at
/// most 1, and the others are scaled to what they leave (equally if they are all zero). Rows of
/// zeros stay.
RowMatrix valid_weights(const RowMatrix& raw, const std::vector<int>& locked = {});

}  // namespace skinfield
