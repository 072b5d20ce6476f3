// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/elements/beam.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using namespace test;
using Powers = std::map<std::string, int>;

NodalSpring spring(const std::string& name, const NodalDof& from, const std::optional<NodalDof>& to, double stiffness,
                   double damping = 0.0) {
  NodalSpring item;
  item.name = name;
  item.from = from;
  item.to = to;
  item.stiffness = stiffness;
  item.damping = damping;
  return item;
}

PointMass body(const std::string& name, Eigen::Index node, double mass,
               const Eigen::Vector3d& offset = {0.0, 0.0, 0.0}) {
  PointMass item;
  item.name = name;
  item.node = node;
  item.mass = mass;
  item.offset = offset;
  item.inertia = Eigen::Matrix3d{{0.3, 0.05, 0.0}, {0.05, 0.2, 0.01}, {0.0, 0.01, 0.4}};
  return item;
}

/// A plate of two regions of different thickness with a stiffener, a spring, a dashpot, a body on an arm and a clamped
/// edge.
FiniteElementModel workshop_piece() {
  Mesh mesh = plate_mesh(1.0, 0.5, 4, 2, "thin");
  auto& thin = mesh.regions["thin"];
  mesh.regions["thick"] = {thin.begin() + 4, thin.end()};
  thin.resize(4);
  for (Eigen::Index i = 5; i < 9; ++i) add_cell(mesh, "rib", CellShape::line2, {i, i + 1});
  const auto arm = add_node(mesh, {1.2, 0.25, 0.1});
  auto model = model_of(mesh);
  model.materials["alloy"] = {.youngs_modulus = 7e10, .poissons_ratio = 0.33, .density = 2700.0};
  model.properties["thin"] = ShellProperty{"steel", 0.004};
  model.properties["thick"] = ShellProperty{"alloy", 0.01};
  model.properties["rib"] = beam_property(rectangular_tube_section(0.02, 0.03, 0.002), {0.0, 0.0, 0.015});
  model.masses = {body("motor", arm, 1.7, {0.02, 0.0, 0.03})};
  model.links = {{.name = "arm", .master = 9, .slaves = {arm}}};
  model.springs = {spring("leg", {14, 2}, {}, 5e4, 30.0), spring("tie", {0, 2}, NodalDof{4, 2}, 2e3, 1.0)};
  model.fixed = {{.name = "wall", .nodes = {0, 5, 10}, .directions = {true, true, true, true, false, true}}};
  return model;
}

/// Of the norm of what is compared. Most are found exact or 1e-16 off.
constexpr double rounding = 1e-15;

TEST(Assembly, IsTheSumOfTheElementMatricesAtTheirNodes) {
  auto model = beam_model({1.0, 0.5, 0.2}, 3, rectangular_section(0.04, 0.06));
  model.masses = {body("m", 2, 1.7, {0.1, 0.2, -0.3})};
  model.springs = {spring("s", {0, 1}, NodalDof{3, 4}, 700.0, 4.0)};
  const auto& property = std::get<BeamProperty>(model.properties["line"]);
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(24, 24), mass = stiffness, damping = stiffness;
  for (int i = 0; i < 3; ++i) {
    const auto element =
        beam(model.mesh.nodes.middleCols<2>(i), property, property.placements[0], 0.3, MassKind::consistent);
    stiffness.block<12, 12>(6 * i, 6 * i) += steel.youngs_modulus * element.stiffness.at(0).matrix;
    mass.block<12, 12>(6 * i, 6 * i) += steel.density * element.mass.at(0).matrix;
  }
  mass.block<6, 6>(12, 12) += point_mass(model.masses[0]);
  const Eigen::VectorXd elongation = Eigen::VectorXd::Unit(24, 22) - Eigen::VectorXd::Unit(24, 1);
  stiffness += 700.0 * elongation * elongation.transpose();
  damping += 4.0 * elongation * elongation.transpose();
  const auto assembled = assemble(model);
  ASSERT_EQ(assembled.size(), 24);
  EXPECT_LT(difference(stiffness_of(assembled), stiffness), rounding);
  EXPECT_LT(difference(mass_of(assembled), mass), rounding);
  EXPECT_LT(difference(Eigen::MatrixXd(assembled.damping), damping), rounding);
  EXPECT_EQ(Eigen::MatrixXd(assembled.expansion), Eigen::MatrixXd::Identity(24, 24));
}

