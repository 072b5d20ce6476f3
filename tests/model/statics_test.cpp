// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"
#include "model/fe_models.hpp"
#include "model/shell_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

void clamp(FiniteElementModel& model, const std::string& name, const std::vector<Index>& nodes,
           const std::vector<int>& directions = {0, 1, 2, 3, 4, 5}) {
  FixedNodes fixed{name, nodes, {}};
  fixed.directions.fill(false);
  for (const int direction : directions) fixed.directions[static_cast<std::size_t>(direction)] = true;
  model.fixed.push_back(fixed);
}

const Reaction& reaction(const StaticSolution& solution, const std::string& name) {
  const auto found = std::ranges::find(solution.reactions, name, &Reaction::name);
  EXPECT_NE(found, solution.reactions.end()) << name;
  return *found;
}

/// Cantilever along x of length 2 m, a rectangle of 40 mm (y) by 60 mm (z).
FiniteElementModel cantilever(int count) {
  auto model = beam_model({2.0, 0.0, 0.0}, count, rectangular_section(0.04, 0.06));
  clamp(model, "wall", {0});
  return model;
}

TEST(Statics, TimoshenkoCantileverUnderATipForce) {
  const auto model = cantilever(3);
  const auto& section = std::get<BeamProperty>(model.properties.at("line")).section;
  const double force = -1500.0, length = 2.0, bending = steel.youngs_modulus * section.inertia_y;
  const auto solution = solve_statics(model, {.name = "tip", .loads = {{3, {0.0, 0.0, force}, Vector3d::Zero()}}});
  const double expected = force * std::pow(length, 3) / (3.0 * bending) +
                          force * length / (section.shear_factor_z * steel.shear_modulus() * section.area);
  EXPECT_NEAR(solution.displacements[6 * 3 + 2], expected, 1e-10 * std::abs(expected));
  const auto& wall = reaction(solution, "wall").sum;
  EXPECT_NEAR(wall.force.z(), 1500.0, 1e-6);
  EXPECT_NEAR(wall.moment.y(), -3000.0, 1e-6);
  EXPECT_LT(solution.imbalance, 1e-9);
  const auto beams = recover_stresses(model, solution.displacements)[0].beams;
  EXPECT_NEAR(beams[0].ends[0][4], -force * length, 1e-6);  // sagging tip: M_y = int z sigma > 0 at the wall
  EXPECT_NEAR(beams[2].ends[1][4], 0.0, 1e-6);
  for (const auto& beam : beams)
    for (const auto& end : beam.ends) EXPECT_NEAR(end[2], force, 1e-6);
  const double fibre = std::abs(force) * length * 0.03 / section.inertia_y;
  EXPECT_NEAR(beams[0].fibres[0]->highest, fibre, 1e-9 * fibre);
  EXPECT_NEAR(beams[0].fibres[0]->lowest, -fibre, 1e-9 * fibre);
}

// Whatever the number of elements, the moments are those of the distributed weight.
TEST(Statics, CantileverUnderItsWeightHasTheMomentsOfADistributedLoad) {
  for (const int count : {1, 4})
    for (const auto mass : {MassKind::consistent, MassKind::lumped}) {
      auto model = cantilever(count);
      model.mass_kind = mass;
      const Vector3d gravity(0.0, 0.0, -9.81);
      const auto solution = solve_statics(model, {.name = "weight", .gravity = gravity});
      const double weight = 0.04 * 0.06 * 2.0 * 7850.0 * 9.81;
      EXPECT_NEAR(reaction(solution, "wall").sum.force.z(), weight, 1e-9 * weight);
      EXPECT_NEAR(reaction(solution, "wall").sum.moment.y(), -weight * 1.0, 1e-9 * weight);
      EXPECT_LT(solution.imbalance, 1e-9);
      const auto beams = recover_stresses(model, solution.displacements, gravity)[0].beams;
      EXPECT_NEAR(beams[0].ends[0][4], weight * 1.0, 1e-9 * weight);
      EXPECT_NEAR(beams.back().ends[1][4], 0.0, 1e-9 * weight);
      EXPECT_NEAR(beams.back().ends[1][2], 0.0, 1e-9 * weight);
    }
}

TEST(Statics, AxialForceAndTorsionOfABar) {
  const auto model = cantilever(2);
  const auto solution = solve_statics(model, {.name = "pull", .loads = {{2, {5e4, 0.0, 0.0}, {300.0, 0.0, 0.0}}}});
  const auto beams = recover_stresses(model, solution.displacements)[0].beams;
  for (const auto& beam : beams)
    for (std::size_t end = 0; end < 2; ++end) {
      EXPECT_NEAR(beam.ends[end][0], 5e4, 1e-5);
      EXPECT_NEAR(beam.ends[end][3], 300.0, 1e-6);
      EXPECT_NEAR(beam.axial[end], 5e4 / 0.0024, 1.0);
    }
}

