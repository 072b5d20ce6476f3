// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/mesh_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "kalfem/base/natural_order.hpp"
#include "kalfem/base/text.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double margin = 28.0, row_height = 21.0, line_width = 2.6;
constexpr std::size_t most_legend_rows = 18, most_with_lines = 6000, most_marks = 400;
constexpr double hidden_by = 4.0;  ///< pixels
constexpr double crease = 0.82;    ///< cosine of the angle above which an edge is drawn

struct Colour {
  double red, green, blue;
};

constexpr Colour pale = {0xd3, 0xd8, 0xdd};
constexpr std::array<Colour, 10> palette = {{{0x6f, 0x9b, 0xc8},
                                             {0xd8, 0xa1, 0x5d},
                                             {0x74, 0xb4, 0x8f},
                                             {0xc4, 0x86, 0x93},
                                             {0x9a, 0x8d, 0xc6},
                                             {0x5f, 0xb0, 0xb7},
                                             {0xc7, 0xb6, 0x57},
                                             {0xae, 0x8b, 0x70},
                                             {0x8f, 0xa0, 0xad},
                                             {0xd0, 0x87, 0x6a}}};

/// "#rrggbb".
Colour parsed(const std::string& text) {
  const auto channel = [&](std::size_t from) {
    return static_cast<double>(std::stoi(text.substr(from, 2), nullptr, 16));
  };
  return {channel(1), channel(3), channel(5)};
}

