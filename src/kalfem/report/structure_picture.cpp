// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/study_page.hpp"

#include <map>
#include <set>

#include "kalfem/page/page.hpp"
#include "kalfem/pictures/mesh_picture.hpp"
#include "kalfem/pictures/schematic.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Connectors with a parameter that the filter looks for.
std::vector<std::string> unknown_connectors(const Study& study) {
  std::vector<std::string> names;
  if (!study.augmented_model) return names;
  const auto& connectors = study.augmented_model->model->system().connectors;
  for (const auto& unknown : study.augmented_model->options.unknowns)
    for (const auto& target : unknown.targets)
      if (target.connector >= 0) names.push_back(connectors[static_cast<std::size_t>(target.connector)].name);
  return names;
}

const FiniteElementPart* largest_mesh(const Study& study) {
  const FiniteElementPart* largest = nullptr;
  for (const auto& each : study.structure->finite_elements)
    if (!each.part->elements.mesh.cells.empty() && (!largest || each.part->full.size() > largest->full.size()))
      largest = each.part.get();
  return largest;
}

/// Marks at the named nodes of a part, one a node with all its names.
class NodeMarks {
public:
  explicit NodeMarks(const FiniteElementPart& part) : part_(part) {}

  /// `point`: qualified, "frame.p5.z"; nothing is drawn where it is none of the part's.
  void add(const std::string& point, const std::string& label) {
    for (const auto& named : part_.nodes) {
      const std::string name = part_.name + "." + named.name;
      if (point != name && !(point.starts_with(name) && point[name.size()] == '.')) continue;
      auto& mark = marks_.try_emplace(named.node, PictureMark{MarkKind::point, named.node, ""}).first->second;
      if (labels_.insert({named.node, label}).second) mark.label += (mark.label.empty() ? "" : ", ") + label;
    }
  }

  [[nodiscard]] std::vector<PictureMark> take() const {
    std::vector<PictureMark> all;
    for (const auto& [node, mark] : marks_) all.push_back(mark);
    return all;
  }

private:
  const FiniteElementPart& part_;
  std::map<Index, PictureMark> marks_;
  std::set<std::pair<Index, std::string>> labels_;
};

Picture mesh_picture(const Study& study, const FiniteElementPart& part) {
  NodeMarks marks(part);
  for (const auto& sensor : study.sensors)
    for (const auto& [point, weight] : sensor.output.points)
      if (weight != 0.0) marks.add(point, sensor.name);
  for (const auto& connector : study.structure->parts.connectors)
    for (const auto& end : {connector.from, connector.to}) marks.add(end, connector.name);
  for (const auto& input : study.structure->parts.inputs) marks.add(input.target, input.name);
  return {.title = "The structure: " + part.name,
          .caption = "Rings: sensors, excitations and ends of connectors.",
          .svg = mesh_picture_svg(part.elements, {.width = 620, .height = 440, .marks = marks.take()}),
          .half_width = true};
}

}  // namespace

std::optional<Picture> structure_picture(const Study& study) {
  if (const auto* part = largest_mesh(study)) return mesh_picture(study, *part);
  return schematic_picture(study);
}

std::optional<Picture> schematic_picture(const Study& study) {
  auto svg = schematic_svg(study.structure->parts, study.sensors, {.unknown_connectors = unknown_connectors(study)});
  if (svg.empty()) return std::nullopt;
  return Picture{.title = "The structure",
                 .caption = "Triangles: sensors. Arrows: excitations. Bold: what is looked for.",
                 .svg = std::move(svg),
                 .half_width = true};
}

}  // namespace kalfem
