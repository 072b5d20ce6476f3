// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/modes/report.hpp"
#include "kalfem/steps/run_study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <numeric>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/pictures/nodal_translations.hpp"
#include "kalfem/steps/correlation/expanded_shapes.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/modes/measured_shapes.hpp"
#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// An angled mast of three beams on a wheel, with everything that can stand on a structure.
const std::string mast = R"(kalfem: 1
substructures:
  wheel: {masses: {z: 3 kg}, springs: [{from: ground, to: z, stiffness: 1e5, damping: 30}]}
  mast:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions:
        leg: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}, up: [0, 1, 0]}}
        arm: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}, up: [0, 1, 0]}}
      nodes: {tip: 4, knee: 3, middle: 2, foot: 1}
      masses: {head: {at: tip, mass: 1 kg}}
      fixed: {clamp: {nodes: foot}}
    springs: [{name: stay, from: ground, to: knee.x, stiffness: 1e3}]
    damping: {modal: 1 %}
    reduction: {modes: 6}
connectors:
  mount: {from: wheel.z, to: mast.tip.z, law: linear, parameters: {k: 1e4, c: 10}}
  brace: {from: mast.middle.x, to: mast.tip.x, law: linear, parameters: {k: 1e3, c: 1}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 1 mm, band: [0.5, 30 Hz], seed: 3}}
  hammer: {force: mast.knee.y, sine: {amplitude: 1 N, frequency: 3 Hz}}
sensors:
  a: {acceleration: mast.tip.z, noise: 5 %}
  b: {acceleration: mast.tip.x, noise: 5 %}
simulate: {duration: 1 s, sample_rate: 200 Hz, tolerance: 0.1, reference: superelement}
estimate: {unknown: {mount.k: {initial: 9e3, std: 20 %}}, settle: 0.1 s}
report: {fields: {substructure: mast, every: 0.02 s}, modes: 4}
)";

class MastScene : public testing::Test {
protected:
  MastScene() {
    std::ofstream(folder_ / "nodes.csv") << "node,x,y,z\n1,0,0,0\n2,0,0,0.5\n3,0,0,1\n4,0.5,0,1\n";
    std::ofstream(folder_ / "elements.csv") << "element,node1,node2,region\n1,1,2,leg\n2,2,3,leg\n3,3,4,arm\n";
    study_ = test::study_of(mast, folder_ / "case.yaml");
    results_ = run_study(study_, "estimate");
    scene_ = structure_scene(study_, results_, part()).value();
  }

  [[nodiscard]] const FiniteElementPart& part() const { return *study_.structure->finite_elements.front().part; }

  /// Places of the marks of a kind with their labels.
  [[nodiscard]] std::vector<std::pair<Vector3d, std::string>> marks(SceneMarkKind kind) const {
    std::vector<std::pair<Vector3d, std::string>> found;
    for (const auto& mark : scene_.marks)
      if (mark.kind == kind) found.emplace_back(scene_.places.col(mark.place), mark.label);
    return found;
  }

  void expect_mark(SceneMarkKind kind, const Vector3d& place, const std::string& label) const {
    EXPECT_EQ(marks(kind), (std::vector{std::pair{place, label}})) << label;
  }

  /// A displacement as the scene's places have it.
  [[nodiscard]] MatrixXd at_places(const Eigen::VectorXd& displacement) const {
    const Eigen::Matrix3Xd nodes = nodal_translations(part(), displacement);
    MatrixXd places(3, scene_.places.cols());
    for (Index i = 0; i < places.cols(); ++i)
      places.col(i) = nodes.col(nearest_node(part().elements.mesh, scene_.places.col(i)));
    return places;
  }

  ScratchFolder folder_{"mast"};
  Study study_;
  StudyResults results_;
  Scene scene_;
};

const Vector3d foot(0, 0, 0), middle(0, 0, 0.5), knee(0, 0, 1), tip(0.5, 0, 1);

TEST_F(MastScene, HasEverythingThatStandsOnIt) {
  EXPECT_TRUE(mistakes_of(scene_).empty());
  EXPECT_EQ(scene_.regions, (std::vector<std::string>{"arm", "leg"}));
  EXPECT_EQ(scene_.faces.size(), 3u);
  EXPECT_EQ(scene_.places.cols(), 4);
  expect_mark(SceneMarkKind::sensor, tip, "a, b");
  expect_mark(SceneMarkKind::input, knee, "hammer");
  expect_mark(SceneMarkKind::mass, tip, "head");
  expect_mark(SceneMarkKind::support, foot, "");
  expect_mark(SceneMarkKind::spring, knee, "");
  EXPECT_EQ(marks(SceneMarkKind::connector).size(), 2u);
  EXPECT_EQ(marks(SceneMarkKind::boundary).size(), 3u);  // tip, middle and knee
  ASSERT_EQ(scene_.lines.size(), 1u);
  EXPECT_EQ(scene_.lines[0].kind, SceneLineKind::connector);
  EXPECT_EQ(scene_.places.col(scene_.lines[0].from), middle);
  EXPECT_EQ(scene_.places.col(scene_.lines[0].to), tip);
}