TEST(Assembly, FixedDegreesOfFreedomAreStruckOut) {
  auto model = beam_model({1.0, 0.5, 0.2}, 2, rectangular_section(0.04, 0.06));
  const auto free = stiffness_of(assemble(model));
  model.fixed = {{.name = "a", .nodes = {0}, .directions = {true, false, true, false, false, false}},
                 {.name = "b", .nodes = {0, 2}, .directions = {true, false, false, false, false, true}}};
  const std::vector<int> kept = {1, 3, 4, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16};
  const auto assembled = assemble(model);
  EXPECT_LT(difference(stiffness_of(assembled), free(kept, kept)), rounding);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(assembled.dofs[i], (NodalDof{kept[i] / 6, kept[i] % 6}));
    EXPECT_EQ(assembled.find({kept[i] / 6, kept[i] % 6}), static_cast<Eigen::Index>(i));
    EXPECT_EQ(assembled.expansion.coeff(kept[i], static_cast<Eigen::Index>(i)), 1.0);
  }
  EXPECT_EQ(assembled.find({0, 0}), -1);
}

TEST(Assembly, TermsAreSymmetricAndHaveDifferentPowers) {
  const auto assembled = assemble(workshop_piece());
  std::set<Powers> stiffness, mass;
  for (const auto& term : assembled.stiffness) {
    EXPECT_TRUE(stiffness.insert(term.powers).second);
    EXPECT_EQ((Eigen::MatrixXd(term.matrix) - Eigen::MatrixXd(term.matrix).transpose()).norm(), 0.0);
    for (const auto& [name, power] : term.powers) EXPECT_TRUE(assembled.parameters.contains(name)) << name;
  }
  for (const auto& term : assembled.mass) {
    EXPECT_TRUE(mass.insert(term.powers).second);
    EXPECT_EQ((Eigen::MatrixXd(term.matrix) - Eigen::MatrixXd(term.matrix).transpose()).norm(), 0.0);
    for (const auto& [name, power] : term.powers) EXPECT_TRUE(assembled.parameters.contains(name)) << name;
  }
  for (const auto& powers : {Powers{{"leg.stiffness", 1}},
                             {{"tie.stiffness", 1}},
                             {{"steel.youngs_modulus", 1}},
                             {{"alloy.youngs_modulus", 1}, {"thick.thickness", 1}},
                             {{"steel.youngs_modulus", 1}, {"thin.thickness", 3}}})
    EXPECT_TRUE(stiffness.contains(powers)) << powers.begin()->first;
  for (const auto& powers : {Powers{}, {{"motor.mass", 1}}, {{"alloy.density", 1}, {"thick.thickness", 1}}})
    EXPECT_TRUE(mass.contains(powers));
}

TEST(Assembly, BeamRegionsOfOneMaterialAreOneTerm) {
  auto model = beam_model({1.0, 0.0, 0.0}, 4, rectangular_section(0.04, 0.06));
  const auto whole = assemble(model);
  auto& line = model.mesh.regions["line"];
  model.mesh.regions["rest"] = {line.begin() + 1, line.end()};
  line.resize(1);
  model.properties["rest"] = model.properties["line"];
  const auto halves = assemble(model);
  ASSERT_EQ(halves.stiffness.size(), 1u);
  ASSERT_EQ(halves.mass.size(), 1u);
  EXPECT_LT(difference(stiffness_of(halves), stiffness_of(whole)), rounding);
  EXPECT_LT(difference(mass_of(halves), mass_of(whole)), rounding);
}

TEST(Assembly, BeamRegionsHaveTheFactorsThatAreAskedFor) {
  auto model = workshop_piece();
  EXPECT_EQ(beam_factors(model),
            (std::map<std::string, double>{
                {"rib.axial", 1.0}, {"rib.bending_y", 1.0}, {"rib.bending_z", 1.0}, {"rib.torsion", 1.0}}));
  const auto plain = assemble(model, {.parameters = {"steel.density", "rip.torsion"}});
  EXPECT_FALSE(plain.parameters.contains("rib.torsion"));
  const auto divided = assemble(model, {.parameters = {"rib.torsion"}});
  EXPECT_EQ(divided.stiffness.size(), plain.stiffness.size() + 3);  // four in the place of one
  EXPECT_LT(difference(stiffness_of(divided), stiffness_of(plain)), rounding);

  // All of them by one factor are another modulus.
  auto parameters = divided.parameters;
  for (const auto& [name, value] : beam_factors(model)) parameters.at(name) = 1.3;
  auto stiffer = model;
  stiffer.materials["stiffer"] = steel;
  stiffer.materials["stiffer"].youngs_modulus *= 1.3;
  std::get<BeamProperty>(stiffer.properties["rib"]).material = "stiffer";
  EXPECT_LT(difference(Eigen::MatrixXd(evaluate(divided.stiffness, parameters)), stiffness_of(assemble(stiffer))),
            rounding);
}

