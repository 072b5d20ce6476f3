// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/modes/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "kalfem/pictures/mesh_picture.hpp"
#include "kalfem/pictures/nodal_translations.hpp"
#include "kalfem/pictures/scene_places.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/modes/measured_shapes.hpp"
#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/study/candidate_nodes.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;

constexpr std::size_t most_modes = 40, most_unlabelled_marks = 150, most_links = 600;
constexpr Index most_frames = 400;                  ///< of a motion
constexpr Index most_shape_places = 500000;         ///< shapes of a motion times places, to keep pages small ...
constexpr Index few_shapes = 12, many_shapes = 40;  ///< ... but no fewer shapes than these, and no more

/// Everything that stands on a part, by its node.
class Marks {
public:
  Marks(const FiniteElementPart& part, ScenePlaces& places) : part_(part), places_(places) {}

  void add(SceneMarkKind kind, Index node, const std::string& label = "") {
    auto& labels = labels_[{kind, node}];
    if (!label.empty() && std::ranges::find(labels, label) == labels.end()) labels.push_back(label);
  }

  /// The node of "frame.p5.z"; nothing of another substructure, and of a place that is no single node.
  [[nodiscard]] std::optional<Index> node_of(const std::string& point) const {
    if (!point.starts_with(part_.name + ".")) return std::nullopt;
    const auto found = candidate_nodes(part_, point.substr(part_.name.size() + 1), 0.0);
    return found && !found->of_region && found->nodes.size() == 1 ? std::optional(found->nodes.front()) : std::nullopt;
  }

  void add_at(SceneMarkKind kind, const std::string& point, const std::string& label) {
    if (const auto node = node_of(point)) add(kind, *node, label);
  }

  /// Marks of one kind on one node are one; of many without a label some are left out.
  [[nodiscard]] std::vector<SceneMark> list() const {
    std::map<SceneMarkKind, std::size_t> unlabelled;
    for (const auto& [at, labels] : labels_) unlabelled[at.first] += labels.empty() ? 1 : 0;
    std::map<SceneMarkKind, std::size_t> seen;
    std::vector<SceneMark> marks;
    for (const auto& [at, labels] : labels_) {
      const auto every = unlabelled[at.first] / most_unlabelled_marks + 1;
      if (labels.empty() && seen[at.first]++ % every != 0) continue;
      marks.push_back({at.first, places_.of(at.second), fmt::format("{}", fmt::join(labels, ", "))});
    }
    return marks;
  }

private:
  const FiniteElementPart& part_;
  ScenePlaces& places_;
  std::map<std::pair<SceneMarkKind, Index>, std::vector<std::string>> labels_;
};

void mark_elements(const FiniteElementModel& elements, Marks& marks) {
  for (const auto& support : elements.fixed)
    for (const auto node : support.nodes) marks.add(SceneMarkKind::support, node);
  for (const auto& mass : elements.masses) marks.add(SceneMarkKind::mass, mass.node, mass.name);
  for (const auto& spring : elements.springs)
    if (!spring.to) marks.add(SceneMarkKind::spring, spring.from.node);
}

void mark_study(const Study& study, const FiniteElementPart& part, Marks& marks) {
  for (const auto& sensor : study.sensors)
    for (const auto& [point, factor] : sensor.output.points) marks.add_at(SceneMarkKind::sensor, point, sensor.name);
  for (const auto& input : study.structure->parts.inputs)
    if (input.kind == InputKind::force) marks.add_at(SceneMarkKind::input, input.target, input.name);
  for (const auto& point : part.boundary)
    if (const auto node = marks.node_of(part.name + "." + point))
      marks.add(SceneMarkKind::boundary, *node, name_of_node(part, *node));
}

/// Links and springs of the elements, and connectors between two points of the part; of the others the end is marked.
std::vector<SceneLine> lines_of(const Study& study, const FiniteElementPart& part, ScenePlaces& places, Marks& marks) {
  std::vector<SceneLine> lines;
  const auto add = [&](SceneLineKind kind, Index from, Index to) {
    if (from != to && lines.size() < most_links) lines.push_back({kind, places.of(from), places.of(to)});
  };
  for (const auto& connector : study.structure->parts.connectors) {
    const auto from = marks.node_of(connector.from), to = marks.node_of(connector.to);
    if (from && to) add(SceneLineKind::connector, *from, *to);
    if (from) marks.add(SceneMarkKind::connector, *from, connector.name);
    if (to) marks.add(SceneMarkKind::connector, *to, connector.name);
  }
  for (const auto& spring : part.elements.springs)
    if (spring.to) add(SceneLineKind::connector, spring.from.node, spring.to->node);
  for (const auto& link : part.elements.links)
    for (const auto slave : link.slaves) add(SceneLineKind::link, link.master, slave);
  for (const auto& link : part.elements.weighted_links)
    for (const auto& share : link.shares) add(SceneLineKind::link, link.follower, share.node);
  return lines;
}

/// Translations of the places, x, y and z of one after the other.
Eigen::VectorXd at_places(const FiniteElementPart& part, const SparseMatrix& averaging,
                          const Eigen::VectorXd& displacement) {
  const Matrix3Xd translations = nodal_translations(part, displacement) * averaging;
  return translations.reshaped();
}

