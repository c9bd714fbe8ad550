// Evaluation of geometric fields, on the surface as appendix A says.
#include "domain/kd_tree.h"
#include "domain/point_evaluation.h"
#include "methods/field_impl.h"
#include "methods/field_shape.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

constexpr double nudge = 1e-5;  // into the shape, for rays; unit box
constexpr int fill_neighbours = 8;
constexpr int most_fills = 1000;
constexpr int compass = 8;  // directions to look for the inside

double softplus(double t) { return t > 30 ? t : std::log1p(std::exp(t)); }

/// Rows of the vertices that `wanted` marks become means over neighbours that have rows, outward
/// from those; true for the ones that got one.
void flood_fill(const std::vector<std::vector<int>>& neighbours, RowMatrix& W,
                std::vector<char>& wanted) {
  std::vector<int> open;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i]) open.push_back(static_cast<int>(i));
  for (int round = 0; round < most_fills && !open.empty(); ++round) {
    std::vector<int> filled;
    for (const int v : open) {
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(W.cols());
      for (const int u : neighbours[static_cast<std::size_t>(v)])
        if (!wanted[static_cast<std::size_t>(u)]) sum += W.row(u);
      if (!(sum.sum() > 0)) continue;
      W.row(v) = sum / sum.sum();
      filled.push_back(v);
    }
    if (filled.empty()) return;
    for (const int v : filled) wanted[static_cast<std::size_t>(v)] = 0;
    std::erase_if(open, [&](int v) { return !wanted[static_cast<std::size_t>(v)]; });
  }
}

/// Appendix A's rescue of the vertices that `open` marks: flood fill along edges, and where
/// triangles share no vertices, from the nearest; else the kernel without rays. `carried`: the
/// others without a row.
void rescue(const GeometricField::Impl& d, const Points& V, const Triangles& F,
            const std::vector<char>& open, const std::vector<char>& carried, RowMatrix& W,
            std::vector<Fill>& fill, FieldEvaluationCounts& counts) {
  const std::size_t n = open.size();
  if (std::count(open.begin(), open.end(), 1) == 0) return;
  std::vector<char> missing = open;
  for (std::size_t i = 0; i < n; ++i) missing[i] |= carried[i];
  std::vector<std::vector<int>> neighbours(n);
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    for (int c = 0; c < 3; ++c) {
      const int a = F(f, c), b = F(f, (c + 1) % 3);
      if (open[static_cast<std::size_t>(a)]) neighbours[static_cast<std::size_t>(a)].push_back(b);
      if (open[static_cast<std::size_t>(b)]) neighbours[static_cast<std::size_t>(b)].push_back(a);
    }
  flood_fill(neighbours, W, missing);
  std::vector<int> known;
  for (std::size_t i = 0; i < n; ++i) {
    if (open[i] && !missing[i]) fill[i] = Fill::hidden, ++counts.flood_filled;
    if (!missing[i]) known.push_back(static_cast<int>(i));
  }
  std::vector<int> left;
  for (std::size_t i = 0; i < n; ++i)
    if (open[i] && missing[i]) left.push_back(static_cast<int>(i));
  if (!left.empty() && !known.empty()) {
    Points K(static_cast<Eigen::Index>(known.size()), 3);
    for (std::size_t k = 0; k < known.size(); ++k)
      K.row(static_cast<Eigen::Index>(k)) = V.row(known[k]);
    const KdTree tree(K);
    std::vector<Neighbour> found;
    std::vector<int> filled;
    for (const int v : left) {
      tree.nearest(V.row(v).transpose(), fill_neighbours, found);
      // A piece of soup lies among others; what is far from all does not.
      if (found.front().distance > d.kernel->radius()) continue;
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(W.cols());
      for (const Neighbour& u : found) {
        const double s = u.distance / std::max(found.front().distance, 1e-9);
        sum += std::exp(1 - s * s) * W.row(known[static_cast<std::size_t>(u.index)]);
      }
      W.row(v) = sum / sum.sum();
      fill[static_cast<std::size_t>(v)] = Fill::hidden;
      ++counts.flood_filled;
      filled.push_back(v);
    }
    for (const int v : filled) missing[static_cast<std::size_t>(v)] = 0;
  }
  for (const int v : left) {
    if (!missing[static_cast<std::size_t>(v)]) continue;
    d.row_without_rays(V.row(v).transpose(), W.row(v).data());
    fill[static_cast<std::size_t>(v)] = Fill::hidden;
    ++counts.without_rays;
  }
}

/// The triangles, or an outline's and loose segments as triangles of no width: what values spread
/// along.
Triangles sides_of(const Mesh& mesh) {
  if (mesh.F.rows() > 0) return mesh.F;
  const Segments &E = mesh.outline.E, &loose = mesh.outline.loose;
  Triangles sides(E.rows() + loose.rows(), 3);
  sides.topRows(E.rows()) << E, E.col(1);
  sides.bottomRows(loose.rows()) << loose, loose.col(1);
  return sides;
}