TEST(Assembly, PointMassesHaveTheOffsetsThatAreAskedFor) {
  auto model = workshop_piece();
  const auto plain = assemble(model);
  EXPECT_FALSE(plain.parameters.contains("motor.offset_x"));
  const auto divided = assemble(model, {.parameters = {"motor.offset_z"}});
  EXPECT_EQ(divided.parameters.at("motor.offset_z"), 0.03);
  EXPECT_LT(difference(mass_of(divided), mass_of(plain)), rounding);
  // Anywhere, and from a node at which it sits.
  for (const Eigen::Vector3d& offset : {Eigen::Vector3d(-0.05, 0.07, 0.01), Eigen::Vector3d(0.0, 0.0, 0.0)}) {
    model.masses[0].offset = offset;
    auto parameters = divided.parameters;
    parameters.at("motor.mass") = model.masses[0].mass = 2.9;
    parameters.at("motor.offset_x") = offset.x();
    parameters.at("motor.offset_y") = offset.y();
    parameters.at("motor.offset_z") = offset.z();
    EXPECT_LT(difference(Eigen::MatrixXd(evaluate(divided.mass, parameters)), mass_of(assemble(model))), rounding);
  }
}

TEST(Assembly, RegionsWithHingesHaveOneFactorWhichNoSpringMayShare) {
  auto model = workshop_piece();
  std::get<BeamProperty>(model.properties["rib"]).placements[0].released[4] = true;
  EXPECT_EQ(beam_factors(model), (std::map<std::string, double>{{"rib.stiffness", 1.0}}));
  const AssemblyOptions options{.parameters = {"rib.stiffness"}};
  EXPECT_EQ(assemble(model, options).parameters.at("rib.stiffness"), 1.0);
  model.springs[0].name = "rib";
  EXPECT_NE(message_of([&] { assemble(model, options); }).find("'rib.stiffness' is both a factor of a beam region and"),
            std::string::npos);
  EXPECT_EQ(assemble(model).parameters.at("rib.stiffness"), 5e4);
}

TEST(Assembly, MassOfNothingIsAPlaceForOne) {
  auto model = workshop_piece();
  model.masses[0] = {.name = "later", .node = model.masses[0].node};
  const auto assembled = assemble(model);
  auto parameters = assembled.parameters;
  parameters.at("later.mass") = model.masses[0].mass = 0.7;
  EXPECT_LT(difference(Eigen::MatrixXd(evaluate(assembled.mass, parameters)), mass_of(assemble(model))), rounding);
  EXPECT_GT(difference(mass_of(assembled), mass_of(assemble(model))), 1e-2);
}

TEST(Assembly, ChangedParametersGiveWhatAssemblingAnewGives) {
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    auto model = workshop_piece();
    model.mass_kind = kind;
    const auto assembled = assemble(model);
    auto parameters = assembled.parameters;
    parameters.at("steel.youngs_modulus") = model.materials["steel"].youngs_modulus = 1.9e11;
    parameters.at("alloy.youngs_modulus") = model.materials["alloy"].youngs_modulus = 8e10;
    parameters.at("steel.density") = model.materials["steel"].density = 8100.0;
    parameters.at("thick.thickness") = std::get<ShellProperty>(model.properties["thick"]).thickness = 0.012;
    parameters.at("thin.thickness") = std::get<ShellProperty>(model.properties["thin"]).thickness = 0.003;
    parameters.at("motor.mass") = model.masses[0].mass = 2.9;
    parameters.at("leg.stiffness") = model.springs[0].stiffness = 6.6e4;
    const auto anew = assemble(model);
    EXPECT_EQ(anew.parameters, parameters);
    EXPECT_LT(difference(Eigen::MatrixXd(evaluate(assembled.stiffness, parameters)), stiffness_of(anew)), rounding);
    EXPECT_LT(difference(Eigen::MatrixXd(evaluate(assembled.mass, parameters)), mass_of(anew)), rounding);
    EXPECT_GT(difference(stiffness_of(assembled), stiffness_of(anew)), 1e-2);
  }
}