// A hinge in the middle carries no moment; the weight between the ends still bends the element.
TEST(Statics, ReleasedEndOfABeamCarriesNoMomentUnderWeight) {
  auto model = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  auto& property = std::get<BeamProperty>(model.properties.at("line"));
  property.placements.assign(2, property.placements.front());
  property.placements[0].released[10] = true;
  clamp(model, "ends", {0, 2});
  const Vector3d gravity(0.0, 0.0, -9.81);
  const auto solution = solve_statics(model, {.name = "weight", .gravity = gravity});
  const auto beams = recover_stresses(model, solution.displacements, gravity)[0].beams;
  const double weight = 0.04 * 0.06 * 7850.0 * 9.81;  // of each half: two propped cantilevers that share nothing
  EXPECT_NEAR(beams[0].ends[1][4], 0.0, 1e-9 * weight);
  EXPECT_NEAR(beams[1].ends[0][4], 0.0, 1e-9 * weight);
  EXPECT_NEAR(beams[0].ends[0][4], 0.5 * weight, 1e-9 * weight);
}

TEST(Statics, ClampedSquarePlateUnderPressure) {
  // Timoshenko and Woinowsky-Krieger, table 35: w = 0.00126 p a^4 / D, moment at the middle of an edge 0.0513 p a^2.
  const double t = 0.01, pressure = 1e4;
  ShellProblem problem(
      {32, 32, CellShape::quadrilateral4},
      [](double u, double v) -> Vector3d {
        return {u, v, 0.0};
      },
      steel, t);
  std::vector<Index> edge;
  for (const char side : {'u', 'v'})
    for (const int end : {0, 1})
      for (const Index node : problem.grid.side(side, end)) edge.push_back(node);
  clamp(problem.model, "edge", edge);
  const auto faces = faces_of_cells(problem.model, problem.model.mesh.regions.at("shell"));
  ASSERT_EQ(faces.size(), 1024u);
  const auto solution = solve_statics(problem.model, {.name = "pressure", .pressures = {{faces, pressure}}});
  const double rigidity = steel.youngs_modulus * t * t * t / (12.0 * 0.91);
  const Index middle = problem.grid.node(16, 16);
  EXPECT_NEAR(-solution.displacements[6 * middle + 2] / (pressure / rigidity), 0.001265, 0.00001);
  EXPECT_NEAR(solution.applied.force.z(), -pressure, 1e-9 * pressure);
  EXPECT_LT(solution.imbalance, 1e-9);
  const auto region = recover_stresses(problem.model, solution.displacements)[0];
  for (const auto& mean : nodal_stresses(problem.model.mesh, region))
    if (mean.node == problem.grid.node(16, 0) && mean.layer == Layer::top)
      EXPECT_NEAR(std::abs(mean.stress[1]) * t * t / 6.0 / pressure, 0.0513, 0.015 * 0.0513);
}

/// A quarter of a cylinder between planes of symmetry, inner radius 1 m, outer 1.5 m, held along its axis.
SolidProblem thick_cylinder(CellShape shape, int radial) {
  SolidProblem problem(
      {radial, 2 * radial, 1, shape},
      [](const Vector3d& cube) -> Vector3d {
        const double r = 1.0 + 0.5 * cube.x(), angle = 0.5 * pi * cube.y();
        return {r * std::cos(angle), r * std::sin(angle), 0.1 * cube.z()};
      },
      steel);
  problem.fix(problem.box.side(1, 0.0), {1});
  problem.fix(problem.box.side(1, 1.0), {0});
  problem.fix(problem.box.side(2, 0.0), {2});
  problem.fix(problem.box.side(2, 1.0), {2});
  return problem;
}

