// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kalfem/model/mesh/connectivity.hpp"
#include "model/fe_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using test::add_cell;
using test::add_node;
using Severity = FindingSeverity;
using Topic = FindingTopic;

/// A steel plate of 1 m x 0.6 m x 10 mm, free.
FiniteElementModel plate() {
  FiniteElementModel model = test::model_of(test::plate_mesh(1.0, 0.6, 10, 6));
  model.properties["plate"] = ShellProperty{"steel", 0.01};
  return model;
}

ModelCheckReport model_check_of(const FiniteElementModel& model) { return check_model(model, assemble(model)); }

const ModelFinding* find(const ModelCheckReport& report, Topic topic, const std::string& text) {
  for (const auto& finding : report.findings)
    if (finding.topic == topic && finding.what.find(text) != std::string::npos) return &finding;
  return nullptr;
}

std::string all_of(const ModelCheckReport& report) {
  std::string text;
  for (const auto& finding : report.findings)
    text += to_string(finding.severity) + " [" + to_string(finding.topic) + "] " + finding.what + ": " + finding.why +
            "; " + finding.fix + "\n";
  return text;
}

std::vector<Index> side(const FiniteElementModel& model, double x) {
  std::vector<Index> nodes;
  for (Index node = 0; node < model.mesh.node_count(); ++node)
    if (std::abs(model.mesh.nodes(0, node) - x) < 1e-9) nodes.push_back(node);
  return nodes;
}

/// Of masses of 47.1 kg, found up to 7e-14; and of lengths and inertias.
constexpr double mass_rounding = 7e-13, rounding = 1e-13;

TEST(Health, ASoundFreePlateHasNothingAgainstIt) {
  const ModelCheckReport report = model_check_of(plate());
  EXPECT_EQ(report.count(Severity::error) + report.count(Severity::warning), 0) << all_of(report);
  ASSERT_TRUE(report.mass && report.grounding);
  EXPECT_NEAR(report.mass->mass, 7850.0 * 0.006, mass_rounding);
  EXPECT_LT((report.mass->centre - Eigen::Vector3d(0.5, 0.3, 0.0)).norm(), rounding);
  EXPECT_EQ(report.grounding->existing, 6);
  EXPECT_EQ(report.grounding->free, 6);
  EXPECT_TRUE(report.mechanisms.empty());
  EXPECT_EQ(report.stiffness_matrix.semi_definite, true);
  EXPECT_EQ(report.mass_matrix.semi_definite, true);
  ASSERT_EQ(report.regions.size(), 1u);
  EXPECT_EQ(report.regions[0].kind, "shell");
  EXPECT_NEAR(report.regions[0].measure, 0.6, rounding);
  EXPECT_NEAR(report.regions[0].mass, 47.1, mass_rounding);
  ASSERT_EQ(report.materials.size(), 1u);
  EXPECT_EQ(report.materials[0].resembles, "steel");
  EXPECT_NEAR(report.materials[0].wave_speed, std::sqrt(2.1e11 / 7850.0), 1e-11);  // rounding
  EXPECT_EQ(report.parts, std::vector<Index>{77});
  EXPECT_NE(find(report, Topic::grounding, "is free"), nullptr);
}

TEST(Health, SupportsHoldWhatTheyHold) {
  FiniteElementModel model = plate();
  model.fixed.push_back({"edge", side(model, 0.0), {true, true, true, true, true, true}});
  const ModelCheckReport clamped = model_check_of(model);
  EXPECT_EQ(clamped.grounding->free, 0);
  EXPECT_EQ(clamped.fixed_dofs, 42);
  EXPECT_EQ(clamped.count(Severity::warning), 0) << all_of(clamped);
  model.fixed[0] = {
      "plane", side(model, 0.0), {false, false, true, false, false, false}};  // x, y and about z stay free
  const ModelCheckReport partly = model_check_of(model);
  EXPECT_EQ(partly.grounding->free, 4) << all_of(partly);  // and the turn about the held edge
  EXPECT_FALSE(partly.grounding->motions[0].strained);
  EXPECT_TRUE(partly.grounding->motions[2].strained);
  EXPECT_EQ(partly.grounding->stray_count, 0) << all_of(partly);
}