TEST(Assembly, ParameterWithoutValueIsNamed) {
  const auto assembled = assemble(workshop_piece());
  auto parameters = assembled.parameters;
  parameters.erase("thin.thickness");
  EXPECT_NE(message_of([&] { evaluate(assembled.stiffness, parameters); }).find("'thin.thickness' has no value"),
            std::string::npos);
}

TEST(Assembly, GroundsPullWhatTheirSpringsHold) {
  auto model = workshop_piece();
  model.fixed.clear();
  model.springs.push_back(spring("side", {9, 0}, {}, 800.0));
  model.springs.back().ground = "wall";
  const auto assembled = assemble(model);
  ASSERT_EQ(assembled.grounds.size(), 2u);
  EXPECT_EQ(assembled.grounds[0].ground, "ground");
  EXPECT_EQ(assembled.grounds[0].stiffness[assembled.find({14, 2})], 5e4);
  EXPECT_EQ(assembled.grounds[0].damping[assembled.find({14, 2})], 30.0);
  EXPECT_EQ(assembled.grounds[0].stiffness.cwiseAbs().sum(), 5e4);
  EXPECT_EQ(assembled.grounds[1].stiffness[assembled.find({9, 0})], 800.0);
  // All grounds move along z as one: the structure follows without force; "wall" holds x only.
  const Eigen::VectorXd rise = rigid_body_modes(model, assembled).col(2);
  const auto stiffness = stiffness_of(assembled);
  EXPECT_LT((stiffness * rise - assembled.grounds[0].stiffness).norm(), rounding * stiffness.norm());
  EXPECT_LT((assembled.damping * rise - assembled.grounds[0].damping).norm(), 1e-13);  // rounding of 30
}

TEST(Assembly, ModelsOfBodiesAndSpringsAloneAreModels) {
  Mesh mesh;
  for (const double x : {0.0, 1.0}) add_node(mesh, {x, 0.0, 0.0});
  auto model = model_of(mesh);
  model.masses = {body("a", 0, 2.0), body("b", 1, 3.0)};
  const auto loose = assemble(model);
  EXPECT_EQ(loose.size(), 12);
  EXPECT_EQ(stiffness_of(loose), Eigen::MatrixXd::Zero(12, 12));
  for (auto& mass : model.masses) mass.inertia.setZero();
  model.springs = {spring("s", {0, 0}, NodalDof{1, 0}, 6.0)};
  const auto pair = assemble(model);
  ASSERT_EQ(pair.size(), 6);
  const auto modes = normal_modes(evaluate(pair.mass, pair.parameters), evaluate(pair.stiffness, pair.parameters));
  EXPECT_NEAR(2.0 * M_PI * modes.frequencies[5], std::sqrt(6.0 * (1.0 / 2.0 + 1.0 / 3.0)), 1e-14);  // rounding
}

TEST(Assembly, DegreesOfFreedomWithoutMassStay) {
  auto model = beam_model({1.0, 0.0, 0.0}, 1, rectangular_section(0.04, 0.06));
  const auto hung = add_node(model.mesh, {2.0, 0.0, 0.0});
  model.springs = {spring("s", {1, 0}, NodalDof{hung, 0}, 1e3), spring("t", {1, 3}, NodalDof{hung, 3}, 1e3)};
  const auto assembled = assemble(model);
  const auto place = assembled.find({hung, 0});
  ASSERT_GE(place, 0);
  EXPECT_EQ(mass_of(assembled).col(place).norm(), 0.0);
  // It hangs on: a massless end moves with the spring, and adds no mode.
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = 7});
  // rounding of 5e8 N/m against 1e3 N/m
  EXPECT_NEAR(modes.vectors(place, 6) / modes.vectors(assembled.find({1, 0}), 6), 1.0, 1e-12);
}