/// Darker below 1, lighter above.
std::string shaded(const Colour& colour, double factor) {
  const auto channel = [&](double value) {
    const double shade = factor <= 1.0 ? value * factor : value + (255.0 - value) * (factor - 1.0);
    return static_cast<int>(std::lround(std::clamp(shade, 0.0, 255.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(colour.red), channel(colour.green), channel(colour.blue));
}

/// At most 28 bytes, without cutting a character of several bytes in two.
std::string shortened(const std::string& name) {
  if (name.size() <= 28) return name;
  std::size_t end = 25;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) --end;
  return name.substr(0, end) + "...";
}

/// Pixels to a tenth, as short as they can be written.
std::string pixel(double value) {
  const auto tenths = std::lround(10.0 * value);
  return tenths % 10 == 0 ? fmt::format("{}", tenths / 10) : fmt::format("{:.1f}", static_cast<double>(tenths) / 10.0);
}

std::string at(const Vector3d& corner) { return pixel(corner[0]) + " " + pixel(corner[1]); }

/// Parallel projection: x to the right, y down, depth away from the eye.
struct View {
  Eigen::Matrix3d axes;  ///< rows: right, down, away
  double scale = 1.0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  View(double azimuth, double elevation) {
    const double a = azimuth * std::numbers::pi / 180.0, e = elevation * std::numbers::pi / 180.0;
    const Vector3d eye(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
    const Vector3d right(-std::sin(a), std::cos(a), 0.0);
    axes << right.transpose(), -eye.cross(right).transpose(), -eye.transpose();
  }

  [[nodiscard]] Vector3d project(const Vector3d& place) const {
    Vector3d seen = scale * (axes * place);
    seen.head<2>() += shift;
    return seen;
  }

  /// Fits places into a rectangle of the screen.
  void fit(const Eigen::Matrix3Xd& places, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const Eigen::Matrix3Xd seen = axes * places;
    const Eigen::Vector2d low = seen.topRows<2>().rowwise().minCoeff(), high = seen.topRows<2>().rowwise().maxCoeff();
    const Eigen::Vector2d room = to - from, size = (high - low).cwiseMax(1e-300);
    scale = (room.array() / size.array()).minCoeff();
    const double extent = (places.rowwise().maxCoeff() - places.rowwise().minCoeff()).norm();
    scale =
        std::min(scale, room.maxCoeff() / std::max(extent, 1e-300) * 4.0);  // one point, or a line seen from its end
    if (!std::isfinite(scale)) scale = 1.0;
    shift = 0.5 * (from + to) - scale * 0.5 * (low + high);
  }
};

Vector3d normal_of(const Eigen::Matrix3Xd& places, const DrawnFace& face) {
  const auto corner = [&](int i) { return places.col(face.nodes[static_cast<std::size_t>(i)]); };
  const Vector3d normal = face.count == 4 ? Vector3d((corner(2) - corner(0)).cross(corner(3) - corner(1)))
                                          : Vector3d((corner(1) - corner(0)).cross(corner(2) - corner(0)));
  return normal.stableNormalized();
}

/// Edges at which a surface ends, turns sharply or changes its region.
class Creases {
public:
  explicit Creases(const DrawnSurface& surface) : surface_(surface) {
    normals_.reserve(surface.faces.size());
    for (std::size_t i = 0; i < surface.faces.size(); ++i) {
      const auto& face = surface.faces[i];
      normals_.push_back(face.count < 3 ? Vector3d::Zero() : normal_of(surface.places, face));
      for (int k = 0; face.count >= 3 && k < face.count; ++k) edges_[edge(face, k)].push_back(i);
    }
  }

  [[nodiscard]] const Vector3d& normal(std::size_t face) const { return normals_[face]; }

  [[nodiscard]] bool is_crease(const DrawnFace& face, int k) const {
    const auto& beside = edges_.at(edge(face, k));
    if (beside.size() != 2) return true;
    return surface_.faces[beside[0]].region != surface_.faces[beside[1]].region ||
           std::abs(normals_[beside[0]].dot(normals_[beside[1]])) < crease;
  }

private:
  static std::pair<Index, Index> edge(const DrawnFace& face, int k) {
    return std::minmax(face.nodes[static_cast<std::size_t>(k)],
                       face.nodes[static_cast<std::size_t>((k + 1) % face.count)]);
  }

  const DrawnSurface& surface_;
  std::vector<Vector3d> normals_;
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> edges_;
};

/// Corners on the screen; a line becomes a ribbon.
ScreenPolygon on_screen(const DrawnSurface& surface, const DrawnFace& face, const View& view) {
  ScreenPolygon polygon{Eigen::Matrix3Xd(3, face.count)};
  for (int i = 0; i < face.count; ++i)
    polygon.corners.col(i) = view.project(surface.places.col(face.nodes[static_cast<std::size_t>(i)]));
  if (face.count != 2) return polygon;
  const Vector3d a = polygon.corners.col(0), b = polygon.corners.col(1);
  Vector3d across(a[1] - b[1], b[0] - a[0], 0.0);
  across *= 0.5 * line_width / std::max(across.norm(), 1e-9);
  polygon.corners.resize(3, 4);
  polygon.corners << a + across, b + across, b - across, a - across;
  polygon.corners.row(2).array() -= line_width;  // lies on the surface that it stiffens
  return polygon;
}

/// Writes the parts of a picture.
class Painter {
public:
  Painter(const Mesh& mesh, const MeshPictureOptions& options, std::vector<std::string> regions)
      : mesh_(mesh), options_(options), regions_(std::move(regions)), view_(options.azimuth, options.elevation) {}

  std::string run() {
    auto faces = outer_faces(mesh_, regions_);
    open();
    fit(faces);
    const DrawnSurface all{mesh_.nodes, std::move(faces), false};
    auto visible = visible_faces(all);
    const DrawnSurface surface =
        visible.size() <= options_.most_faces
            ? DrawnSurface{mesh_.nodes, std::move(visible), false}
            : coarsened(mesh_.nodes, std::move(visible), shape_weights(mesh_.nodes, all.faces), options_.most_faces);
    if (surface.faces.empty()) {
      text(0.5 * options_.width, 0.5 * options_.height, "nothing to draw", " text-anchor=\"middle\"");
    } else {
      draw_surface(surface);
      draw_links();
      draw_marks();
      draw_axes();
      draw_scale();
    }
    draw_legend(all);
    out_ += "</svg>\n";
    return std::move(out_);
  }

private:
  void open() {
    out_ += fmt::format(
        "<svg class=\"mesh-picture\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
        "height=\"{1}\" role=\"img\" aria-label=\"The mesh\" font-family=\"system-ui, sans-serif\" font-size=\"13\">\n"
        "<style>.mesh-picture{{color:#1b2129;--halo:#fff;max-width:100%;height:auto}}"
        "@media screen and (prefers-color-scheme:dark){{.mesh-picture{{color:#e6eaee;--halo:#12161b}}}}"
        ".mesh-picture text{{fill:currentColor}}"
        ".mesh-picture "
        ".label{{paint-order:stroke;stroke:var(--halo);stroke-width:3px;stroke-linejoin:round}}</style>\n",
        options_.width, options_.height);
  }

  void text(double x, double y, const std::string& content, const std::string& attributes = {}) {
    out_ += fmt::format("<text x=\"{}\" y=\"{}\"{}>{}</text>\n", pixel(x), pixel(y), attributes, escaped(content));
  }

  [[nodiscard]] Colour colour_of(int region) const {
    if (!options_.region_colours.empty()) return parsed(options_.region_colours[static_cast<std::size_t>(region)]);
    return options_.plain ? pale : palette[static_cast<std::size_t>(region) % palette.size()];
  }

  [[nodiscard]] double legend_width() const {
    std::size_t longest = options_.candidate_colours.empty() ? 8 : 15;
    if (options_.plain) return 34.0 + 7.2 * static_cast<double>(longest);
    for (std::size_t i = 0; i < std::min(regions_.size(), most_legend_rows); ++i)
      longest = std::max(longest, std::min<std::size_t>(regions_[i].size(), 28));
    return 34.0 + 7.2 * static_cast<double>(longest);
  }

  void fit(const std::vector<DrawnFace>& faces) {
    if (faces.empty()) return;
    std::vector<bool> used(static_cast<std::size_t>(mesh_.node_count()), false);
    for (const auto& face : faces)
      for (int i = 0; i < face.count; ++i)
        used[static_cast<std::size_t>(face.nodes[static_cast<std::size_t>(i)])] = true;
    for (const auto& mark : options_.marks) used[static_cast<std::size_t>(mark.node)] = true;
    Eigen::Matrix3Xd places(3, std::ranges::count(used, true));
    for (Index node = 0, column = 0; node < mesh_.node_count(); ++node)
      if (used[static_cast<std::size_t>(node)]) places.col(column++) = mesh_.nodes.col(node);
    view_.fit(places, {margin, margin},
              {options_.width - 2.0 * margin - legend_width(), options_.height - 2.4 * margin});
  }

  [[nodiscard]] std::vector<ScreenPolygon> polygons_of(const DrawnSurface& surface) const {
    std::vector<ScreenPolygon> polygons;
    polygons.reserve(surface.faces.size());
    for (const auto& face : surface.faces) polygons.push_back(on_screen(surface, face, view_));
    return polygons;
  }

  /// Also keeps what is nearest at each pixel, for the symbols.
  std::vector<DrawnFace> visible_faces(const DrawnSurface& all) {
    depth_ = screen_depth(polygons_of(all), options_.width, options_.height);
    std::vector<DrawnFace> faces;
    for (std::size_t i = 0; i < all.faces.size(); ++i)
      if (depth_.visible[i]) faces.push_back(all.faces[i]);
    return faces;
  }

  void draw_surface(const DrawnSurface& surface) {
    const Creases creases(surface);
    const auto polygons = polygons_of(surface);
    const bool with_lines = surface.faces.size() <= most_with_lines && !surface.coarsened;
    out_ += "<g stroke-linejoin=\"round\" stroke-linecap=\"round\" stroke-width=\".6\">\n";
    for (const auto i : painters_order(polygons, screen_depth(polygons, options_.width, options_.height))) {
      const auto& face = surface.faces[i];
      if (face.count == 2)
        draw_line(face, polygons[i]);
      else
        draw_face(face, polygons[i], creases, i, with_lines);
    }
    out_ += "</g>\n";
  }

  void draw_line(const DrawnFace& face, const ScreenPolygon& ribbon) {
    const Vector3d a = 0.5 * (ribbon.corners.col(0) + ribbon.corners.col(3)),
                   b = 0.5 * (ribbon.corners.col(1) + ribbon.corners.col(2));
    out_ += fmt::format("<path d=\"M{}L{}\" stroke=\"{}\" stroke-width=\"{}\"/>\n", at(a), at(b),
                        shaded(colour_of(face.region), 0.9), line_width);
  }

  void draw_face(const DrawnFace& face, const ScreenPolygon& polygon, const Creases& creases, std::size_t index,
                 bool with_lines) {
    Vector3d normal = view_.axes * creases.normal(index);
    if (normal[2] > 0.0) normal = -normal;  // towards the eye
    const Vector3d light = Vector3d(-0.45, -0.72, -0.53).normalized();
    const double shade = 0.62 + 0.56 * std::max(0.0, normal.dot(light));
    const Colour colour = colour_of(face.region);
    const std::string fill = shaded(colour, shade);
    std::string d, edges;
    for (int k = 0; k < face.count; ++k) {
      const Vector3d from = polygon.corners.col(k), to = polygon.corners.col((k + 1) % face.count);
      d += (k == 0 ? "M" : "L") + at(from);
      if (creases.is_crease(face, k)) edges += "M" + at(from) + "L" + at(to);
    }
    out_ += fmt::format("<path d=\"{}z\" fill=\"{}\" stroke=\"{}\"/>\n", d, fill,
                        with_lines ? shaded(colour, 0.86 * std::min(shade, 1.0)) : fill);
    if (!edges.empty())
      out_ += fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-width=\".9\"/>\n", edges, shaded(colour, 0.5));
  }

  void draw_links() {
    if (options_.links.empty()) return;
    out_ +=
        "<path fill=\"none\" stroke=\"currentColor\" stroke-opacity=\".55\" stroke-width=\"1\" stroke-dasharray=\"3 "
        "2.5\" d=\"";
    const std::size_t step = 1 + options_.links.size() / most_marks;
    for (std::size_t i = 0; i < options_.links.size(); i += step)
      out_ += "M" + at(view_.project(mesh_.nodes.col(options_.links[i].first))) + "L" +
              at(view_.project(mesh_.nodes.col(options_.links[i].second)));
    out_ += "\"/>\n";
  }

  /// `own`: the colour of a candidate or a chosen one.
  static std::string symbol(MarkKind kind, double x, double y, const std::string& own = "#d7191c") {
    const auto p = [&](double dx, double dy) { return pixel(x + dx) + " " + pixel(y + dy); };
    const std::string outline = " stroke=\"var(--halo)\" stroke-width=\"1.2\"";
    switch (kind) {
      case MarkKind::mass:
        return fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"5\" fill=\"#c07f14\"{}/>\n", pixel(x), pixel(y), outline);
      case MarkKind::support:
        return fmt::format("<path d=\"M{}L{}L{}z\" fill=\"currentColor\"{}/>\n", p(0, 0), p(5, 9), p(-5, 9), outline);
      case MarkKind::spring:
        return fmt::format("<path d=\"M{}L{}L{}L{}z\" fill=\"#2f7d5b\"{}/>\n", p(0, -5), p(5, 0), p(0, 5), p(-5, 0),
                           outline);
      case MarkKind::point:
        return fmt::format(
            "<circle cx=\"{}\" cy=\"{}\" r=\"4.2\" fill=\"var(--halo)\" stroke=\"#c0392b\" "
            "stroke-width=\"2\"/>\n",
            pixel(x), pixel(y));
      case MarkKind::finding:
        return fmt::format("<path d=\"M{}L{}M{}L{}\" stroke=\"#d4281c\" stroke-width=\"2.2\" fill=\"none\"/>\n",
                           p(-4, -4), p(4, 4), p(-4, 4), p(4, -4));
      case MarkKind::candidate:
        return fmt::format(
            "<circle cx=\"{}\" cy=\"{}\" r=\"4.2\" fill=\"{}\" stroke=\"#3a424b\" stroke-width=\".7\"/>\n", pixel(x),
            pixel(y), own);
      case MarkKind::chosen:
        return fmt::format(
            "<circle cx=\"{0}\" cy=\"{1}\" r=\"9.5\" fill=\"var(--halo)\" stroke=\"currentColor\" "
            "stroke-width=\"2.2\"/>\n<circle cx=\"{0}\" cy=\"{1}\" r=\"6\" fill=\"{2}\"/>\n",
            pixel(x), pixel(y), own);
    }
    return "";
  }

  void draw_marks() {
    std::set<std::tuple<int, long, long>> taken;  // boxes that hold a symbol of the kind
    std::set<std::pair<long, long>> labelled;
    std::map<MarkKind, std::size_t> drawn;
    std::string labels, above;
    int drawn_labels = 0;  // of chosen ones
    for (const auto& mark : options_.marks) {
      const Vector3d place = view_.project(mesh_.nodes.col(mark.node));
      const bool room =
          taken.insert({static_cast<int>(mark.kind), std::lround(place[0] / 9.0), std::lround(place[1] / 9.0)}).second;
      if (!room || ++drawn[mark.kind] > most_marks) continue;
      const bool hidden = depth_.at(place[0], place[1]) < place[2] - hidden_by;
      const char* opacity = mark.kind == MarkKind::chosen ? ".65" : ".3";
      const std::string drawn_symbol = symbol(mark.kind, place[0], place[1], mark.colour);
      std::string& layer = mark.kind == MarkKind::chosen ? above : out_;
      layer += hidden ? fmt::format("<g opacity=\"{}\">", opacity) + drawn_symbol + "</g>\n" : drawn_symbol;
      if (mark.label.empty() || !labelled.insert({std::lround(place[0] / 44.0), std::lround(place[1] / 15.0)}).second)
        continue;
      const bool chosen = mark.kind == MarkKind::chosen;
      const double down = chosen ? (++drawn_labels % 2 == 0 ? 23.0 : -11.0) : -6.0;  // in turn: they may be neighbours
      labels += fmt::format("<text class=\"label\" x=\"{}\" y=\"{}\"{}>{}</text>\n", pixel(place[0] + 8.0),
                            pixel(place[1] + down), chosen ? " font-weight=\"700\"" : "", escaped(mark.label));
    }
    out_ += above + labels;
  }

  void draw_axes() {
    constexpr double length = 34.0;
    constexpr std::array colours = {"#c8553d", "#3f8f5f", "#3f7fbf"};
    constexpr std::array names = {"x", "y", "z"};
    const double x0 = margin + length, y0 = options_.height - margin - 0.6 * length;
    std::array<int, 3> order = {0, 1, 2};
    std::ranges::sort(order, std::greater{}, [&](int axis) { return view_.axes(2, axis); });  // the farthest first
    for (const int axis : order) {
      const double x = x0 + length * view_.axes(0, axis), y = y0 + length * view_.axes(1, axis);
      const auto* colour = colours[static_cast<std::size_t>(axis)];
      out_ += fmt::format("<path d=\"M{} {}L{} {}\" stroke=\"{}\" stroke-width=\"2\" stroke-linecap=\"round\"/>\n",
                          pixel(x0), pixel(y0), pixel(x), pixel(y), colour);
      text(x0 + (length + 9.0) * view_.axes(0, axis), y0 + (length + 9.0) * view_.axes(1, axis) + 4.0,
           names[static_cast<std::size_t>(axis)], " text-anchor=\"middle\" font-weight=\"600\"");
    }
  }

  /// A bar of a round length, of at most 130 pixels.
  void draw_scale() {
    const double longest = 130.0 / view_.scale;
    double length = std::pow(10.0, std::floor(std::log10(longest)));
    for (const double factor : {5.0, 2.0})
      if (factor * length <= longest) {
        length *= factor;
        break;
      }
    const double right = options_.width - margin, left = right - length * view_.scale, y = options_.height - margin;
    out_ += fmt::format("<path d=\"M{0} {2}V{3}M{0} {4}H{1}M{1} {2}V{3}\" stroke=\"currentColor\" fill=\"none\"/>\n",
                        pixel(left), pixel(right), pixel(y - 4.0), pixel(y + 4.0), pixel(y));
    text(0.5 * (left + right), y - 9.0, fmt::format("{:g} m", length), " text-anchor=\"middle\"");
  }

  void draw_legend(const DrawnSurface& surface) {
    std::set<int> seen, lines;
    for (const auto& face : surface.faces) (face.count == 2 ? lines : seen).insert(face.region);
    const double x = options_.width - margin - legend_width() + 10.0;
    double y = margin + 6.0;
    std::size_t rows = 0;
    for (std::size_t r = 0; r < regions_.size() && rows < most_legend_rows && !options_.plain; ++r) {
      const int region = static_cast<int>(r);
      if (!seen.contains(region) && !lines.contains(region)) continue;
      const std::string colour = shaded(colour_of(region), 0.97);
      out_ += seen.contains(region)
                  ? fmt::format("<rect x=\"{}\" y=\"{}\" width=\"14\" height=\"12\" rx=\"3\" fill=\"{}\"/>\n", pixel(x),
                                pixel(y - 6.0), colour)
                  : fmt::format("<path d=\"M{0} {1}h14\" stroke=\"{2}\" stroke-width=\"3\"/>\n", pixel(x), pixel(y),
                                colour);
      text(x + 21.0, y + 4.5, shortened(regions_[r]));
      y += row_height;
      ++rows;
    }
    if (regions_.size() > most_legend_rows && !options_.plain)
      text(x + 21.0, y + 4.5, fmt::format("and {} more", regions_.size() - most_legend_rows)), y += row_height;
    y += 6.0;
    for (const auto& [kind, name] : {std::pair{MarkKind::mass, "mass"},
                                     {MarkKind::support, "support"},
                                     {MarkKind::spring, "spring"},
                                     {MarkKind::point, "point"},
                                     {MarkKind::finding, "finding"},
                                     {MarkKind::chosen, "chosen"}}) {
      if (std::ranges::none_of(options_.marks, [&](const auto& mark) { return mark.kind == kind; })) continue;
      out_ += symbol(kind, x + 7.0, kind == MarkKind::support ? y - 4.5 : y);
      text(x + 21.0, y + 4.5, name);
      y += row_height;
    }
    draw_candidate_legend(x, y);
    if (options_.links.empty()) return;
    out_ += fmt::format(
        "<path d=\"M{} {}h16\" stroke=\"currentColor\" stroke-opacity=\".55\" stroke-dasharray=\"3 2.5\"/>\n",
        pixel(x - 1.0), pixel(y));
    text(x + 21.0, y + 4.5, "link");
  }

  /// One disc a colour below each other, the ends in words.
  void draw_candidate_legend(double x, double& y) {
    const auto& colours = options_.candidate_colours;
    for (std::size_t i = 0; i < colours.size(); ++i) {
      out_ += symbol(MarkKind::candidate, x + 7.0, y, colours[i]);
      if (i == 0) text(x + 21.0, y + 4.5, "best alone");
      if (i + 1 == colours.size()) text(x + 21.0, y + 4.5, "worst alone");
      y += i + 1 < colours.size() ? 0.7 * row_height : row_height;
    }
  }

  const Mesh& mesh_;
  const MeshPictureOptions& options_;
  std::vector<std::string> regions_;
  View view_;
  ScreenDepth depth_;
  std::string out_;
};

std::vector<std::string> drawable_regions(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const auto& [region, cells] : mesh.regions)
    if (std::ranges::any_of(cells,
                            [&](auto cell) { return dimension(mesh.cells[static_cast<std::size_t>(cell)].shape) > 0; }))
      names.push_back(region);
  return in_natural_order(std::move(names));
}

}  // namespace