TEST_F(MastScene, HasItsModes) {
  const auto& modes = *std::ranges::find(results_.get<ModesOutcome>().substructures, "mast", &SubstructureModes::name);
  ASSERT_EQ(modes.frequencies.size(), 4);
  ASSERT_EQ(scene_.fields.size(), 6u);  // and two motions
  EXPECT_TRUE(scene_.fields[0].name.starts_with("mode 1: "));
  for (Index i = 0; i < 4; ++i) {
    const MatrixXd expected = at_places(modes.shapes.col(i));
    const auto& shape = scene_.fields[static_cast<std::size_t>(i)].shapes;
    EXPECT_LT((shape.reshaped(3, 4) - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST_F(MastScene, HasItsMotions) {
  const auto &simulated = results_.get<SimulationOutcome>().fields,
             &estimated = results_.get<EstimationOutcome>().fields;
  ASSERT_EQ(simulated.size(), 1u);
  ASSERT_EQ(estimated.size(), 1u);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& series = i == 0 ? simulated.front() : estimated.front();
    const auto& field = scene_.fields[4 + i];
    EXPECT_EQ(field.name, i == 0 ? "simulated motion" : "estimated motion");
    EXPECT_EQ(field.times, series.times);
    MatrixXd expected(12, series.displacement.cols());
    for (Index k = 0; k < expected.cols(); ++k) expected.col(k) = at_places(series.displacement.col(k)).reshaped();
    EXPECT_GT(expected.norm(), 0.0);
    EXPECT_LT((field.shapes * field.coordinates - expected).norm(), 1e-3 * expected.norm());
  }
}

/// A plate of n x n shells whose degrees of freedom are its nodes' own.
FiniteElementPart plate(Index n) {
  FiniteElementPart part{.name = "plate"};
  Mesh& mesh = part.elements.mesh;
  const auto node = [n](Index i, Index j) { return j * (n + 1) + i; };
  mesh.nodes.resize(3, (n + 1) * (n + 1));
  mesh.node_ids.resize(static_cast<std::size_t>(mesh.node_count()));
  std::iota(mesh.node_ids.begin(), mesh.node_ids.end(), 1);
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i) mesh.nodes.col(node(i, j)) << double(i) / double(n), double(j) / double(n), 0.0;
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i)
      mesh.regions["skin"].push_back(
          mesh.add_cell(CellShape::quadrilateral4, j * n + i + 1,
                        std::array{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)}));
  part.elements.properties["skin"] = ShellProperty{"steel", 0.01};
  part.assembled.expansion.resize(6 * mesh.node_count(), 6 * mesh.node_count());
  part.assembled.expansion.setIdentity();
  return part;
}

/// A motion that is linear in the place stays so at places that stand for several nodes.
TEST(StructureScene, ACoarsenedMeshMovesAsItsNodesDo) {
  const FiniteElementPart part = plate(240);
  const auto& nodes = part.elements.mesh.nodes;
  Eigen::Matrix3d slope;
  slope << 0.1, -2.0, 0.0, 0.7, 0.3, 0.0, -1.1, 0.4, 0.0;
  SubstructureModes modes{.name = "plate", .frequencies = Eigen::VectorXd::Constant(1, 5.0)};
  modes.shapes = MatrixXd::Zero(6 * nodes.cols(), 1);
  modes.shapes.reshaped(6, nodes.cols()).topRows(3) = slope * nodes;
  Study study;
  study.structure = std::make_shared<StructureModel>();
  StudyResults results;
  results.put(ModesOutcome{{modes}, {}});
  const auto scene = structure_scene(study, results, part);
  ASSERT_TRUE(scene);
  EXPECT_TRUE(mistakes_of(*scene).empty());
  EXPECT_LE(scene->faces.size(), most_scene_faces);
  EXPECT_GT(scene->faces.size(), most_scene_faces / 4);
  const MatrixXd expected = slope * scene->places;
  EXPECT_LT((scene->fields.at(0).shapes.reshaped(3, expected.cols()) - expected).norm(), 1e-12 * expected.norm());
}

TEST(StructureScene, MatricesWithoutAMeshHaveNone) {
  Study study;
  study.structure = std::make_shared<StructureModel>();
  EXPECT_FALSE(structure_scene(study, {}, FiniteElementPart{.name = "matrices"}));
}