TEST(Health, SoftGroundSpringsAreSupportsAndNotStray) {
  FiniteElementModel model = plate();
  for (const Index node : {Index{0}, Index{10}, Index{66}})
    for (int d = 0; d < 3; ++d)
      model.springs.push_back({.name = "s" + std::to_string(3 * node + d), .from = {node, d}, .stiffness = 10.0});
  const ModelCheckReport report = model_check_of(model);
  EXPECT_EQ(report.grounded_dofs, 9);
  EXPECT_EQ(report.grounding->free, 0);
  EXPECT_EQ(report.grounding->stray_count, 0) << all_of(report);
}

TEST(Health, ASpringAcrossADistanceIsAStrayGrounding) {
  // a spring along z between nodes that stand apart along x takes force when the plate turns about y
  FiniteElementModel model = plate();
  model.springs.push_back({.name = "cross", .from = {0, 2}, .to = NodalDof{5, 2}, .stiffness = 1e6});
  const ModelCheckReport report = model_check_of(model);
  EXPECT_EQ(report.grounding->free, 5);
  EXPECT_EQ(report.grounding->stray_count, 2);
  ASSERT_EQ(report.stray_dofs.size(), 2u);
  EXPECT_TRUE(std::ranges::count(report.stray_dofs, "n1.z") == 1 && std::ranges::count(report.stray_dofs, "n6.z") == 1);
  const auto* finding = find(report, Topic::grounding, "n6.z");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->severity, Severity::warning);
  // beside a support too
  model.fixed.push_back({"edge", side(model, 1.0), {true, true, true, true, true, true}});
  EXPECT_EQ(model_check_of(model).grounding->stray_count, 2);
}

TEST(Health, RigidLinksAndHeldMastersAreNotStray) {
  FiniteElementModel model = plate();
  const Index hub = add_node(model.mesh, {-0.2, 0.3, 0.1});
  model.links.push_back({"hub", hub, side(model, 0.0)});
  EXPECT_EQ(model_check_of(model).grounding->free, 6);
  model.fixed.push_back({"hub", {hub}, {true, true, true, true, true, true}});
  const ModelCheckReport held = model_check_of(model);
  EXPECT_EQ(held.grounding->free, 0);
  EXPECT_EQ(held.grounding->stray_count, 0) << all_of(held);
}

TEST(Health, UnzippedSeamsAreSeen) {
  // two plates side by side whose nodes at the seam stand at one place
  FiniteElementModel model = plate();
  Mesh& mesh = model.mesh;
  std::vector<Index> seam;
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= 1; ++i) {
      const Index node = add_node(mesh, {1.0 + 0.1 * i, 0.1 * j + 1e-9, 0.0});
      if (i == 0) seam.push_back(node);
    }
  for (Index j = 0; j < 2; ++j)
    add_cell(mesh, "plate", CellShape::quadrilateral4, {77 + 2 * j, 78 + 2 * j, 80 + 2 * j, 79 + 2 * j});
  const ModelCheckReport report = model_check_of(model);
  EXPECT_EQ(report.coincident_pairs, 3);
  EXPECT_EQ(report.unjoined_pairs, 3);
  EXPECT_EQ(report.parts, (std::vector<Index>{77, 6}));
  const auto* finding = find(report, Topic::connections, "n11 and n78");
  ASSERT_NE(finding, nullptr) << all_of(report);
  EXPECT_EQ(finding->nodes.size(), 6u);
  EXPECT_NE(find(report, Topic::connections, "consists of 2 unconnected parts"), nullptr);
  EXPECT_EQ(report.mechanisms.size(), 6u);
  // joined by springs and links they are hinges on purpose
  model.links.push_back({"first", 10, {seam[0]}});
  model.springs.push_back({.name = "second", .from = {21, 0}, .to = NodalDof{seam[1], 0}, .stiffness = 1e5});
  const ModelCheckReport joined = model_check_of(model);
  EXPECT_EQ(joined.coincident_pairs, 3);
  EXPECT_EQ(joined.unjoined_pairs, 1);
}

