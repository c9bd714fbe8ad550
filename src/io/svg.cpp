#include "skinfield/io/svg.h"

#include "io/faces.h"
#include "io/svg_path.h"
#include "io/text.h"

#include <pugixml.hpp>

#include <cmath>
#include <set>

namespace skinfield {
namespace {

constexpr double kTolerance = 5e-4;  // of the drawing's diagonal: chords leave curves by less
constexpr int kDeepest = 200;        // groups within groups
constexpr double kLargest = 1e100;   // as asset_from has it

/// What an element takes from its ancestors.
struct Context {
  svg::Affine transform = svg::Affine::Identity();
  bool filled = true;
  int depth = 0;
};

struct Shape {
  std::string name;
  svg::Path path;
  bool filled = true;
};

/// The name without its namespace prefix ("svg:path").
std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

/// A property from the style attribute, which wins, or the attribute of that name.
std::string_view property(const pugi::xml_node& node, std::string_view wanted) {
  std::string_view style = node.attribute("style").value(), found;
  while (!style.empty()) {
    const std::size_t end = std::min(style.find(';'), style.size());
    const std::string_view one = style.substr(0, end);
    style.remove_prefix(std::min(end + 1, style.size()));
    const std::size_t colon = one.find(':');
    if (colon != one.npos && text::trimmed(one.substr(0, colon)) == wanted) {
      found = text::trimmed(one.substr(colon + 1));
    }
  }
  if (!found.empty()) return found;
  return text::trimmed(node.attribute(std::string(wanted).c_str()).value());
}

class Reader {
 public:
  explicit Reader(const std::string& name) : name_(name) {}

  MeshFile read(std::string_view bytes) {
    pugi::xml_document document;
    const pugi::xml_parse_result parsed =
        document.load_buffer(bytes.data(), bytes.size(), pugi::parse_default);
    if (!parsed) {
      throw InputError("the XML cannot be read: " + std::string(parsed.description()),
                       name_ + ":" + std::to_string(line_of(bytes, parsed.offset)),
                       "it is truncated or damaged; export it again");
    }
    const pugi::xml_node root = document.document_element();
    if (local_name(root) != "svg") {
      throw InputError("holds no svg element", name_, "it is no SVG file; name it as what it is");
    }
    visit_children(root, {});
    return finish();
  }

 private:
  static std::size_t line_of(std::string_view bytes, std::ptrdiff_t offset) {
    const auto at =
        std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(bytes.size()));
    return text::line_number(bytes, bytes.data() + at);
  }

  void visit_children(const pugi::xml_node& parent, const Context& context) {
    if (context.depth > kDeepest) {
      throw InputError("groups are nested too deep", name_, "ungroup them");
    }
    for (const pugi::xml_node& node : parent.children()) {
      if (node.type() == pugi::node_element) visit(node, context);
    }
  }

  void visit(const pugi::xml_node& node, Context context) {
    const std::string_view kind = local_name(node);
    static const std::set<std::string_view> definitions{"defs",   "clipPath", "mask", "pattern",
                                                        "marker", "symbol",   "style"};
    if (definitions.contains(kind) || property(node, "display") == "none") return;
    if (const pugi::xml_attribute text = node.attribute("transform")) {
      const auto own = svg::parse_transform(text.value());
      if (!own) {
        throw InputError("the transform " + text::quoted(text.value()) + " cannot be read", name_,
                         "use matrix, translate, scale, rotate, skewX and skewY");
      }
      context.transform = svg::compose(context.transform, *own);
    }
    if (const std::string_view fill = property(node, "fill"); !fill.empty()) {
      context.filled = fill != "none";
    }
    ++context.depth;
    if (kind == "svg") {
      svg::Affine move = svg::Affine::Identity();
      move.col(2) = svg::Point(length(node, "x"), length(node, "y"));
      context.transform = svg::compose(context.transform, move);
    }
    if (kind == "g" || kind == "a" || kind == "svg" || kind == "switch") {
      visit_children(node, context);
    } else if (kind == "text" || kind == "image" || kind == "use" || kind == "foreignObject") {
      ignored_.insert(std::string(kind));
    } else {
      add(node, kind, context);
    }
  }

  /// Coordinates are user units; percentages and units other than px have none here.
  double length(const pugi::xml_node& node, const char* attribute, double otherwise = 0) const {
    std::string_view text = text::trimmed(node.attribute(attribute).value());
    if (text.empty() || text == "auto") return otherwise;
    if (text.ends_with("px")) text.remove_suffix(2);
    const auto value = text::to_number(text);
    if (!value || !std::isfinite(*value)) {
      throw InputError(std::string(attribute) + "=" + text::quoted(text) + " of a " + node.name() +
                           " is not a number",
                       name_, "lengths must be user units");
    }
    return *value;
  }