/// Shapes in another scale and of the other sign, with an error at one sensor and an entry that was not measured.
TEST_F(MastScene, HasMeasuredShapesInScaleAndPhaseOfTheModel) {
  const auto& modes = *std::ranges::find(results_.get<ModesOutcome>().substructures, "mast", &SubstructureModes::name);
  const double none = std::numeric_limits<double>::quiet_NaN();
  CorrelatedComparison comparison{.name = "tap", .substructure = "mast", .above = 0.5 * modes.frequencies[0]};
  comparison.points = {{{"tip.x", 1.0}}, {{"tip.z", -2.0}}, {{"knee.y", 1.0}}, {{"middle.x", 1.0}, {"knee.x", 1.0}}};
  const auto model = [&](Index mode, Index node, Index direction) {
    return nodal_translations(part(), modes.shapes.col(mode))(direction, node);
  };
  const auto& mesh = part().elements.mesh;
  const Index at_tip = nearest_node(mesh, tip), at_knee = nearest_node(mesh, knee);
  for (const Index mode : {1, 0}) {
    const Eigen::Vector4d entries(model(mode, at_tip, 0), -2.0 * model(mode, at_tip, 2), mode == 1 ? none : 0.0, 17.0);
    comparison.measured.push_back({.frequency = 1.01 * modes.frequencies[mode], .shape = -30.0 * entries});
    comparison.correlation.pairs.push_back({.measured = comparison.measured.size() - 1,
                                            .model_mode = static_cast<int>(mode) + 1,
                                            .measured_frequency = comparison.measured.back().frequency,
                                            .model_frequency = modes.frequencies[mode],
                                            .mac = 0.9});
  }
  comparison.correlation.pairs.push_back({.measured = 0, .model_mode = 40});  // beyond the modes that are known
  comparison.correlation.pairs.push_back({.measured = 0});                    // pairs with nothing
  const auto shapes = measured_shapes(comparison, part(), modes);
  EXPECT_EQ(shapes.nodes, (std::vector{at_tip, at_knee}));
  ASSERT_EQ(shapes.pairs.size(), 2u);
  for (const auto& pair : shapes.pairs) {
    EXPECT_TRUE(pair.name.starts_with("measured ")) << pair.name;
    const Vector3d expected(model(pair.mode, at_tip, 0), 0.0, model(pair.mode, at_tip, 2));
    EXPECT_LT((pair.displacement.col(0) - expected).norm(), 1e-12 * expected.norm()) << pair.name;
    EXPECT_EQ(pair.displacement.col(1), Vector3d(0, 0, 0));
  }
  results_.put(CorrelationOutcome{.comparisons = {comparison}});
  const auto scene = structure_scene(study_, results_, part()).value();
  EXPECT_TRUE(mistakes_of(scene).empty());
  EXPECT_EQ(scene.places.cols(), scene_.places.cols() + 4);
  ASSERT_EQ(scene.fields.size(), scene_.fields.size() + 2);
  EXPECT_TRUE(scene.fields[0].measured && scene.fields[1].measured && !scene.fields[2].measured);
  EXPECT_LT((scene.fields[0].shapes.topRows(12) - at_places(modes.shapes.col(1)).reshaped()).norm(), 1e-12);
  EXPECT_EQ(scene.fields[2].shapes.bottomRows(12).norm(), 0.0);
}

/// The second copy takes the model's mode, the first one the measured shape.
TEST_F(MastScene, MeasuredAndModelMoveSideBySide) {
  CorrelatedComparison comparison{.name = "test", .part = study_.structure->finite_elements.front().part};
  const auto& modes = modes_found(results_).substructures;
  const auto mast = std::ranges::find(modes, std::string("mast"), &SubstructureModes::name);
  comparison.correlation.pairs.push_back({.model_mode = 2, .measured_frequency = 3.0, .model_frequency = 2.9});
  const Eigen::VectorXd mode = mast->shapes.col(1);
  comparison.correlation.expansion.shapes.push_back({.shape = 0.5 * mode, .model = mode});
  const Scene scene = side_by_side(comparison).value();
  EXPECT_TRUE(mistakes_of(scene).empty());
  const Index once = scene.places.cols() / 2;
  const MatrixXd apart = scene.places.rightCols(once) - scene.places.leftCols(once);
  EXPECT_LT((apart.colwise() - apart.col(0)).norm(), 1e-12);
  EXPECT_GT(apart.col(0).norm(), 0.2);
  ASSERT_EQ(scene.fields.size(), 1U);
  const MatrixXd& both = scene.fields[0].shapes;
  EXPECT_GT(both.norm(), 0.0);
  EXPECT_LT((both.topRows(3 * once) - 0.5 * both.bottomRows(3 * once)).norm(), 1e-12 * both.norm());
  comparison.part = nullptr;
  EXPECT_FALSE(side_by_side(comparison));
}

}  // namespace
}  // namespace kalfem