TEST(Statics, PressurisedThickCylinderHasLamesStresses) {
  const double p = 1e7, a = 1.0, b = 1.5;
  for (const auto& [shape, radial, tolerance] : {std::tuple{CellShape::hexahedron20, 4, 0.01},
                                                 {CellShape::hexahedron8, 12, 0.03},
                                                 {CellShape::tetrahedron10, 4, 0.03}}) {
    const auto problem = thick_cylinder(shape, radial);
    const auto faces = faces_between_nodes(problem.model, problem.box.side(0, 0.0));
    const auto solution = solve_statics(problem.model, {.name = "inside", .pressures = {{faces, p}}});
    const auto region = recover_stresses(problem.model, solution.displacements)[0];
    const Index inside = problem.box.at(0.0, 0.0, 0.0);
    const double hoop = p * (a * a + b * b) / (b * b - a * a);
    for (const auto& mean : nodal_stresses(problem.model.mesh, region))
      if (mean.node == inside) {
        EXPECT_NEAR(mean.stress[1], hoop, tolerance * hoop) << name_of(shape);
        EXPECT_NEAR(mean.stress[0], -p, 2.0 * tolerance * hoop) << name_of(shape);
      }
    const double nu = 0.3;  // plane strain
    const double moved =
        (1.0 + nu) * p * a / (steel.youngs_modulus * (b * b - a * a)) * ((1.0 - 2.0 * nu) * a * a + b * b);
    EXPECT_NEAR(solution.displacements[6 * inside], moved, 0.01 * moved) << name_of(shape);
    // The pressure's resultant on a quarter: p a h along x and along y.
    EXPECT_NEAR(solution.applied.force.x(), p * a * 0.1, 0.01 * p * a * 0.1);
    EXPECT_LT(solution.imbalance, 1e-9);
  }
}

// Membrane stress p r / t around a thin cylinder that can lengthen; its normals point outwards, so pressure inside is
// negative on its top.
TEST(Statics, PressurisedThinCylinderHasItsMembraneStress) {
  const double r = 1.0, t = 0.005, p = 1e5;
  for (const auto shape : {CellShape::quadrilateral4, CellShape::triangle3}) {
    ShellProblem problem(
        {24, 6, shape},
        [&](double u, double v) -> Vector3d {
          return {r * std::cos(0.5 * pi * u), r * std::sin(0.5 * pi * u), 0.5 * v};
        },
        steel, t);
    problem.fix(problem.grid.side('u', 0), {1, 3, 5});
    problem.fix(problem.grid.side('u', 1), {0, 4, 5});
    problem.fix(problem.grid.side('v', 0), {2, 3, 4});
    const auto faces = faces_of_cells(problem.model, problem.model.mesh.regions.at("shell"));
    const auto solution = solve_statics(problem.model, {.name = "inside", .pressures = {{faces, -p}}});
    const auto region = recover_stresses(problem.model, solution.displacements)[0];
    const Index middle = problem.grid.node(12, 3);
    EXPECT_NEAR(solution.displacements.segment<3>(6 * middle).head<2>().norm(), p * r * r / (t * steel.youngs_modulus),
                0.01 * p * r * r / (t * steel.youngs_modulus));
    for (const auto& mean : nodal_stresses(problem.model.mesh, region))
      if (mean.node == middle && mean.layer == Layer::middle)
        EXPECT_NEAR(von_mises(mean.stress), p * r / t, 0.01 * p * r / t);
    EXPECT_LT(solution.imbalance, 1e-9);
  }
}

TEST(Statics, WeightOfABlockStandsOnItsSupport) {
  SolidProblem problem(
      {2, 2, 4, CellShape::hexahedron8, 0.1},
      [](const Vector3d& cube) -> Vector3d {
        return {0.5 * cube.x(), 0.5 * cube.y(), cube.z()};
      },
      steel);
  problem.fix(problem.box.side(2, 0.0), {0, 1, 2});
  problem.model.masses.push_back({.name = "load", .node = problem.box.at(0.5, 0.5, 1.0), .mass = 100.0});
  const auto solution = solve_statics(problem.model, {.name = "weight", .gravity = {0.0, 0.0, -10.0}});
  const double weight = (0.25 * 7850.0 + 100.0) * 10.0;
  EXPECT_NEAR(reaction(solution, "support 1").sum.force.z(), weight, 1e-9 * weight);
  EXPECT_NEAR(solution.applied.force.z(), -weight, 1e-9 * weight);
  EXPECT_LT(solution.imbalance, 1e-9);
}

TEST(Statics, ImposedMotionAndGroundSpringAreInTheBalance) {
  auto model = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  clamp(model, "pin", {0}, {0, 1, 2, 3, 5});
  model.springs.push_back({.name = "prop", .from = {1, 2}, .stiffness = 2e5});
  const auto solution = solve_statics(model, {.name = "lift", .imposed = {{{2, 2}, 5e-3}}});
  EXPECT_NEAR(solution.displacements[6 * 2 + 2], 5e-3, 1e-15);
  const double prop = reaction(solution, "ground").sum.force.z();
  EXPECT_NEAR(prop, -2e5 * solution.displacements[6 * 1 + 2], 1e-6);
  EXPECT_NEAR(reaction(solution, "imposed motion").sum.force.z(), -0.5 * prop, 1e-6 * std::abs(prop));
  EXPECT_LT(solution.imbalance, 1e-9);
}

