// The inner loops of the rows of a geometric field's energy: small dense blocks times eight
// columns.
#pragma once

namespace skinfield {

constexpr int kTileRows = 24;  ///< rows of a block
constexpr int kLanes = 8;      ///< columns at a time

/// residual (24,8) += sum over k of R[k] (24) * F[k] (8).
void tile_forward(const float* R, int n, const float* F, float* residual);
/// G[k] (8) = sum over rows r of R[k][r] * residual[r].
void tile_backward(const float* R, int n, const float* residual, float* G);
/// y (n) += a * x (n).
void add_scaled(float* y, const float* x, float a, int n);

}  // namespace skinfield