TEST(Health, NodesThatNothingTouches) {
  FiniteElementModel model = plate();
  add_node(model.mesh, {0.5, 0.3, 0.2});
  const ModelCheckReport report = model_check_of(model);
  EXPECT_EQ(report.free_nodes, 1);
  EXPECT_NE(find(report, Topic::mesh, "n78"), nullptr) << all_of(report);
}

TEST(Health, MechanismsAreNamed) {
  FiniteElementModel model = plate();
  const Index end = add_node(model.mesh, {1.0, 0.0, 0.3});
  add_cell(model.mesh, "strut", CellShape::line2, {10, end});
  model.properties["strut"] =
      test::beam_property(circular_section(0.02), Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX());
  model.masses.push_back({.name = "lamp", .node = end, .mass = 2.0});
  EXPECT_TRUE(model_check_of(model).mechanisms.empty());
  const Index bob = add_node(model.mesh, {1.0, 0.0, 0.5});  // hangs on a spring along z alone
  model.masses.push_back({.name = "bob", .node = bob, .mass = 1.0});
  model.springs.push_back({.name = "wire", .from = {end, 2}, .to = NodalDof{bob, 2}, .stiffness = 1e4});
  const ModelCheckReport report = model_check_of(model);
  EXPECT_EQ(report.mechanisms, (std::vector<std::string>{"n79.x", "n79.y"})) << all_of(report);
  EXPECT_NE(find(report, Topic::connections, "n79.x"), nullptr);
}

TEST(Health, HourglassModesAreNamedWithTheirRemedy) {
  for (const auto kind : {SolidKind::reduced, SolidKind::full}) {
    test::SolidProblem block(
        {1, 1, 1, CellShape::hexahedron20}, [](const Eigen::Vector3d& cube) { return cube; }, test::steel, kind);
    const ModelCheckReport report = model_check_of(block.model);
    EXPECT_EQ(report.mechanisms.size(), kind == SolidKind::reduced ? 6u : 0u);
    const auto* finding = find(report, Topic::connections, "need no force");
    ASSERT_EQ(finding != nullptr, kind == SolidKind::reduced) << all_of(report);
    if (!finding) continue;
    EXPECT_NE(finding->why.find("hourglass modes of reduced integration in region 'solid'"), std::string::npos);
    EXPECT_NE(finding->fix.find("`integration: full`"), std::string::npos);
  }
}

TEST(Health, HingesBesideReducedIntegrationAreNoHourglassModes) {
  test::SolidProblem block(
      {2, 2, 2, CellShape::hexahedron20}, [](const Eigen::Vector3d& cube) { return cube; }, test::steel,
      SolidKind::reduced);
  block.fix(block.box.side(0, 0.0), {0, 1, 2});
  const Index bob = add_node(block.model.mesh, {2.0, 0.0, 0.0});
  block.model.masses.push_back({.name = "bob", .node = bob, .mass = 1.0});
  block.model.springs.push_back(
      {.name = "wire", .from = {block.box.at(1.0, 0.0, 0.0), 0}, .to = NodalDof{bob, 0}, .stiffness = 1e4});
  const ModelCheckReport report = model_check_of(block.model);
  const auto* finding = find(report, Topic::connections, "need no force");
  ASSERT_NE(finding, nullptr) << all_of(report);
  EXPECT_EQ(finding->why.find("hourglass"), std::string::npos) << finding->why;
}

