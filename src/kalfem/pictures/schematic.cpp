// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/schematic.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "kalfem/base/text.hpp"
#include "kalfem/pictures/schematic_graph.hpp"

namespace kalfem {
namespace {

using Eigen::Vector2d;

constexpr double mass_width = 74.0, mass_height = 22.0;
constexpr double column = 128.0, side = 84.0, above = 22.0, below = 44.0;
constexpr double half_symbol = 11.0;  ///< of a spring beside a dashpot, across
constexpr double beside = 28.0;  ///< between edges that join the same nodes: more than a spring beside a dashpot fills

const char* style =
    "<style>.schematic text{fill:var(--text,#1b2129)}.schematic .quiet{fill:var(--muted,#5b6673)}"
    ".schematic .named{paint-order:stroke;stroke:var(--card,#fff);stroke-width:3.5px;stroke-linejoin:round}"
    ".schematic .mass{fill:var(--card,#fff);stroke:var(--text,#1b2129);stroke-width:1.3}"
    ".schematic .part{stroke:var(--muted,#5b6673);stroke-width:1.3;fill:none}"
    ".schematic .joint{stroke:var(--predicted,#d55e00);stroke-width:1.7;fill:none}"
    ".schematic .sought{stroke-width:2.6}.schematic .sought-name{font-weight:700}"
    ".schematic .sensor,.schematic text .sensor{fill:var(--estimate,#0072b2)}.schematic "
    ".input{fill:var(--limit,#008f68)}"
    ".schematic .link{stroke:var(--line,#c9cfd6);stroke-width:1.3;fill:none;stroke-dasharray:3 3}</style>";

/// A zigzag along x from 0 to `length`, its ends straight.
std::string spring_path(double length, double y) {
  constexpr int teeth = 6;
  const double lead = 0.18 * length, step = (length - 2.0 * lead) / teeth;
  std::string path = fmt::format("M0 {0:.1f}H{1:.1f}", y, lead);
  for (int k = 0; k < teeth; ++k)
    path += fmt::format("L{:.1f} {:.1f}", lead + (k + 0.5) * step, y + (k % 2 == 0 ? -5.0 : 5.0));
  return path + fmt::format("L{:.1f} {:.1f}H{:.1f}", length - lead, y, length);
}

/// A cylinder with its piston.
std::string dashpot_path(double length, double y) {
  const double middle = 0.5 * length, half = std::min(7.0, 0.25 * length);
  return fmt::format(
      "M0 {0:.1f}H{1:.1f}M{2:.1f} {3:.1f}H{1:.1f}V{4:.1f}H{2:.1f}M{5:.1f} {6:.1f}V{7:.1f}M{5:.1f} "
      "{0:.1f}H{8:.1f}",
      y, middle - half, middle + half, y - 5.0, y + 5.0, middle, y - 3.5, y + 3.5, length);
}

class Drawing {
public:
  explicit Drawing(const SchematicGraph& graph)
      : graph_(graph),
        row_(std::clamp(440.0 / std::max(1, graph.layers), 40.0, 84.0)),
        width_(std::max(360.0, 2.0 * side + column * std::max(0.0, graph.widest - 1.0) + mass_width)),
        height_(above + below + row_ * std::max(0, graph.layers - 1) + mass_height) {}

  std::string svg() {
    std::string shapes, joints;
    for (const auto& edge : graph_.edges) {
      ++parallel_[std::minmax(edge.from, edge.to)];
      if (!edge.label.empty()) ++labels_[std::minmax(edge.from, edge.to)];
    }
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) joints += edge(graph_.edges[e]);
    for (const auto& node : graph_.nodes) shapes += this->node(node);
    joints += names_;  // on top of what they name
    return fmt::format(
               "<svg class=\"schematic\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
               "role=\"img\" aria-label=\"{2}\" font-family=\"system-ui, sans-serif\" font-size=\"11.5\" "
               "style=\"max-width:{3:.0f}px\">\n",
               width_, height_, escaped(in_words()), 1.25 * width_) +
           style + joints + shapes + "</svg>";
  }

private:
  [[nodiscard]] Vector2d centre(const SchematicNode& node) const {
    const double middle = 0.5 * (graph_.widest - 1.0);
    return {0.5 * width_ + (node.position - middle) * column, height_ - below - 0.5 * mass_height - row_ * node.layer};
  }