std::string region_colour(std::size_t region) { return shaded(palette[region % palette.size()], 1.0); }

std::vector<std::string> drawn_regions(const FiniteElementModel& model) {
  std::vector<std::string> names;
  for (const auto& [region, property] : model.properties)
    if (model.mesh.regions.contains(region)) names.push_back(region);
  return in_natural_order(std::move(names));
}

std::string mesh_picture_svg(const Mesh& mesh, const MeshPictureOptions& options) {
  return Painter(mesh, options, options.regions.empty() ? drawable_regions(mesh) : options.regions).run();
}

std::string mesh_picture_svg(const FiniteElementModel& model, MeshPictureOptions options) {
  if (options.regions.empty()) options.regions = drawn_regions(model);
  std::vector<PictureMark> marks;
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes) marks.push_back({MarkKind::support, node});
  for (const auto& spring : model.springs) marks.push_back({MarkKind::spring, spring.from.node});
  for (const auto& joint : model.joints)
    if (!joint.deformation.empty()) marks.push_back({MarkKind::spring, joint.deformation.front().first.node});
  for (const auto& mass : model.masses) marks.push_back({MarkKind::mass, mass.node});
  marks.insert(marks.end(), options.marks.begin(), options.marks.end());
  options.marks = std::move(marks);
  for (const auto& link : model.links)
    for (const auto slave : link.slaves) options.links.emplace_back(link.master, slave);
  for (const auto& link : model.weighted_links)
    for (const auto& share : link.shares) options.links.emplace_back(link.follower, share.node);
  return mesh_picture_svg(model.mesh, options);
}

}  // namespace kalfem