TEST(Health, CoincidentElementsOfOneKindAreReported) {
  FiniteElementModel model = plate();
  const auto nodes = model.mesh.nodes_of(model.mesh.cells[3]);
  const std::vector<Index> turned = {nodes[2], nodes[3], nodes[0], nodes[1]};
  add_cell(model.mesh, "patch", CellShape::quadrilateral4, turned);
  model.properties["patch"] = ShellProperty{"steel", 0.005};
  const ModelCheckReport report = model_check_of(model);
  const auto* finding = find(report, Topic::elements, "1 pair of elements have the same nodes");
  ASSERT_NE(finding, nullptr) << all_of(report);
  EXPECT_NE(finding->what.find("quadrilateral 4 and quadrilateral 61"), std::string::npos) << finding->what;
  EXPECT_EQ(finding->nodes.size(), 4u);
}

TEST(Health, ElementsOfTwoKindsOnOneSideDoNotCoincide) {
  FiniteElementModel model = plate();
  EXPECT_FALSE(coincident_elements_finding(model));
  add_cell(model.mesh, "stiffener", CellShape::line2, {0, 1});
  model.properties["stiffener"] = test::beam_property(rectangular_section(0.02, 0.03));
  EXPECT_FALSE(coincident_elements_finding(model));
  add_cell(model.mesh, "stiffener", CellShape::line2, {1, 0});
  EXPECT_TRUE(coincident_elements_finding(model));
}

TEST(Health, OneUsualMaterialInSiIsEnoughForTheUnits) {
  FiniteElementModel model = plate();
  EXPECT_FALSE(units_finding(model));
  model.materials["steel"] = {.youngs_modulus = 2.1e5, .poissons_ratio = 0.3, .density = 7.85e-9};
  const auto finding = units_finding(model);
  ASSERT_TRUE(finding);
  EXPECT_NE(finding->fix.find("length mm, mass t"), std::string::npos) << finding->fix;
  model.materials["alloy"] = {.youngs_modulus = 7e10, .poissons_ratio = 0.3, .density = 2700.0};
  EXPECT_TRUE(units_finding(model)) << "of a material that nothing is made of";
  model.properties["alloy"] = ShellProperty{"alloy", 0.005};
  EXPECT_FALSE(units_finding(model));
}

TEST(Health, MillimetresAndTonnesAreRecognised) {
  FiniteElementModel model = test::model_of(test::plate_mesh(1000.0, 600.0, 10, 6));
  model.materials["steel"] = {.youngs_modulus = 2.1e5, .poissons_ratio = 0.3, .density = 7.85e-9};
  model.properties["plate"] = ShellProperty{"steel", 10.0};
  const ModelCheckReport report = model_check_of(model);
  const auto* units = find(report, Topic::units, "mm, t, s");
  ASSERT_NE(units, nullptr) << all_of(report);
  EXPECT_EQ(units->severity, Severity::warning);
  EXPECT_NE(units->what.find("steel"), std::string::npos);
  EXPECT_NE(units->what.find("5.172e+06"), std::string::npos) << units->what;  // the wave speed in mm/s
  EXPECT_NE(units->fix.find("length mm, mass t"), std::string::npos) << units->fix;
  EXPECT_NE(find(report, Topic::units, "1166 m large"), nullptr) << all_of(report);
}

TEST(Health, AThicknessInMillimetresIsSeen) {
  FiniteElementModel model = plate();
  model.properties["plate"] = ShellProperty{"steel", 10.0};
  EXPECT_NE(find(model_check_of(model), Topic::units, "thickness of region 'plate'"), nullptr);
}

TEST(Health, MaterialsAndRegionsThatAreNotUsed) {
  FiniteElementModel model = plate();
  model.materials["spare"] = {.youngs_modulus = 7e10, .poissons_ratio = 0.3, .density = 2700.0};
  const ModelCheckReport report = model_check_of(model);
  EXPECT_NE(find(report, Topic::materials, "'spare' is not used"), nullptr);
  ASSERT_EQ(report.materials.size(), 2u);
  EXPECT_EQ(report.materials[0].resembles, "aluminium");
  EXPECT_EQ(report.materials[1].used_by, std::vector<std::string>{"plate"});
}