  [[nodiscard]] std::string in_words() const {
    std::vector<std::string> words;
    for (const auto& edge : graph_.edges)
      if (edge.kind == SchematicEdgeKind::connector)
        words.push_back(fmt::format("connector {} from {} to {}", edge.label, graph_.nodes[edge.from].name,
                                    graph_.nodes[edge.to].name));
    for (const auto& node : graph_.nodes)
      for (const auto& sensor : node.sensors) words.push_back(fmt::format("sensor {} at {}", sensor, node.name));
    return fmt::format("The structure: {}", fmt::join(words, ", "));
  }

  /// Where what comes from a place is joined to a node: a rigid body takes it anywhere along its length.
  [[nodiscard]] Vector2d attachment(const SchematicNode& node, const Vector2d& from) const {
    const Vector2d middle = centre(node);
    const double half = 0.5 * node.span * column;
    return {std::clamp(from[0], middle[0] - half, middle[0] + half), middle[1]};
  }

  /// The names of all that joins the same two nodes stand below each other, to the right of the outermost symbol.
  std::string name_beside(const SchematicEdge& edge, const Vector2d& middle) {
    if (edge.label.empty()) return "";
    const auto pair = std::minmax(edge.from, edge.to);
    const bool upright = std::abs(centre(graph_.nodes[edge.from])[1] - centre(graph_.nodes[edge.to])[1]) > 1.0;
    const Vector2d step =
        (attachment(graph_.nodes[edge.to], middle) - attachment(graph_.nodes[edge.from], middle)).cwiseAbs();
    // A symbol that leans reaches further, by its slope, beside the lowest and highest line of the names.
    const double slope = upright ? step[0] / step[1] : 0.0, wider = std::hypot(1.0, slope);
    const double outermost = upright ? (beside * static_cast<double>(parallel_[pair] / 2) + half_symbol) * wider -
                                           half_symbol + slope * (6.5 * labels_[pair] + 2.0)
                                     : -34.0;
    const double line = 13.0 * named_[pair]++, centred = line - 6.5 * (labels_[pair] - 1);
    names_ += name_of(edge, middle + Vector2d(outermost, upright ? centred : line + 18.0));
    return "";
  }

  /// How far the node reaches from its centre in a direction.
  [[nodiscard]] static double reach(const SchematicNode& node, const Vector2d& direction) {
    if (node.kind == SchematicNodeKind::point) return 4.0;
    if (node.kind == SchematicNodeKind::ground) return 0.0;
    const double across = std::abs(direction[0]) > 1e-9 ? 0.5 * mass_width / std::abs(direction[0]) : 1e9;
    const double along = std::abs(direction[1]) > 1e-9 ? 0.5 * mass_height / std::abs(direction[1]) : 1e9;
    return std::min(across, along);
  }

  std::string edge(const SchematicEdge& edge) {
    const auto &from = graph_.nodes[edge.from], &to = graph_.nodes[edge.to];
    const Vector2d a = attachment(from, centre(to)), b = attachment(to, centre(from)), step = b - a;
    if (edge.from == edge.to || step.norm() < 1.0) return "";
    const Vector2d direction = step.normalized(), across(-direction[1], direction[0]);
    const int before = passed_[std::minmax(edge.from, edge.to)]++;
    if (std::abs(from.layer - to.layer) > 1 && edge.kind != SchematicEdgeKind::link) return arc(edge, a, b, before);
    const int places = (before + 1) / 2;  // from the first edge, in turn to either side
    const double shift = (before % 2 == 1 ? 1.0 : -1.0) * beside * places;
    const Vector2d begin = a + direction * reach(from, direction) + shift * across;
    const double length = step.norm() - reach(from, direction) - reach(to, direction);
    const double angle = std::atan2(direction[1], direction[0]) * 180.0 / std::numbers::pi;
    const Vector2d middle = begin + 0.5 * length * direction;
    return fmt::format("<g transform=\"translate({:.1f} {:.1f}) rotate({:.1f})\">{}</g>", begin[0], begin[1], angle,
                       symbol(edge, std::max(length, 4.0))) +
           name_beside(edge, middle - shift * across);
  }