/// `label`: which model they are of, where the scene has those of two.
void add_modes(const FiniteElementPart& part, const std::string& label, const SubstructureModes& modes,
               const SparseMatrix& averaging, Scene& scene) {
  for (Index i = 0; i < std::min<Index>(modes.frequencies.size(), most_modes); ++i)
    scene.fields.push_back({fmt::format("{}mode {}: {:.2f} Hz", label, i + 1, modes.frequencies[i]),
                            at_places(part, averaging, modes.shapes.col(i))});
}

/// "estimated motion" of the series "frame_estimated", at no more times than a reader can tell apart.
void add_motion(const FiniteElementPart& part, const FieldSeries& series, const SparseMatrix& averaging, Scene& scene) {
  const auto times = static_cast<Index>(series.times.size());
  if (times < 2) return;
  const Index every = (times - 1) / most_frames + 1;
  std::vector<double> kept;
  MatrixXd motion(3 * averaging.cols(), (times - 1) / every + 1);
  for (Index k = 0; k < times; k += every) {
    motion.col(k / every) = at_places(part, averaging, series.displacement.col(k));
    kept.push_back(series.times[static_cast<std::size_t>(k)]);
  }
  const Index shapes = std::clamp(most_shape_places / averaging.cols(), few_shapes, many_shapes);
  scene.fields.push_back(motion_field(series.name.substr(part.name.size() + 1) + " motion", kept, motion, shapes));
}

/// Shapes of one comparison over those of the model: each measured node is a place that moves, with a line from where
/// it rests.
void add_measured(const FiniteElementPart& part, const MeasuredShapes& shapes, const SubstructureModes& modes,
                  const SparseMatrix& averaging, Scene& scene) {
  if (shapes.pairs.empty()) return;
  const Index before = scene.places.cols(), count = std::ssize(shapes.nodes);
  scene.places.conservativeResize(3, before + 2 * count);
  for (Index i = 0; i < count; ++i) {
    const Index rest = before + i, moving = before + count + i;
    scene.places.col(rest) = scene.places.col(moving) =
        part.elements.mesh.nodes.col(shapes.nodes[static_cast<std::size_t>(i)]);
    scene.lines.push_back({SceneLineKind::measured, rest, moving});
    scene.marks.push_back({SceneMarkKind::measured, moving, ""});
  }
  std::vector<SceneField> fields;
  for (const auto& pair : shapes.pairs) {
    MatrixXd shape = MatrixXd::Zero(3 * scene.places.cols(), 1);
    shape.topRows(3 * averaging.cols()) = at_places(part, averaging, modes.shapes.col(pair.mode));
    shape.bottomRows(3 * count) = pair.displacement.reshaped();
    fields.push_back({.name = pair.name, .shapes = std::move(shape), .measured = true});
  }
  scene.fields.insert(scene.fields.begin(), std::make_move_iterator(fields.begin()),
                      std::make_move_iterator(fields.end()));
}

/// The measured shapes of every comparison with the part, over the model at the values that they were paired at.
void add_correlation(const StudyResults& results, const FiniteElementPart& part, const SparseMatrix& averaging,
                     Scene& scene) {
  const auto* correlation = results.find<CorrelationOutcome>();
  if (!correlation) return;
  const auto* modes = correlation->updated ? updated_modes_of(results, part.name) : nullptr;
  for (const auto& initial : modes_found(results).substructures)
    if (!correlation->updated && initial.name == part.name) modes = &initial;
  if (!modes) return;
  for (const auto& comparison : correlation->comparisons)
    if (comparison.substructure == part.name)
      add_measured(part, measured_shapes(comparison, part, *modes), *modes, averaging, scene);
}

}  // namespace

std::optional<Scene> structure_scene(const Study& study, const StudyResults& results, const FiniteElementPart& part) {
  const auto& mesh = part.elements.mesh;
  const auto regions = drawn_regions(part.elements);
  ScenePlaces places(mesh, regions, most_scene_faces);
  if (places.faces().empty()) return std::nullopt;
  Marks marks(part, places);
  mark_elements(part.elements, marks);
  mark_study(study, part, marks);
  Scene scene{.title = "Structure of '" + part.name + "'", .faces = places.faces(), .regions = regions};
  scene.lines = lines_of(study, part, places, marks);
  scene.marks = marks.list();
  const SparseMatrix averaging = places.averaging();
  scene.places = mesh.nodes * averaging;
  const auto* updated = updated_modes_of(results, part.name);
  if (updated) add_modes(part, "updated ", *updated, averaging, scene);
  for (const auto& modes : modes_found(results).substructures)
    if (modes.name == part.name) add_modes(part, updated ? "initial " : "", modes, averaging, scene);
  const auto add_motions = [&](const std::vector<FieldSeries>& fields) {
    for (const auto& series : fields)
      if (series.substructure == part.name) add_motion(part, series, averaging, scene);
  };
  if (const auto* simulation = results.find<SimulationOutcome>()) add_motions(simulation->fields);
  if (const auto* estimation = results.find<EstimationOutcome>()) add_motions(estimation->fields);
  add_correlation(results, part, averaging, scene);
  for (auto& field : scene.fields)  // which were made before places of measured shapes were added
    field.shapes.conservativeResizeLike(MatrixXd::Zero(3 * scene.places.cols(), field.shapes.cols()));
  if (std::ranges::any_of(scene.fields, &SceneField::measured))
    scene.caption =
        "Measured shapes stand over those of the model in its scale and phase: dots, with lines from where "
        "the sensors rest, in the directions that were measured.";
  return scene;
}

}  // namespace kalfem
