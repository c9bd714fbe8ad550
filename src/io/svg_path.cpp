#include "io/svg_path.h"

#include "io/text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

namespace skinfield::svg {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kMostChords = 1000;

/// Numbers as SVG writes them: "1-2.5.5,4" are 1, -2.5, 0.5 and 4.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  void skip_separators() {
    while (!rest_.empty() && (blank(rest_.front()) || rest_.front() == ',')) rest_.remove_prefix(1);
  }
  bool done() {
    skip_separators();
    return rest_.empty();
  }
  char peek() const { return rest_.empty() ? '\0' : rest_.front(); }
  void drop() { rest_.remove_prefix(1); }

  std::optional<double> number() {
    skip_separators();
    std::size_t n = 0;
    const auto digits = [&] {
      const std::size_t from = n;
      while (n < rest_.size() && std::isdigit(static_cast<unsigned char>(rest_[n]))) ++n;
      return n > from;
    };
    if (n < rest_.size() && (rest_[n] == '+' || rest_[n] == '-')) ++n;
    bool any = digits();
    if (n < rest_.size() && rest_[n] == '.') {
      ++n;
      any = digits() || any;
    }
    if (!any) return std::nullopt;
    if (n < rest_.size() && (rest_[n] == 'e' || rest_[n] == 'E')) {
      const std::size_t before = n++;
      if (n < rest_.size() && (rest_[n] == '+' || rest_[n] == '-')) ++n;
      if (!digits()) n = before;
    }
    const auto value = text::to_number(rest_.substr(0, n));
    if (!value || !std::isfinite(*value)) return std::nullopt;
    rest_.remove_prefix(n);
    return value;
  }
  /// 0 or 1, which need no blank behind them.
  std::optional<bool> flag() {
    skip_separators();
    if (peek() != '0' && peek() != '1') return std::nullopt;
    const bool value = peek() == '1';
    drop();
    return value;
  }
  std::optional<Point> point() {
    const auto x = number();
    const auto y = x ? number() : std::nullopt;
    if (!y) return std::nullopt;
    return Point(*x, *y);
  }

  static bool blank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

 private:
  std::string_view rest_;
};

Segment line_segment(const Point& end) { return {false, end, end, end}; }

/// Cubics for an arc of an ellipse by its centre, axes and angles, in pieces of at most 45 degrees
/// (then within 5e-6 of the radius).
void append_arc(Subpath& path, const Point& centre, const Eigen::Matrix2d& axes, double from,
                double sweep) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(sweep) / (kPi / 4) - 1e-9)));
  const double step = sweep / pieces, k = 4.0 / 3.0 * std::tan(step / 4);
  const auto at = [&](double x, double y) -> Point { return centre + axes * Point(x, y); };
  for (int i = 0; i < pieces; ++i) {
    const double a = from + i * step, b = a + step;
    const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
    path.segments.push_back(
        {true, at(ca - k * sa, sa + k * ca), at(cb + k * sb, sb - k * cb), at(cb, sb)});
  }
}

/// SVG 1.1, appendix F.6: from end points to the centre.
void append_svg_arc(Subpath& path, const Point& from, const Point& to, double rx, double ry,
                    double degrees, bool large, bool sweep) {
  rx = std::abs(rx), ry = std::abs(ry);
  if (from == to) return;
  if (rx == 0 || ry == 0) {
    path.segments.push_back(line_segment(to));
    return;
  }
  const double phi = degrees * kPi / 180;
  Eigen::Matrix2d turn;
  turn << std::cos(phi), -std::sin(phi), std::sin(phi), std::cos(phi);
  const Point half = turn.transpose() * (0.5 * (from - to));
  const double x = half.x() / rx, y = half.y() / ry, reach = x * x + y * y;
  if (reach > 1) rx *= std::sqrt(reach), ry *= std::sqrt(reach);
  const Point unit = Point(half.x() / rx, half.y() / ry);  // on or within the unit circle
  const double r2 = unit.squaredNorm();
  const double root = r2 > 0 ? std::sqrt(std::max(0.0, (1 - r2) / r2)) : 0.0;
  const Point centre_unit = (large != sweep ? root : -root) * Point(unit.y(), -unit.x());
  const Point a = unit - centre_unit, b = -unit - centre_unit;
  const Eigen::Matrix2d axes = turn * Eigen::Vector2d(rx, ry).asDiagonal();
  const Point centre = axes * centre_unit + 0.5 * (from + to);
  const double start = std::atan2(a.y(), a.x());
  double angle = std::atan2(b.y(), b.x()) - start;
  if (sweep && angle < 0) angle += 2 * kPi;
  if (!sweep && angle > 0) angle -= 2 * kPi;
  append_arc(path, centre, axes, start, angle);
  path.segments.back().end = to;
}