TEST(Assembly, ElementsThatCannotBeIntegratedAreToldOnceAReason) {
  auto model = beam_model({1.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  for (int i = 0; i < 25; ++i) {
    const auto twin = add_node(model.mesh, {1.0, 0.0, 0.0});
    add_cell(model.mesh, "line", CellShape::line2, {2, twin});
  }
  add_cell(model.mesh, "other", CellShape::line2, {0, 1});
  model.properties["other"] = beam_property(rectangular_section(0.04, 0.06), {0.0, 0.0, 0.0}, {2.0, 0.0, 0.0});
  try {
    assemble(model);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 2u);
    const std::string text = error.what();
    for (const char* part : {"line.msh: 25 elements (line 3, line 4, line 5, line 6, line 7 and 20 more) of region "
                             "'line' cannot be integrated: its ends coincide",
                             "line 28 of region 'other' cannot be integrated: its axis is parallel to 'up'"})
      EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
}

TEST(MassProperties, OfABodyOnAnArmAndOfATube) {
  Mesh mesh;
  add_node(mesh, {0.5, -0.2, 1.0});
  auto model = model_of(mesh);
  model.masses = {body("m", 0, 1.7, {0.1, 0.2, -0.3})};
  const auto point = mass_properties(assemble(model));
  EXPECT_NEAR(point.mass, 1.7, 3e-15);
  EXPECT_LT((point.centre - Eigen::Vector3d(0.6, 0.0, 0.7)).norm(), rounding);
  EXPECT_LT(difference(point.inertia, model.masses[0].inertia), 5e-15);  // 1.7 times squared arms cancel
  // A thick tube along a slanted axis: I = m L^2/12 + rho I L across, rho I_p L along, turned to the axis.
  const Eigen::Vector3d end(1.0, 2.0, -2.0), axis = end / 3.0;
  const auto section = circular_tube_section(0.2, 0.03);
  const auto tube_model = beam_model(end, 7, section);
  const auto tube = mass_properties(assemble(tube_model));
  const double mass = steel.density * section.area * 3.0,
               across = mass * 9.0 / 12.0 + steel.density * section.inertia_y * 3.0;
  const double along = steel.density * section.torsion * 3.0;  // of a circular section: J = I_p
  const Eigen::Matrix3d expected = across * Eigen::Matrix3d::Identity() + (along - across) * axis * axis.transpose();
  EXPECT_NEAR(tube.mass / mass, 1.0, 2 * rounding);
  EXPECT_LT((tube.centre - end / 2.0).norm(), 2 * rounding);
  EXPECT_LT(difference(tube.inertia, expected), 5e-15);  // rounding of seven turned elements
}

TEST(MassProperties, OfAPlate) {
  const double a = 1.2, b = 0.8, t = 0.005, mass = steel.density * a * b * t;
  auto model = model_of(plate_mesh(a, b, 3, 2));
  model.properties["plate"] = ShellProperty{"steel", t};
  const auto properties = mass_properties(assemble(model));
  EXPECT_NEAR(properties.mass / mass, 1.0, 2 * rounding);
  EXPECT_LT((properties.centre - Eigen::Vector3d(a / 2.0, b / 2.0, 0.0)).norm(), rounding);
  // Bilinear shapes carry rigid motion exactly; rotary inertia adds t^2, to the drilling rotation too.
  const Eigen::Vector3d expected = mass / 12.0 * Eigen::Vector3d(b * b + t * t, a * a + t * t, a * a + b * b + t * t);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(properties.inertia(i, i) / expected[i], 1.0, 1e-14) << i;
}

TEST(FeLinearModel, NamesPointsAndDamping) {
  auto model = workshop_piece();
  const auto assembled = assemble(model);
  const auto linear = linear_model(model, assembled, {{"motor", 15}, {"corner", 0}, {"n15", 14}},
                                   {.mass_factor = 3.0, .stiffness_factor = 2e-5});
  ASSERT_EQ(linear.size(), assembled.size());
  EXPECT_EQ(linear.dofs[0], "n1.ry");
  EXPECT_EQ(linear.dofs[static_cast<std::size_t>(assembled.find({14, 2}))], "n15.z");
  // The arm (0.2, 0, 0.1) from node 10: x follows ry, y follows rx and rz.
  EXPECT_EQ(linear.points.at("motor.rz"), (DofCombination{{"n10.rz", 1.0}}));
  const auto& x = linear.points.at("motor.x");
  ASSERT_EQ(x.size(), 2u);
  EXPECT_EQ(x.at("n10.x"), 1.0);
  EXPECT_NEAR(x.at("n10.ry"), 0.1, rounding);
  EXPECT_FALSE(linear.points.contains("corner.x")) << "fixed";
  EXPECT_EQ(linear.points.at("corner.ry"), (DofCombination{{"n1.ry", 1.0}}));
  EXPECT_EQ(linear.points.at("n15.z"), (DofCombination{{"n15.z", 1.0}})) << "a point of a reduction, too";
  const Eigen::MatrixXd expected =
      Eigen::MatrixXd(assembled.damping) + 3.0 * mass_of(assembled) + 2e-5 * stiffness_of(assembled);
  EXPECT_LT(difference(Eigen::MatrixXd(linear.damping), expected), rounding);
  EXPECT_EQ(linear.modal_damping.rates.size(), 0);
}

TEST(FeLinearModel, RayleighDampingActsRelativeToTheSlowlyMovingGround) {
  // The free bar stands on one spring: it follows its ground's rise as a whole, and only the dashpot drags.
  auto model = beam_model({1.0, 0.0, 0.0}, 4, rectangular_section(0.04, 0.06));
  for (const Eigen::Index node : {0, 4})
    model.springs.push_back(spring("s" + std::to_string(node), {node, 2}, {}, 1e3, 7.0));
  const auto assembled = assemble(model);
  const auto linear = linear_model(model, assembled, {}, {.mass_factor = 3.0, .stiffness_factor = 2e-5});
  const Eigen::VectorXd rise = rigid_body_modes(model, assembled).col(2);
  // rounding of the bar's own stiffness, 1e9 N/m
  EXPECT_LT((linear.damping * rise - linear.grounds[0].damping).norm(), 4e-11 * linear.grounds[0].damping.norm());
  EXPECT_GT((linear.grounds[0].damping - assembled.grounds[0].damping).norm(), 1.0);
}

TEST(FeLinearModel, GroundThatOnlyDashpotsHoldTakesNoRayleighDamping) {
  auto model = beam_model({1.0, 0.0, 0.0}, 1, rectangular_section(0.04, 0.06));
  model.springs = {spring("d", {0, 2}, {}, 0.0, 7.0)};
  const auto assembled = assemble(model);
  const auto linear = linear_model(model, assembled, {}, {.mass_factor = 3.0});
  EXPECT_EQ(linear.grounds[0].damping, assembled.grounds[0].damping);
  EXPECT_EQ(linear.grounds[0].damping[assembled.find({0, 2})], 7.0);
}

TEST(FeLinearModel, BadPointsAndFactorsAreNamed) {
  const auto model = workshop_piece();
  const auto assembled = assemble(model);
  const auto text = message_of([&] {
    linear_model(model, assembled, {{"a", 0}, {"a", 1}, {"b", 99}, {"n3", 4}},
                 {.mass_factor = -1.0, .stiffness_factor = std::nan("")});
  });
  for (const char* part : {"'model.a' is given twice", "'model.b' names the node at position 99",
                           "'model.n3' has the name of another node", "is -1", "is nan"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST(Validation, SoundModelHasNoIssues) { EXPECT_EQ(issues_of(workshop_piece()), ""); }

TEST(Validation, MaterialsAndPropertiesAreNamedTogether) {
  const double nan = std::nan("");
  auto model = workshop_piece();
  model.materials["alloy"].density = 0.0;
  model.materials["weird"] = {.youngs_modulus = -1.0, .poissons_ratio = 0.5, .density = -3.0};
  model.materials["lost"] = {.youngs_modulus = nan, .poissons_ratio = nan, .density = nan};
  std::get<ShellProperty>(model.properties["thin"]).thickness = 0.0;
  auto rib = std::get<BeamProperty>(model.properties["rib"]);
  model.properties["rib"] = ShellProperty{"stel", 0.01};
  rib.section.torsion = 0.0;
  rib.section.shear_factor_y = -0.1;
  rib.placements[0].up = {nan, 0.0, 0.0};
  model.properties["thik"] = rib;
  model.properties["thick"] = beam_property({});
  model.mesh.regions["empty"];
  model.properties["empty"] = ShellProperty{"steel", 0.01};
  const auto issues = issues_of(model);
  for (const char* part :
       {"'weird' has Young's modulus -1", "'weird' has Poisson's ratio 0.5", "'weird' has density -3",
        "'lost' has Young's modulus nan", "'lost' has Poisson's ratio nan", "'lost' has density nan",
        "region 'thin' has the thickness 0", "'stel', which is not defined (did you mean 'steel'?)",
        "region 'rib' has a shell property but contains the line 9",
        "region 'thick' has a beam property but contains the quadrilateral 5",
        "the region 'thik', which the mesh does not have (did you mean 'thick'?)", "region 'thik' has torsion 0",
        "region 'thik' has the shear factor -0.1", "'up' or 'offset' of region 'thik'", "region 'thick' has area 0",
        "region 'empty' has a property but no elements"})
    EXPECT_NE(issues.find(part), std::string::npos) << part << "\n" << issues;
  EXPECT_THROW(assemble(model), InvalidInput);
}

TEST(Validation, MaterialsMayHaveNoDensity) {  // massless beams stand for stiff joints
  auto model = workshop_piece();
  model.materials["alloy"].density = 0.0;
  EXPECT_EQ(issues_of(model), "");
}

TEST(Validation, RegionsWithoutPropertyAndCellsThatCountTwiceAreNamed) {
  auto model = workshop_piece();
  model.properties.erase("rib");
  model.mesh.regions["all"] = {0, 1, 2};  // covered by another region with a property
  auto issues = issues_of(model);
  EXPECT_NE(issues.find("missing property for region 'rib': 4 of its elements have none"), std::string::npos) << issues;
  EXPECT_EQ(issues.find("'all'"), std::string::npos) << issues;
  model.properties["all"] = ShellProperty{"steel", 0.01};
  issues = issues_of(model);
  EXPECT_NE(issues.find("quadrilateral 1 belongs to region 'all' and also to 'thin'"), std::string::npos) << issues;
  FiniteElementModel nothing;
  nothing.name = "nothing";
  EXPECT_NE(issues_of(nothing).find("'nothing' has no properties, masses or springs"), std::string::npos);
}

TEST(Validation, MassesSpringsAndNodesAreNamedTogether) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  auto model = workshop_piece();
  model.masses = {body("m", 99, -1.0), body("m", 0, nan), body("skew", 0, 1.0), body("negative", 0, 1.0),
                  body("far", 0, 1.0)};
  model.masses[2].inertia(0, 1) = 1.0;
  model.masses[3].inertia(2, 2) = -1.0;
  model.masses[4].offset.x() = infinity;
  model.springs = {spring("s", {0, 1}, NodalDof{0, 1}, 1.0), spring("s", {-1, 1}, NodalDof{16, 1}, -5.0),
                   spring("d", {0, 7}, {}, nan, -2.0)};
  model.links = {{.name = "l", .master = 50, .slaves = {1, 60}}, {.name = "l", .master = 1, .slaves = {}}};
  model.constraints = {{"c", {{{70, 0}, 1.0}, {{0, -1}, 1.0}}}, {"c", {}}};
  model.fixed.push_back({.name = "wall", .nodes = {80}});
  const auto issues = issues_of(model);
  for (const char* part : {"point mass 'm' is given twice",
                           "'m' names the node at position 99 of 16",
                           "'m' has the mass -1",
                           "'m' has the mass nan",
                           "'skew' has an inertia",
                           "'negative' has an inertia",
                           "'far' has an offset",
                           "spring 's' is given twice",
                           "'s' connects a degree of freedom to itself",
                           "'s' names the node at position -1",
                           "'s' names the node at position 16 of 16",
                           "'s' has the stiffness -5",
                           "'d' acts in direction 7",
                           "'d' has the stiffness nan",
                           "'d' has the damping -2",
                           "rigid link 'l' is given twice",
                           "'l' names the node at position 50",
                           "'l' names the node at position 60",
                           "'l' has no slaves",
                           "constraint 'c' is given twice",
                           "'c' names the node at position 70",
                           "'c' acts in direction -1",
                           "support 'wall' names the node at position 80"})
    EXPECT_NE(issues.find(part), std::string::npos) << part << "\n" << issues;
  EXPECT_THROW(assemble(model), InvalidInput);
}

TEST(Validation, BrokenMeshesAreRefused) {
  auto model = workshop_piece();
  model.mesh.connectivity[3] = 40;
  model.mesh.regions["rib"].push_back(77);
  model.mesh.nodes(1, 2) = std::nan("");
  const auto issues = issues_of(model);
  for (const char* part : {"quadrilateral 1 has a node that does not exist",
                           "region 'rib' has an element that does not exist", "a coordinate of the mesh is not finite"})
    EXPECT_NE(issues.find(part), std::string::npos) << part << "\n" << issues;
  model.mesh.node_ids.pop_back();
  EXPECT_NE(issues_of(model).find("16 nodes and 15 numbers"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