TEST(Health, BadlyShapedCellsAreCountedByRegion) {
  FiniteElementModel model = plate();
  model.mesh.nodes(0, 12) = 0.005;  // squeezes one cell, stretches its neighbour
  const ModelCheckReport report = model_check_of(model);
  ASSERT_EQ(report.quality.size(), 1u);
  EXPECT_EQ(report.quality[0].measured, 60);
  EXPECT_GT(report.quality[0].measures[static_cast<std::size_t>(QualityMeasure::taper)].beyond, 0);
  EXPECT_NE(find(report, Topic::elements, "taper below"), nullptr) << all_of(report);
}

TEST(Health, SpringsOutOfProportionAreNamed) {
  FiniteElementModel model = plate();
  const double at_node = test::steel.youngs_modulus * 0.01;  // the order of the plate's own stiffness
  model.springs.push_back({.name = "stop", .from = {5, 0}, .to = NodalDof{6, 0}, .stiffness = 1e9 * at_node});
  EXPECT_NE(find(model_check_of(model), Topic::stiffness, "'stop'"), nullptr);
  model.springs[0].stiffness = 1e2 * at_node;
  EXPECT_EQ(find(model_check_of(model), Topic::stiffness, "'stop'"), nullptr);
}

// Bare matrices.

LinearModel matrices(const FiniteElementModel& model) {
  const AssembledModel assembled = assemble(model);
  LinearModel bare;
  bare.mass = evaluate(assembled.mass, assembled.parameters);
  bare.stiffness = evaluate(assembled.stiffness, assembled.parameters);
  for (const auto& dof : assembled.dofs) bare.dofs.push_back(dof_name(model.mesh, dof));
  return bare;
}

std::vector<PlacedDof> places(const FiniteElementModel& model) {
  std::vector<PlacedDof> list;
  for (const auto& dof : assemble(model).dofs) list.push_back({model.mesh.nodes.col(dof.node), dof.direction});
  return list;
}

TEST(HealthOfMatrices, KnowsMassGroundingAndFrequencies) {
  const FiniteElementModel model = plate();
  const ModelCheckReport report = check_model(matrices(model), places(model));
  EXPECT_EQ(report.count(Severity::error) + report.count(Severity::warning), 0) << all_of(report);
  ASSERT_TRUE(report.mass && report.grounding);
  EXPECT_NEAR(report.mass->mass, 47.1, mass_rounding);
  EXPECT_LT((report.mass->centre - Eigen::Vector3d(0.5, 0.3, 0.0)).norm(), rounding);
  EXPECT_LT((report.mass->inertia - mass_properties(assemble(model)).inertia).norm(), rounding);
  EXPECT_EQ(report.grounding->free, 6);
  ASSERT_EQ(report.lowest_frequencies.size(), 12u);
  EXPECT_EQ(std::ranges::count(report.lowest_frequencies, 0.0), 6);
  const ModelCheckReport unplaced = check_model(matrices(model));
  EXPECT_FALSE(unplaced.mass || unplaced.grounding);
}

TEST(HealthOfMatrices, WrongPlacesOrStrayStiffnessShow) {
  const FiniteElementModel model = plate();
  LinearModel bare = matrices(model);
  bare.stiffness.coeffRef(100, 100) *= 1.001;
  const ModelCheckReport report = check_model(bare, places(model));
  EXPECT_EQ(report.grounding->stray_count, 1) << all_of(report);
  ASSERT_EQ(report.stray_dofs.size(), 1u);
  EXPECT_EQ(report.stray_dofs[0], bare.dofs[100]);
}

