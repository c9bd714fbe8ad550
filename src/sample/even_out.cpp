// Local edits of a closed manifold triangle mesh: collapse short edges, flip toward Delaunay.
// Every edit is tested so that the surface stays manifold (link condition) and no face turns over.
#include "sample/polygonise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

namespace skinfield::sample_detail {
namespace {

class Editor {
 public:
  Editor(const Mesh& mesh, const Vector& size) : V_(mesh.V), size_(size) {
    faces_.resize(static_cast<std::size_t>(mesh.F.rows()));
    around_.resize(static_cast<std::size_t>(mesh.V.rows()));
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      for (std::size_t c = 0; c < 3; ++c) {
        faces_[f][c] = mesh.F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c));
        around(faces_[f][c]).push_back(static_cast<int>(f));
      }
    }
  }

  void collapse_short() {
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      for (std::size_t c = 0; c < 3; ++c) {
        if (!alive(f)) break;
        const int a = faces_[f][c], b = faces_[f][(c + 1) % 3];
        const double wanted = 0.5 * (size_[a] + size_[b]);
        if (length(a, b) < 0.7 * wanted && collapse(a, b, 1.6 * wanted)) break;
      }
    }
  }

  void flip_all() {
    for (int pass = 0; pass < 3; ++pass) {
      for (std::size_t f = 0; f < faces_.size(); ++f) {
        for (std::size_t c = 0; alive(f) && c < 3; ++c) flip(static_cast<int>(f), c);
      }
    }
  }

  void write(Mesh& mesh, Vector& size) const {
    std::vector<int> number(around_.size(), -1);
    Eigen::Index vertices = 0, faces = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (alive(f)) ++faces;
    }
    mesh.F.resize(faces, 3);
    faces = 0;
    for (std::size_t v = 0; v < around_.size(); ++v) {
      if (!around_[v].empty()) number[v] = static_cast<int>(vertices++);
    }
    mesh.V.resize(vertices, 3);
    size.resize(vertices);
    for (std::size_t v = 0; v < around_.size(); ++v) {
      if (number[v] < 0) continue;
      mesh.V.row(number[v]) = V_.row(static_cast<Eigen::Index>(v));
      size[number[v]] = size_[static_cast<Eigen::Index>(v)];
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (!alive(f)) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        mesh.F(faces, static_cast<Eigen::Index>(c)) =
            number[static_cast<std::size_t>(faces_[f][c])];
      }
      ++faces;
    }
  }

 private:
  using Face = std::array<int, 3>;

  std::vector<int>& around(int v) { return around_[static_cast<std::size_t>(v)]; }
  Face& face(int f) { return faces_[static_cast<std::size_t>(f)]; }
  bool alive(std::size_t f) const { return faces_[f][0] >= 0; }
  Vec3 at(int v) const { return V_.row(v); }
  double length(int a, int b) const { return (V_.row(a) - V_.row(b)).norm(); }
  static bool has(const Face& f, int v) { return f[0] == v || f[1] == v || f[2] == v; }
  Vec3 normal(const Face& f) const { return (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])); }

  std::vector<int> neighbours(int v) {
    std::vector<int> list;
    for (const int f : around(v)) {
      for (const int w : face(f)) {
        if (w != v) list.push_back(w);
      }
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
  }

  /// Would moving v to x turn over or flatten a face that does not contain `except`?
  bool turns(int v, int except, const Vec3& x) {
    for (const int f : around(v)) {
      const Face corners = face(f);
      if (has(corners, except)) continue;
      std::array<Vec3, 3> p;
      for (std::size_t c = 0; c < 3; ++c) p[c] = corners[c] == v ? x : at(corners[c]);
      const Vec3 before = normal(corners), after = (p[1] - p[0]).cross(p[2] - p[0]);
      if (before.dot(after) <= 0.3 * before.norm() * after.norm()) return true;
    }
    return false;
  }

  bool collapse(int a, int b, double longest) {
    const std::vector<int> of_a = neighbours(a), of_b = neighbours(b);
    std::vector<int> common, all;
    std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                          std::back_inserter(common));
    std::set_union(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(all));
    if (common.size() != 2 || all.size() < 5 || all.size() > 10) return false;
    for (const int w : common) {
      if (around(w).size() <= 4) return false;
    }
    const Vec3 x = 0.5 * (at(a) + at(b));
    for (const int w : all) {
      if (w != a && w != b && (at(w) - x).norm() > longest) return false;
    }
    if (turns(a, b, x) || turns(b, a, x)) return false;
    for (const int f : std::vector<int>(around(b))) {
      if (has(face(f), a)) {
        for (const int w : face(f)) {
          if (w != b) std::erase(around(w), f);
        }
        face(f)[0] = -1;
      } else {
        std::replace(face(f).begin(), face(f).end(), b, a);
        around(a).push_back(f);
      }
    }
    around(b).clear();
    V_.row(a) = x.transpose();
    size_[a] = 0.5 * (size_[a] + size_[b]);
    return true;
  }

  double angle(int at_vertex, int p, int q) const {
    const Vec3 u = at(p) - at(at_vertex), v = at(q) - at(at_vertex);
    return std::atan2(u.cross(v).norm(), u.dot(v));
  }

  void flip(int f, std::size_t corner) {
    // The edge a-b, faces (a,b,c) and (b,a,d), becomes c-d.
    const int a = face(f)[corner], b = face(f)[(corner + 1) % 3], c = face(f)[(corner + 2) % 3];
    int other = -1;
    for (const int g : around(a)) {
      if (g != f && has(face(g), b)) other = g;
    }
    if (other < 0) return;
    int d = -1;
    for (const int w : face(other)) {
      if (w != a && w != b) d = w;
    }
    if (angle(c, a, b) + angle(d, a, b) <= 3.15) return;  // already Delaunay
    if (around(a).size() <= 4 || around(b).size() <= 4) return;
    for (const int g : around(c)) {
      if (has(face(g), d)) return;
    }
    const Face first = {a, d, c}, second = {b, c, d};
    const Vec3 sum = (normal(face(f)) + normal(face(other))).normalized();
    const Vec3 n1 = normal(first), n2 = normal(second);
    if (n1.dot(sum) < 0.85 * n1.norm() || n2.dot(sum) < 0.85 * n2.norm()) return;
    face(f) = first;
    face(other) = second;
    std::erase(around(a), other);
    std::erase(around(b), f);
    around(c).push_back(other);
    around(d).push_back(f);
  }

  Points V_;
  Vector size_;
  std::vector<Face> faces_;
  std::vector<std::vector<int>> around_;
};

}  // namespace

void even_out(Mesh& mesh, Vector& size) {
  Editor editor(mesh, size);
  editor.collapse_short();
  editor.flip_all();
  editor.write(mesh, size);
}

}  // namespace skinfield::sample_detail