  static std::string symbol(const SchematicEdge& edge, double length) {
    const auto path = [](const std::string& d, const char* kind) {
      return fmt::format("<path class=\"{}\" d=\"{}\"/>", kind, d);
    };
    switch (edge.kind) {
      case SchematicEdgeKind::link:
        return path(fmt::format("M0 0H{:.1f}", length), "link");
      case SchematicEdgeKind::spring:
        return path(spring_path(length, 0.0), "part");
      case SchematicEdgeKind::dashpot:
        return path(dashpot_path(length, 0.0), "part");
      case SchematicEdgeKind::spring_and_dashpot:
        return path(spring_path(length, -6.0) + dashpot_path(length, 6.0), "part");
      case SchematicEdgeKind::connector:
        return path(spring_path(length, -6.0) + dashpot_path(length, 6.0), edge.unknown ? "joint sought" : "joint");
    }
    return "";
  }

  /// Between nodes of layers that are not neighbours: a bow beside what stands between them.
  [[nodiscard]] std::string arc(const SchematicEdge& edge, const Vector2d& a, const Vector2d& b, int before) const {
    const double bow = 0.62 * mass_width + 26.0 + 14.0 * before;
    const Vector2d middle = 0.5 * (a + b) + Vector2d(2.0 * bow, 0.0);
    const bool joins = edge.kind == SchematicEdgeKind::connector;
    return fmt::format("<path class=\"{}{}\" d=\"M{:.1f} {:.1f}Q{:.1f} {:.1f} {:.1f} {:.1f}\"/>",
                       joins ? "joint" : "part", edge.unknown ? " sought" : "", a[0], a[1], middle[0], middle[1], b[0],
                       b[1]) +
           name_of(edge, 0.5 * (a + b) + Vector2d(bow, 0.0));
  }