/// Points outside, which `carried` marks, hold on to the shape's own surface.
void carry(const GeometricField& field, const GeometricField::Impl& d, const Points& X,
           const Points& normals, const std::vector<char>& carried, RowMatrix& W,
           std::vector<Fill>& fill) {
  std::vector<int> wanted;
  for (std::size_t i = 0; i < carried.size(); ++i)
    if (carried[i]) wanted.push_back(static_cast<int>(i));
  if (wanted.empty()) return;
  std::vector<Fill> ignored;
  FieldEvaluationCounts counts;
  const RowMatrix S = field.at_mesh(ignored, counts);
  InterpolationRows held, rows;
  for (Eigen::Index v = 0; v < S.rows(); ++v) held.row.push_back({{static_cast<int>(v), 1.0}});
  rows.row.resize(carried.size());
  rows.fill.resize(carried.size());
  carry_passengers(X, normals, d.mesh.V, d.solid.normals(), held, wanted, rows);
  const RowMatrix carried_rows = to_matrix(rows, S.rows()) * S;
  for (const int i : wanted) {
    W.row(i) = carried_rows.row(i);
    fill[static_cast<std::size_t>(i)] = Fill::passenger;
  }
}

}  // namespace

void FieldReader::hat(const FieldStencil& st, std::size_t q, double share, double* alpha) const {
  const Prescribed& p = st.place[q];
  for (const auto& [column, value] : p.value) alpha[column] += share * value;
  if (!(p.free > 0)) return;
  const Eigen::Index m = F_.cols();
  const float* phi = st.row(q);
  thread_local std::vector<double> f;
  f.assign(static_cast<std::size_t>(m), 0);
  for (std::size_t k = 0; k < st.node.size(); ++k) {
    if (phi[k] == 0) continue;
    const float* row = F_.data() + Eigen::Index{st.node[k]} * m;
    for (Eigen::Index j = 0; j < m; ++j)
      f[static_cast<std::size_t>(j)] += static_cast<double>(phi[k]) * static_cast<double>(row[j]);
  }
  double sum = 0;
  for (Eigen::Index j = 0; j < m; ++j) {
    double& v = f[static_cast<std::size_t>(j)];
    if (softplus_) v = bound_[static_cast<std::size_t>(j)] ? softplus(v) : 0;
    sum += v;
  }
  const double scale = share * p.free / sum;
  for (Eigen::Index j = 0; j < m; ++j) alpha[j] += scale * f[static_cast<std::size_t>(j)];
}

void FieldReader::at(const FieldStencil& st, std::size_t q, double* alpha) const {
  std::fill(alpha, alpha + F_.cols(), 0.0);
  const double blend = st.twin[q] >= 0 ? st.blend[q] : 0;
  if (blend < 1) hat(st, q, 1 - blend, alpha);
  if (blend > 0) hat(st, static_cast<std::size_t>(st.twin[q]), blend, alpha);
}

bool GeometricField::Impl::look_from(const Vec3& x, const Vec3& normal, Site& site) const {
  for (const double step : {-nudge, 0.0, nudge, -10 * nudge, 10 * nudge, -100 * nudge}) {
    if (step != 0 && normal.squaredNorm() == 0) continue;
    site = solid.site(x + step * normal);
    if (solid.inside(site)) return true;
  }
  // Places on the rim of a flat shape, of which another mesh has no normals in the plane.
  if (plane && normal.squaredNorm() == 0)
    for (int k = 0; k < compass; ++k) {
      const double angle = 2 * std::numbers::pi * k / compass;
      site = solid.site(x + nudge * Vec3(std::cos(angle), std::sin(angle), 0));
      if (solid.inside(site)) return true;
    }
  return false;
}

bool GeometricField::Impl::row(const Vec3& x, const Vec3& normal, double* alpha) const {
  Site site;
  if (!look_from(x, normal, site)) return false;
  thread_local FieldStencil stencil;
  if (!make_stencil(*kernel, *conditions, site, std::span(&x, 1), stencil)) return false;
  FieldReader(F, conditions->bound(), softplus).at(stencil, 0, alpha);
  return true;
}

void GeometricField::Impl::row_without_rays(const Vec3& x, double* alpha) const {
  std::vector<std::int32_t> near;
  kernel->near(x, kernel->radius(), near);
  if (near.empty()) near.push_back(kernel->nearest(x));
  Site site;
  site.x = x;
  FieldStencil stencil;
  make_stencil(*kernel, *conditions, site, std::span(&x, 1), stencil, &near);
  // Conditions ask for views, which there are none of here.
  for (Prescribed& p : stencil.place) p = {};
  FieldReader(F, conditions->bound(), softplus).at(stencil, 0, alpha);
}

RowMatrix GeometricField::at(const Points& places, const Points& given_normals,
                             std::vector<Fill>& fill) const {
  const Impl& d = *impl_;
  const Points X = laid_points(d.plane, places), normals = laid_directions(d.plane, given_normals);
  RowMatrix W = RowMatrix::Zero(X.rows(), d.F.cols());
  fill.assign(static_cast<std::size_t>(X.rows()), Fill::none);
  std::vector<char> carried(fill.size(), 0);
  parallel_for(fill.size(), 32, [&](std::size_t i) {
    const auto r = static_cast<Eigen::Index>(i);
    const Vec3 x = X.row(r).transpose();
    const Vec3 n = normal_or_zero(normals, r);
    if (d.row(x, n, W.row(r).data())) return;
    Site site;
    if (!d.look_from(x, n, site)) {
      carried[i] = 1;
      return;
    }
    d.row_without_rays(x, W.row(r).data());
    fill[i] = Fill::hidden;
  });
  carry(*this, d, X, normals, carried, W, fill);
  return W;
}