class PathReader {
 public:
  explicit PathReader(std::string_view d) : in_(d) {}

  Path read(bool& broken) {
    broken = false;
    while (!in_.done()) {
      if (std::isalpha(static_cast<unsigned char>(in_.peek()))) {
        command_ = in_.peek();
        in_.drop();
        if (command_ == 'Z' || command_ == 'z') {
          close();
          continue;
        }
      } else if (command_ == 0 || command_ == 'Z' || command_ == 'z') {
        broken = true;
        break;
      }
      if (!step()) {
        broken = true;
        break;
      }
    }
    return std::move(path_);
  }

 private:
  void close() {
    if (path_.empty()) return;
    path_.back().closed = true;
    here_ = path_.back().start;
    open_ = false;
    last_ = 'Z';
  }

  /// A subpath to draw into: after Z, or without M, one that starts here.
  Subpath& current() {
    if (!open_) {
      path_.push_back({here_, {}, false});
      open_ = true;
    }
    return path_.back();
  }

  void line_to(const Point& p) {
    current().segments.push_back(line_segment(p));
    here_ = p;
  }
  void curve_to(const Point& a, const Point& b, const Point& p) {
    current().segments.push_back({true, a, b, p});
    here_ = p;
  }
  void quadratic_to(const Point& c, const Point& p) {
    const Point from = here_;
    curve_to(from + 2.0 / 3.0 * (c - from), p + 2.0 / 3.0 * (c - p), p);
    control_ = c;
  }

  /// One set of a command's arguments.
  bool step() {
    const char upper = static_cast<char>(std::toupper(static_cast<unsigned char>(command_)));
    const Point base = command_ == upper ? Point(0, 0) : here_;
    if (path_.empty() && !open_ && upper != 'M') return false;  // a path begins with M
    const auto next = [&]() -> std::optional<Point> {
      const auto p = in_.point();
      if (!p) return std::nullopt;
      return Point(*p + base);
    };
    // Where S and T mirror the control point before them.
    const Point mirrored = 2 * here_ - control_;
    switch (upper) {
      case 'M': {
        const auto p = next();
        if (!p) return false;
        path_.push_back({*p, {}, false});
        open_ = true;
        here_ = *p;
        command_ = command_ == 'M' ? 'L' : 'l';  // further pairs are lines
        break;
      }
      case 'L': {
        const auto p = next();
        if (!p) return false;
        line_to(*p);
        break;
      }
      case 'H': {
        const auto x = in_.number();
        if (!x) return false;
        line_to({*x + base.x(), here_.y()});
        break;
      }
      case 'V': {
        const auto y = in_.number();
        if (!y) return false;
        line_to({here_.x(), *y + base.y()});
        break;
      }
      case 'C':
      case 'S': {
        const Point smooth = last_ == 'C' || last_ == 'S' ? mirrored : here_;
        const auto a = upper == 'C' ? next() : std::optional<Point>(smooth);
        const auto b = a ? next() : std::nullopt;
        const auto p = b ? next() : std::nullopt;
        if (!p) return false;
        curve_to(*a, *b, *p);
        control_ = *b;
        break;
      }
      case 'Q':
      case 'T': {
        const Point smooth = last_ == 'Q' || last_ == 'T' ? mirrored : here_;
        const auto c = upper == 'Q' ? next() : std::optional<Point>(smooth);
        const auto p = c ? next() : std::nullopt;
        if (!p) return false;
        quadratic_to(*c, *p);
        break;
      }
      case 'A': {
        const auto radii = in_.point();
        const auto turn = radii ? in_.number() : std::nullopt;
        const auto large = turn ? in_.flag() : std::nullopt;
        const auto sweep = large ? in_.flag() : std::nullopt;
        const auto p = sweep ? next() : std::nullopt;
        if (!p) return false;
        append_svg_arc(current(), here_, *p, radii->x(), radii->y(), *turn, *large, *sweep);
        here_ = *p;
        break;
      }
      default:
        return false;
    }
    last_ = upper;
    return true;
  }

  Scanner in_;
  Path path_;
  Point here_{0, 0}, control_{0, 0};
  char command_ = 0, last_ = 0;
  bool open_ = false;
};

Point moved(const Affine& A, const Point& p) { return A.leftCols<2>() * p + A.col(2); }

}  // namespace

Path parse_path(std::string_view d, bool& broken) { return PathReader(d).read(broken); }

Path parse_points(std::string_view points, bool closed, bool& broken) {
  broken = false;
  Scanner in(points);
  Path path;
  while (!in.done()) {
    const auto p = in.point();
    if (!p) {
      broken = true;
      break;
    }
    if (path.empty()) {
      path.push_back({*p, {}, closed});
    } else {
      path.back().segments.push_back(line_segment(*p));
    }
  }
  return path;
}