  [[nodiscard]] static std::string name_of(const SchematicEdge& edge, const Vector2d& middle) {
    if (edge.label.empty()) return "";
    return fmt::format("<text class=\"named{}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                       edge.unknown ? " sought-name" : "", middle[0] + 16.0, middle[1] + 4.0, escaped(edge.label));
  }

  [[nodiscard]] std::string node(const SchematicNode& node) const {
    const Vector2d at = centre(node);
    if (node.kind == SchematicNodeKind::ground) return ground(node, at);
    const double half = node.kind == SchematicNodeKind::point ? 6.0 : 0.5 * (mass_width + column * node.span);
    std::string svg;
    if (node.kind == SchematicNodeKind::point && !joined_above(node)) return point_below_its_names(node, at);
    if (node.kind == SchematicNodeKind::point)
      svg = fmt::format(
          "<circle class=\"mass\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\"/><text class=\"quiet named\" "
          "x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"10\" text-anchor=\"end\">{}</text>",
          at[0], at[1], at[0] - 8.0, at[1] - 5.0, escaped(node.name));
    else
      svg = fmt::format(
          "<rect class=\"mass\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" rx=\"4\"/><text "
          "x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>",
          at[0] - half, at[1] - 0.5 * mass_height, 2.0 * half, mass_height, at[0], at[1] + 4.0,
          escaped(node.span > 0.0 ? node.name : fitted(node.name)));
    return svg + sensors(node, at + Vector2d(half, 0.0)) + forces(node, at - Vector2d(half, 0.0));
  }

  /// Whether a symbol, other than a link, leads from the node to a higher layer.
  [[nodiscard]] bool joined_above(const SchematicNode& node) const {
    return std::ranges::any_of(graph_.edges, [&](const SchematicEdge& edge) {
      const auto &from = graph_.nodes[edge.from], &to = graph_.nodes[edge.to];
      return edge.kind != SchematicEdgeKind::link &&
             ((&from == &node && to.layer > node.layer) || (&to == &node && from.layer > node.layer));
    });
  }

  /// A point with its name and the names of its sensors above it, where no symbol is.
  [[nodiscard]] static std::string point_below_its_names(const SchematicNode& node, const Vector2d& at) {
    std::string svg = fmt::format(
        "<circle class=\"mass\" cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"4\"/><text class=\"quiet named\" x=\"{0:.1f}\" "
        "y=\"{2:.1f}\" font-size=\"10\" text-anchor=\"middle\">{3}</text>",
        at[0], at[1], at[1] - 14.0, escaped(node.name));
    if (!node.sensors.empty())
      svg += fmt::format(
          "<text class=\"named\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\"><tspan class=\"sensor\">▼ "
          "</tspan>{}</text>",
          at[0], at[1] - 26.0, escaped(fmt::format("{}", fmt::join(node.sensors, ", "))));
    return svg + forces(node, at - Vector2d(6.0, 0.0));
  }

  /// A name that fits into a mass; its end tells the parts of one substructure apart.
  static std::string fitted(const std::string& name) {
    constexpr std::size_t most = 11;
    return utf8_characters(name) <= most ? name : "…" + name.substr(name.size() - most + 1);
  }
  static std::size_t utf8_characters(const std::string& text) {
    return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
  }

  static std::string sensors(const SchematicNode& node, const Vector2d& at) {
    if (node.sensors.empty()) return "";
    return fmt::format(
        "<path class=\"sensor\" d=\"M{0:.1f} {1:.1f}l9 -5v10z\"/><text x=\"{2:.1f}\" y=\"{3:.1f}\">"
        "{4}</text>",
        at[0] + 2.0, at[1], at[0] + 14.0, at[1] + 4.0, escaped(fmt::format("{}", fmt::join(node.sensors, ", "))));
  }

  static std::string forces(const SchematicNode& node, const Vector2d& at) {
    if (node.inputs.empty()) return "";
    return fmt::format(
        "<path class=\"input\" d=\"M{0:.1f} {1:.1f}h16v-4l8 5l-8 5v-4h-16z\"/><text x=\"{2:.1f}\" "
        "y=\"{3:.1f}\" text-anchor=\"end\">{4}</text>",
        at[0] - 26.0, at[1] - 1.0, at[0] - 30.0, at[1] + 4.0, escaped(fmt::format("{}", fmt::join(node.inputs, ", "))));
  }

  static std::string ground(const SchematicNode& node, const Vector2d& at) {
    std::string svg = fmt::format("<path class=\"part\" d=\"M{:.1f} {:.1f}h60", at[0] - 30.0, at[1]);
    for (int k = 0; k < 6; ++k) svg += fmt::format("M{:.1f} {:.1f}l-7 8", at[0] - 20.0 + 10.0 * k, at[1]);
    svg += "\"/>";
    if (!node.inputs.empty())
      svg += fmt::format("<path class=\"input\" d=\"M{0:.1f} {1:.1f}l5 7h-3v9h3l-5 7l-5 -7h3v-9h-3z\"/>", at[0] - 42.0,
                         at[1] - 6.0) +
             fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>", at[0], at[1] + 24.0,
                         escaped(fmt::format("{}", fmt::join(node.inputs, ", "))));
    else if (node.name != fixed_ground)
      svg += fmt::format(
          "<text class=\"quiet\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" font-size=\"10\">{}"
          "</text>",
          at[0], at[1] + 22.0, escaped(node.name));
    return svg + sensors(node, at + Vector2d(32.0, 0.0));
  }

  const SchematicGraph& graph_;
  double row_, width_, height_;
  std::map<std::pair<std::size_t, std::size_t>, int> passed_;  ///< edges that were drawn between two nodes
  std::map<std::pair<std::size_t, std::size_t>, int> parallel_, labels_,
      named_;  ///< all of them, those with a name, and names that stand beside them by now
  std::string names_;
};

}  // namespace

std::string schematic_svg(const StructureParts& parts, const std::vector<Sensor>& sensors,
                          const SchematicOptions& options) {
  const auto graph = schematic_graph(parts, sensors, options);
  return graph.nodes.empty() ? "" : Drawing(graph).svg();
}

}  // namespace kalfem