TEST(HealthOfMatrices, AsymmetryAndIndefinitenessAreErrors) {
  const FiniteElementModel model = plate();
  LinearModel skew = matrices(model);
  skew.stiffness.coeffRef(3, 9) += 1e6;
  const ModelCheckReport asymmetric = check_model(skew);
  EXPECT_GT(asymmetric.stiffness_matrix.asymmetry, 1e-6);
  EXPECT_NE(find(asymmetric, Topic::stiffness, "not symmetric"), nullptr);

  LinearModel negative = matrices(model);
  negative.mass.coeffRef(7, 7) = -1.0;
  const ModelCheckReport of_negative = check_model(negative);
  EXPECT_EQ(of_negative.mass_matrix.negative_diagonal, 1);
  EXPECT_NE(find(of_negative, Topic::mass, negative.dofs[7]), nullptr) << all_of(of_negative);

  LinearModel indefinite = matrices(model);
  indefinite.stiffness.coeffRef(50, 50) *= 0.5;
  EXPECT_EQ(check_model(indefinite).stiffness_matrix.semi_definite, false);

  LinearModel infinite = matrices(model);
  infinite.stiffness.coeffRef(50, 50) = std::numeric_limits<double>::quiet_NaN();
  const ModelCheckReport of_infinite = check_model(infinite, places(model));
  EXPECT_FALSE(of_infinite.stiffness_matrix.finite);
  EXPECT_EQ(of_infinite.count(Severity::error), 1) << all_of(of_infinite);
}

TEST(HealthOfMatrices, EmptyAndMasslessModelsAreFindings) {
  LinearModel empty;
  EXPECT_EQ(check_model(empty).degrees_of_freedom, 0);
  LinearModel zero;
  zero.dofs = {"a", "b"};
  zero.mass = zero.stiffness = SparseMatrix(2, 2);
  EXPECT_GE(check_model(zero, std::vector<PlacedDof>(2)).count(Severity::error), 1);
}

TEST(CoincidentNodes, AgreeWithBruteForceOnBothSidesOfBoxes) {
  const Index n = 400;
  const double tolerance = 0.02;
  Eigen::Matrix3Xd nodes(3, n);
  std::srand(3);
  nodes.setRandom();
  std::vector<std::pair<Index, Index>> expected;
  for (Index i = 0; i < n; ++i)
    for (Index j = i + 1; j < n; ++j)
      if (nodes.col(i)[0] > -5.0 && (nodes.col(i) - nodes.col(j)).norm() <= 5.0 * tolerance)
        expected.emplace_back(i, j);
  ASSERT_GT(expected.size(), 20u);
  EXPECT_EQ(coincident_nodes(nodes, std::vector<bool>(n, true), 5.0 * tolerance, 1000), expected);
  // all at one place: no more than so many partners each
  nodes.setZero();
  EXPECT_EQ(coincident_nodes(nodes, std::vector<bool>(n, true), tolerance, 3).size(), 3u * n - 6u);
}

TEST(Plausibility, RecognisesUnitsOfDecks) {
  const auto first = [](double modulus, double density) {
    const auto fitting = units_that_fit({.youngs_modulus = modulus, .density = density});
    return fitting.empty() ? std::string()
                           : std::string(fitting.front().units.name) + " " + fitting.front().material.name;
  };
  EXPECT_EQ(first(2.1e5, 7.85e-9), "mm, t, s (N, MPa) steel");
  EXPECT_EQ(first(70e3, 2.7e-9), "mm, t, s (N, MPa) aluminium");
  EXPECT_EQ(first(210.0, 7.85e-6), "mm, kg, ms (kN, GPa) steel");
  EXPECT_EQ(first(2.1e8, 7.85e-6), "mm, kg, s (mN, kPa) steel");
  EXPECT_EQ(first(2.9e7, 7.35e-4), "inch, lbf s^2/in, s (lbf, psi) steel");
  EXPECT_EQ(first(1.0e7, 2.59e-4), "inch, lbf s^2/in, s (lbf, psi) aluminium");
  EXPECT_EQ(first(2.1e12, 7.85), "cm, g, s (dyn) steel");
  EXPECT_EQ(usual_material(1.1e10, 480.0)->name, std::string("wood"));
  EXPECT_EQ(usual_material(2e6, 1100.0)->name, std::string("rubber"));
  EXPECT_FALSE(usual_material(2.1e11, 7.85));
}

}  // namespace
}  // namespace kalfem