RowMatrix GeometricField::at_surface(const Points& given, const Triangles& F,
                                     const Points& given_normals, std::vector<Fill>& fill,
                                     FieldEvaluationCounts& counts) const {
  const Impl& d = *impl_;
  const Points V = laid_points(d.plane, given), normals = laid_directions(d.plane, given_normals);
  const auto n = static_cast<std::size_t>(V.rows());
  RowMatrix W = RowMatrix::Zero(V.rows(), d.F.cols());
  fill.assign(n, Fill::none);
  std::vector<char> carried(n, 0), open(n, 0);
  parallel_for(n, 32, [&](std::size_t i) {
    const auto v = static_cast<Eigen::Index>(i);
    const Vec3 x = V.row(v).transpose();
    const Vec3 normal = normal_or_zero(normals, v);
    if (d.row(x, normal, W.row(v).data())) return;
    Site site;
    (d.look_from(x, normal, site) ? open : carried)[i] = 1;
  });
  rescue(d, V, F, open, carried, W, fill, counts);
  carry(*this, d, V, normals, carried, W, fill);
  counts.passengers = std::count(carried.begin(), carried.end(), 1);
  counts.seen = std::count(fill.begin(), fill.end(), Fill::none);
  return W;
}

RowMatrix GeometricField::at_mesh(std::vector<Fill>& fill, FieldEvaluationCounts& counts) const {
  const Impl& d = *impl_;
  const Points& V = d.mesh.V;
  const Points& N = d.solid.normals();
  const auto n = static_cast<std::size_t>(V.rows());
  RowMatrix W = RowMatrix::Zero(V.rows(), d.F.cols());
  fill.assign(n, Fill::none);
  std::vector<char> carried(n, 0), open(n, 0);
  parallel_for(n, 32, [&](std::size_t i) {
    const auto v = static_cast<Eigen::Index>(i);
    const Vec3 x = V.row(v).transpose();
    if (d.solid.kind_of_vertex(static_cast<int>(i)) == Solid::PartKind::passenger &&
        !d.solid.inside(x)) {
      carried[i] = 1;
      return;
    }
    const Vec3 normal = normal_or_zero(N, v);
    open[i] = !d.row(x, normal, W.row(v).data());
  });
  rescue(d, V, sides_of(d.mesh), open, carried, W, fill, counts);
  std::vector<int> wanted, holding;
  for (std::size_t i = 0; i < n; ++i)
    (carried[i] ? wanted : holding).push_back(static_cast<int>(i));
  if (!wanted.empty() && !holding.empty()) {
    Points X(static_cast<Eigen::Index>(holding.size()), 3), XN(N.rows() > 0 ? X.rows() : 0, 3);
    InterpolationRows held, rows;
    for (std::size_t k = 0; k < holding.size(); ++k) {
      X.row(static_cast<Eigen::Index>(k)) = V.row(holding[k]);
      if (XN.rows() > 0) XN.row(static_cast<Eigen::Index>(k)) = N.row(holding[k]);
      held.row.push_back({{holding[k], 1.0}});
    }
    rows.row.resize(n);
    rows.fill.resize(n);
    carry_passengers(V, N, X, XN, held, wanted, rows);
    std::vector<int> component(n);
    for (std::size_t i = 0; i < n; ++i)
      component[i] = d.solid.component_of_vertex(static_cast<int>(i));
    stiffen_floating(V, component, X, wanted, rows);
    const RowMatrix carried_rows = to_matrix(rows, V.rows()) * W;
    for (const int v : wanted) {
      W.row(v) = carried_rows.row(v);
      fill[static_cast<std::size_t>(v)] = Fill::passenger;
      ++counts.passengers;
    }
  }
  counts.seen = std::count(fill.begin(), fill.end(), Fill::none);
  for (std::size_t k = 0; k < d.paint.vertex.size(); ++k)
    W.row(d.paint.vertex[k]) = d.paint.weights.row(static_cast<Eigen::Index>(k));
  for (Eigen::Index v = 0; v < W.rows(); ++v) {
    const double sum = W.row(v).sum();
    if (sum > 0) W.row(v) /= sum;
  }
  return W;
}

bool GeometricField::inside(const Vec3& x) const {
  return impl_->solid.inside(Vec3(laid_points(impl_->plane, x.transpose()).row(0).transpose()));
}
const Solid& GeometricField::solid() const { return impl_->solid; }
const FieldConditions& GeometricField::conditions() const { return *impl_->conditions; }
const KernelField& GeometricField::kernel() const { return *impl_->kernel; }
const FloatRows& GeometricField::parameters() const { return impl_->F; }

}  // namespace skinfield