TEST(Statics, ObliqueSpringToTheGroundIsInTheBalance) {
  auto model = cantilever(2);
  const double s = std::sqrt(0.5);
  model.joints.push_back({.name = "stay", .deformation = {{{2, 0}, s}, {{2, 2}, s}}, .stiffness = 4e5});
  const auto solution = solve_statics(model, {.name = "push", .loads = {{2, {0.0, 0.0, -1000.0}, Vector3d::Zero()}}});
  const auto& stay = reaction(solution, "stay").sum.force;
  EXPECT_GT(stay.z(), 100.0);
  EXPECT_NEAR(stay.x(), stay.z(), 1e-9 * stay.z());
  EXPECT_NEAR(reaction(solution, "wall").sum.force.z(), 1000.0 - stay.z(), 1e-6);
  EXPECT_LT(solution.imbalance, 1e-9);
}

// Imposing a motion on a link's follower must not take a support off its master.
TEST(Statics, ImposedMotionOfAFollowerLeavesSupportsInPlace) {
  auto model = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  const Index lever = add_node(model.mesh, {0.0, 0.0, 0.4});
  model.links.push_back({"lever", 0, {lever}});
  clamp(model, "pin", {0}, {0, 1, 2, 3, 5});
  clamp(model, "end", {2});
  const auto solution = solve_statics(model, {.name = "turn", .imposed = {{{lever, 0}, 1e-3}}});
  EXPECT_NEAR(solution.displacements[6 * lever], 1e-3, 1e-15);
  EXPECT_NEAR(solution.displacements[4], 1e-3 / 0.4, 1e-12);
  EXPECT_EQ(solution.displacements[0], 0.0);
  EXPECT_LT(solution.imbalance, 1e-9);
  const auto held = message_of([&] { solve_statics(model, {.name = "stuck", .imposed = {{{lever, 1}, 1e-3}}}); });
  EXPECT_NE(held.find("which nothing moves with"), std::string::npos) << held;
}

// A load on the hub of a rigid link reaches a support at the end of another link.
TEST(Statics, ReactionsAreExactThroughRigidLinks) {
  auto model = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  const Index foot = add_node(model.mesh, {0.0, 0.0, -0.5}), hook = add_node(model.mesh, {2.0, 0.3, 0.0});
  model.links.push_back({"base", foot, {0}});
  model.links.push_back({"arm", 2, {hook}});
  clamp(model, "foot", {foot});
  const auto solution = solve_statics(model, {.name = "hang", .loads = {{hook, {0.0, 0.0, -700.0}, Vector3d::Zero()}}});
  const auto& held = reaction(solution, "foot").sum;
  EXPECT_NEAR(held.force.z(), 700.0, 1e-6);
  EXPECT_NEAR(held.moment.x(), 700.0 * 0.3, 1e-6);
  EXPECT_NEAR(held.moment.y(), -700.0 * 2.0, 1e-6);
  EXPECT_LT(solution.imbalance, 1e-9);
}

TEST(StaticsRefused, EachMistakeHasItsMessage) {
  const auto told = [](const FiniteElementModel& model, const LoadCase& load_case) {
    return message_of([&] { solve_statics(model, load_case); });
  };
  const LoadCase push{.name = "push", .loads = {{1, {0.0, 0.0, 1.0}, Vector3d::Zero()}}};
  auto free = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  const auto all_free = told(free, push);
  for (const std::string motion :
       {"move along x", "move along y", "move along z", "turn about x", "turn about y", "turn about z"})
    EXPECT_NE(all_free.find(motion), std::string::npos) << all_free;
  clamp(free, "pin", {0}, {0, 1, 2});
  EXPECT_EQ(told(free, push).find("move along"), std::string::npos) << told(free, push);
  EXPECT_NE(told(free, push).find("turn about x"), std::string::npos) << told(free, push);
  const auto held = cantilever(2);
  EXPECT_NE(told(held, {.name = "twice", .imposed = {{{2, 2}, 0.1}, {{2, 2}, 0.2}}}).find("twice"), std::string::npos);
  EXPECT_NE(told(held, {.name = "fixed", .imposed = {{{0, 2}, 0.1}}}).find("which the support 'wall' holds"),
            std::string::npos);
  SolidProblem solid(
      {1, 1, 1}, [](const Vector3d& cube) { return cube; }, steel);
  solid.fix(solid.box.side(2, 0.0), {0, 1, 2});
  const auto moment =
      told(solid.model, {.name = "turn", .loads = {{solid.box.at(1, 1, 1), Vector3d::Zero(), {1.0, 0.0, 0.0}}}});
  EXPECT_NE(moment.find("a solid's nodes have no rotations"), std::string::npos) << moment;
}