Path rectangle(double x, double y, double width, double height, double rx, double ry) {
  if (!(width > 0 && height > 0)) return {};
  rx = std::clamp(rx, 0.0, width / 2);
  ry = std::clamp(ry, 0.0, height / 2);
  Subpath path;
  path.closed = true;
  path.start = {x + rx, y};
  const auto line = [&](double px, double py) { path.segments.push_back(line_segment({px, py})); };
  const auto corner = [&](double cx, double cy, double from) {
    if (rx > 0 && ry > 0) {
      append_arc(path, {cx, cy}, Eigen::Vector2d(rx, ry).asDiagonal(), from, kPi / 2);
    }
  };
  line(x + width - rx, y);
  corner(x + width - rx, y + ry, -kPi / 2);
  line(x + width, y + height - ry);
  corner(x + width - rx, y + height - ry, 0);
  line(x + rx, y + height);
  corner(x + rx, y + height - ry, kPi / 2);
  line(x, y + ry);
  corner(x + rx, y + ry, kPi);
  return {path};
}

Path ellipse(const Point& centre, double rx, double ry) {
  if (!(rx > 0 && ry > 0)) return {};
  Subpath path;
  path.closed = true;
  path.start = centre + Point(rx, 0);
  append_arc(path, centre, Eigen::Vector2d(rx, ry).asDiagonal(), 0, 2 * kPi);
  path.segments.back().end = path.start;
  return {path};
}

std::optional<Affine> parse_transform(std::string_view text) {
  Affine all = Affine::Identity();
  Scanner in(text);
  while (!in.done()) {
    std::string name;
    while (std::isalpha(static_cast<unsigned char>(in.peek()))) {
      name += in.peek();
      in.drop();
    }
    while (Scanner::blank(in.peek())) in.drop();
    if (in.peek() != '(') return std::nullopt;
    in.drop();
    std::vector<double> v;
    while (in.skip_separators(), in.peek() != ')') {
      const auto value = in.number();
      if (!value || v.size() == 6) return std::nullopt;
      v.push_back(*value);
    }
    in.drop();
    Affine one = Affine::Identity();
    const double angle = v.empty() ? 0 : v[0] * kPi / 180;
    if (name == "matrix" && v.size() == 6) {
      one << v[0], v[2], v[4], v[1], v[3], v[5];
    } else if (name == "translate" && (v.size() == 1 || v.size() == 2)) {
      one.col(2) << v[0], v.size() > 1 ? v[1] : 0.0;
    } else if (name == "scale" && (v.size() == 1 || v.size() == 2)) {
      one(0, 0) = v[0];
      one(1, 1) = v.back();
    } else if (name == "rotate" && (v.size() == 1 || v.size() == 3)) {
      one.leftCols<2>() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
      if (v.size() == 3) {
        const Point centre(v[1], v[2]);
        one.col(2) = centre - one.leftCols<2>() * centre;
      }
    } else if (name == "skewX" && v.size() == 1) {
      one(0, 1) = std::tan(angle);
    } else if (name == "skewY" && v.size() == 1) {
      one(1, 0) = std::tan(angle);
    } else {
      return std::nullopt;
    }
    all = compose(all, one);
  }
  return all;
}

Affine compose(const Affine& outer, const Affine& inner) {
  Affine both;
  both.leftCols<2>() = outer.leftCols<2>() * inner.leftCols<2>();
  both.col(2) = moved(outer, inner.col(2));
  return both;
}

void apply(const Affine& transform, Path& path) {
  for (Subpath& sub : path) {
    sub.start = moved(transform, sub.start);
    for (Segment& s : sub.segments) {
      if (s.curved) s.first = moved(transform, s.first), s.second = moved(transform, s.second);
      s.end = moved(transform, s.end);
    }
  }
}

std::vector<Point> flatten(const Subpath& subpath, double tolerance) {
  std::vector<Point> corners{subpath.start};
  for (const Segment& s : subpath.segments) {
    const Point from = corners.back();
    if (s.curved) {
      // n chords of a cubic leave it by at most 6/8 of its largest second difference over n^2.
      const double bend =
          std::max((from - 2 * s.first + s.second).norm(), (s.first - 2 * s.second + s.end).norm());
      const double wanted = std::ceil(std::sqrt(0.75 * bend / tolerance));
      const int n = wanted >= 1 ? static_cast<int>(std::min<double>(wanted, kMostChords)) : 1;
      for (int k = 1; k < n; ++k) {
        const double t = static_cast<double>(k) / n, u = 1 - t;
        corners.emplace_back(u * u * u * from + 3 * u * u * t * s.first + 3 * u * t * t * s.second +
                             t * t * t * s.end);
      }
    }
    corners.push_back(s.end);
  }
  if (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
  return corners;
}

}  // namespace skinfield::svg