  void add(const pugi::xml_node& node, std::string_view kind, const Context& context) {
    Shape shape;
    bool broken = false;
    if (kind == "path") {
      shape.path = svg::parse_path(node.attribute("d").value(), broken);
    } else if (kind == "polygon" || kind == "polyline") {
      shape.path = svg::parse_points(node.attribute("points").value(), kind == "polygon", broken);
    } else if (kind == "rect") {
      const double rx = length(node, "rx", -1), ry = length(node, "ry", -1);
      shape.path = svg::rectangle(length(node, "x"), length(node, "y"), length(node, "width"),
                                  length(node, "height"), std::max(rx < 0 ? ry : rx, 0.0),
                                  std::max(ry < 0 ? rx : ry, 0.0));
    } else if (kind == "circle") {
      const double r = length(node, "r");
      shape.path = svg::ellipse({length(node, "cx"), length(node, "cy")}, r, r);
    } else if (kind == "ellipse") {
      const double rx = length(node, "rx", -1), ry = length(node, "ry", -1);
      shape.path = svg::ellipse({length(node, "cx"), length(node, "cy")}, rx < 0 ? ry : rx,
                                ry < 0 ? rx : ry);
    } else {
      return;
    }
    if (broken) {
      warnings_.push_back("a " + std::string(kind) + " is drawn up to an error in it");
    }
    svg::apply(context.transform, shape.path);
    shape.name = node.attribute("id").value();
    shape.filled = context.filled;
    if (!shape.path.empty()) shapes_.push_back(std::move(shape));
  }

  /// Diagonal of the box of all control points, which holds the curves.
  double diagonal_of_drawing() const {
    Eigen::Array2d low = Eigen::Array2d::Constant(1e300), high = -low;
    const auto grow = [&](const svg::Point& p) {
      if (!(p.cwiseAbs().maxCoeff() <= kLargest)) {
        throw InputError("the drawing has coordinates beyond all measure", name_,
                         "positions must be finite; repair the path");
      }
      low = low.min(p.array());
      high = high.max(p.array());
    };
    for (const Shape& shape : shapes_) {
      for (const svg::Subpath& sub : shape.path) {
        grow(sub.start);
        for (const svg::Segment& s : sub.segments) {
          if (s.curved) grow(s.first), grow(s.second);
          grow(s.end);
        }
      }
    }
    return (high - low).matrix().norm();
  }

  MeshFile finish() {
    if (shapes_.empty()) {
      throw InputError("holds no shape", name_, "draw paths, polygons, rects, circles or ellipses");
    }
    const double tolerance = std::max(kTolerance * diagonal_of_drawing(), 1e-300);
    std::vector<double> xyz;
    std::vector<std::int32_t> ends;
    MeshFile mesh;
    int open = 0;
    for (const Shape& shape : shapes_) {
      Part part;
      part.name = shape.name;
      part.begin = static_cast<int>(xyz.size() / 3);
      const int number = static_cast<int>(mesh.parts.size());
      for (const svg::Subpath& sub : shape.path) {
        const bool closed =
            sub.closed || (!sub.segments.empty() && sub.segments.back().end == sub.start);
        if (!closed && !shape.filled) {
          ++open;
          continue;
        }
        const std::vector<svg::Point> corners = svg::flatten(sub, tolerance);
        if (corners.size() < 3) continue;  // encloses nothing
        const auto first = static_cast<std::int32_t>(xyz.size() / 3);
        const auto count = static_cast<std::int32_t>(corners.size());
        for (std::int32_t k = 0; k < count; ++k) {
          const svg::Point& p = corners[static_cast<std::size_t>(k)];
          xyz.insert(xyz.end(), {p.x(), 0.0 - p.y(), 0.0});
          ends.insert(ends.end(), {first + k, first + (k + 1) % count});
          mesh.outline.shape.push_back(number);
        }
      }
      part.end = static_cast<int>(xyz.size() / 3);
      if (part.end > part.begin) mesh.parts.push_back(std::move(part));
    }
    if (open > 0) {
      warnings_.push_back(std::to_string(open) + " open paths without fill are ignored");
    }
    for (const std::string& kind : ignored_) warnings_.push_back(kind + " elements are ignored");
    if (ends.empty()) {
      throw InputError("holds no closed outline", name_, "close the path (Z), or fill it");
    }
    mesh.V = points_from(xyz);
    mesh.outline.E =
        Eigen::Map<const Segments>(ends.data(), static_cast<Eigen::Index>(ends.size() / 2), 2);
    mesh.warnings = std::move(warnings_);
    return mesh;
  }

  const std::string& name_;
  std::vector<Shape> shapes_;
  std::vector<std::string> warnings_;
  std::set<std::string> ignored_;
};

}  // namespace

MeshFile parse_svg(std::string_view bytes, const std::string& name) {
  return Reader(name).read(bytes);
}

}  // namespace skinfield