TEST(StaticsRefused, LoadsOnNothingAreToldOnceAKind) {
  SolidProblem solid(
      {3, 3, 1}, [](const Vector3d& cube) { return cube; }, steel);
  solid.fix(solid.box.side(2, 0.0), {0, 1, 2});
  LoadCase load{.name = "turn"};
  for (const Index node : solid.box.side(2, 1.0)) load.loads.push_back({node, Vector3d::UnitX(), Vector3d::UnitY()});
  try {
    solve_statics(solid.model, load);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 1u) << error.what();
    EXPECT_NE(std::string(error.what()).find("and 11 more, where there is nothing"), std::string::npos) << error.what();
  }
}

TEST(StaticsRefused, GravityAndRotationNeedMass) {
  auto model = cantilever(2);
  model.materials["steel"].density = 0.0;
  const auto told = [&](const LoadCase& load_case) { return message_of([&] { solve_statics(model, load_case); }); };
  EXPECT_NE(told({.name = "weight", .gravity = {0.0, 0.0, -9.81}}).find("has gravity, but it has no mass"),
            std::string::npos);
  EXPECT_NE(told({.name = "spin", .rotation = Rotation{.speed = 2.0}}).find("rotates it, but it has no mass"),
            std::string::npos);
  model.masses.push_back({.name = "tip", .node = 2, .mass = 1.0});
  EXPECT_NO_THROW(solve_statics(model, {.name = "weight", .gravity = {0.0, 0.0, -9.81}}));
}

TEST(StaticsRefused, MechanismsAreNamedWithTheirReason) {
  auto hinged = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  auto& property = std::get<BeamProperty>(hinged.properties.at("line"));
  property.placements.assign(2, property.placements.front());
  for (const std::size_t turn : {9u, 10u, 11u}) property.placements[0].released[turn] = true;
  clamp(hinged, "wall", {0});
  const auto told = message_of([&] { solve_statics(hinged, {.name = "weight", .gravity = {0.0, 0.0, -9.81}}); });
  EXPECT_NE(told.find("is a mechanism: it moves without strain at n"), std::string::npos) << told;
  EXPECT_NE(told.find("hinges"), std::string::npos) << told;
  SolidProblem block(
      {1, 1, 1, CellShape::hexahedron20}, [](const Vector3d& cube) { return cube; }, steel, SolidKind::reduced);
  block.fix({block.box.at(0, 0, 0)}, {0, 1, 2});
  block.fix({block.box.at(1, 0, 0)}, {1, 2});
  block.fix({block.box.at(0, 1, 0)}, {2});
  const auto hourglass = message_of([&] {
    solve_statics(block.model, {.name = "weight", .gravity = {0.0, 0.0, -9.81}});
  });
  EXPECT_NE(hourglass.find("hourglass modes of reduced integration in region 'solid'"), std::string::npos) << hourglass;
  EXPECT_NE(hourglass.find("`integration: full`"), std::string::npos) << hourglass;
}

TEST(LoadedFaces, OuterFacesOfSolidsOnly) {
  for (const auto shape : solid_shapes) {
    const SolidProblem problem(
        {2, 2, 2, shape}, [](const Vector3d& cube) { return cube; }, steel);
    std::vector<Index> middle;
    for (Index node = 0; node < problem.box.cube.cols(); ++node)
      if (std::abs(problem.box.cube(2, node) - 0.5) < 1e-9) middle.push_back(node);
    EXPECT_TRUE(faces_between_nodes(problem.model, middle).empty()) << name_of(shape);
    const auto top = faces_between_nodes(problem.model, problem.box.side(2, 1.0));
    const auto forces = nodal_forces(problem.model, {.pressures = {{top, 3.0}}});
    EXPECT_NEAR(forces.reshaped(6, problem.box.cube.cols()).row(2).sum(), -3.0, 1e-12) << name_of(shape);
    EXPECT_NEAR(forces.reshaped(6, problem.box.cube.cols()).topRows<2>().cwiseAbs().maxCoeff(), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace kalfem::test
