// SPDX-License-Identifier: Apache-2.0
// Every kind of element as a bar that lies askew in space, under every load that it takes: what its supports carry is
// the resultant and moment of the load on the body, and its end moves as the closed form says.
#include <gtest/gtest.h>

#include "kalfem/model/elements/beam_loads.hpp"
#include "kalfem/model/mesh/split_quadratic_shells.hpp"
#include "kalfem/model/statics/rotation.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"
#include "model/element_helpers.hpp"
#include "model/fe_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double length = 2.0, width = 0.1, height = 0.06, area = width * height;
/// Without lateral contraction: a clamped foot does not disturb the tension.
const IsotropicMaterial material{.youngs_modulus = 2.1e11, .poissons_ratio = 0.0, .density = 7850.0};
const double mass_of_bar = material.density * area * length;

/// The bar's axes: x along it, y along the width, z along the height; and its foot.
Matrix3d bar_axes() { return some_turn(); }
Vector3d foot_place() { return {0.4, -0.3, 0.7}; }
Vector3d placed(const Vector3d& local) { return foot_place() + bar_axes() * local; }

/// Eight points of a box that share its mass: they have its centre and its second moments.
struct Body {
  double mass = 0.0;
  std::vector<Vector3d> points;

  Body(double the_mass, const Vector3d& centre, const Vector3d& sides) : mass(the_mass) {
    const double root = 0.5 / std::sqrt(3.0);
    for (const double x : {-root, root})
      for (const double y : {-root, root})
        for (const double z : {-root, root})
          points.push_back(placed(centre + Vector3d(x * sides.x(), y * sides.y(), z * sides.z())));
  }
  /// Force and moment about the origin.
  [[nodiscard]] Resultant under(const AccelerationField& field) const {
    Resultant sum;
    for (const auto& point : points) {
      const Vector3d force = mass / static_cast<double>(points.size()) * field.at(point);
      sum += {force, point.cross(force), Vector3d::Zero()};
    }
    return sum;
  }
};

/// How near the displacement of the end is to the closed form, relative: under a force, and under a field.
struct Exactness {
  double force = 1e-9, weight = 1e-9, rotation = 1e-9;
  bool moments = true;  ///< lumped masses stand at the nodes: the moment of a field that varies is another one
};

struct Bar {
  std::string name;
  FiniteElementModel model;
  std::vector<Index> foot, end;
  LoadCase pull;  ///< of the stress 1e8 Pa along the bar at its end
  Body body;
  Exactness exact = {};
};

constexpr double pulled = 1e8;
Vector3d end_force() { return pulled * area * bar_axes().col(0); }

void clamp_foot(Bar& bar) { bar.model.fixed.push_back({.name = "foot", .nodes = bar.foot}); }

// Bars of lines -------------------------------------------------------------------------------------------------------

/// The line stands `offset` off the nodes, in the bar's axes, and the centroid, which is the bar's, off the line.
Bar line_bar(const std::string& name, BeamProperty property, int count, const Vector3d& offset = Vector3d::Zero()) {
  const Vector3d arm =
      bar_axes() * (offset + Vector3d(0.0, property.section.centroid.x(), property.section.centroid.y()));
  property.material = "steel";
  for (auto& placement : property.placements) {
    placement.up = bar_axes().col(2);
    placement.offsets.colwise() = Vector3d(bar_axes() * offset);
  }
  FiniteElementModel model = model_of(line_mesh(placed({0, 0, 0}) - arm, placed({length, 0, 0}) - arm, count));
  model.materials["steel"] = material;
  model.properties["line"] = property;
  return {.name = name,
          .model = std::move(model),
          .foot = {0},
          .end = {count},
          .pull = {.name = "pull", .loads = {{count, end_force(), arm.cross(end_force())}}},
          .body = Body(mass_of_bar, {0.5 * length, 0.0, 0.0}, {length, 0.0, 0.0})};
}

BeamProperty bar_property() { return beam_property(rectangular_section(width, height, 0.0)); }

BeamProperty eccentric() {
  auto property = bar_property();
  property.section.centroid = {0.04, -0.03};
  return property;
}

BeamProperty of_equal_stations(BeamProperty property = bar_property()) {
  property.stations = {{0.0, property.section}, {1.0, property.section}};
  return property;
}

/// Hinged at both ends, as the rods of decks; springs hold its end across.
Bar rod() {
  auto property = bar_property();
  for (const int released : {4, 5, 9, 10, 11})
    property.placements[0].released[static_cast<std::size_t>(released)] = true;
  Bar bar = line_bar("rod", property, 1);
  bar.model.fixed = {{.name = "end", .nodes = bar.end, .directions = {false, false, false, true, true, true}}};
  for (const int axis : {1, 2}) {
    JointSpring spring{.name = axis == 1 ? "y" : "z", .deformation = {}, .stiffness = 1e9};
    for (int i = 0; i < 3; ++i) spring.deformation.push_back({{bar.end[0], i}, bar_axes()(i, axis)});
    bar.model.joints.push_back(spring);
  }
  return bar;
}

Bar lumped(Bar bar) {
  bar.name += "_lumped";
  bar.model.mass_kind = MassKind::lumped;
  bar.exact.moments = false;
  bar.exact.rotation = 0.05;
  return bar;
}

std::vector<Bar> line_bars() {
  const Vector3d offset(0.0, 0.3, -0.2);
  auto slender = bar_property();
  slender.section.shear_factor_y = slender.section.shear_factor_z = 0.0;
  std::vector<Bar> bars = {line_bar("beam", bar_property(), 1),
                           line_bar("beams", bar_property(), 4),
                           line_bar("beam_slender", slender, 1),
                           line_bar("beam_offset", bar_property(), 1, offset),
                           line_bar("beam_tapered", of_equal_stations(), 1),
                           line_bar("beam_tapered_offset", of_equal_stations(), 2, offset),
                           line_bar("beam_eccentric", eccentric(), 1, offset),
                           line_bar("beam_tapered_eccentric", of_equal_stations(eccentric()), 1, offset),
                           rod()};
  bars.push_back(lumped(line_bar("beams", bar_property(), 4)));
  bars.push_back(lumped(line_bar("beams_tapered", of_equal_stations(), 4)));
  return bars;
}

// Bars of shells ------------------------------------------------------------------------------------------------------

LaminateProperty laminate_of_bar(double offset) {
  return {.stiffness =
              [] {
                auto section = isotropic_section(0.0, height);
                for (auto* part : {&section.membrane, &section.bending}) *part *= material.youngs_modulus;
                section.shear *= material.youngs_modulus;
                return section;
              }(),
          .mass = material.density * height,
          .rotary_inertia = material.density * std::pow(height, 3) / 12.0,
          .offset = offset};
}

/// Strip of 8 x 1 cells; its mid-surface stands `offset` above the nodes.
Bar shell_bar(const std::string& name, CellShape shape, const RegionProperty& property, double offset = 0.0) {
  constexpr int count = 8;
  const int step = node_count(shape) > corner_count(shape) ? 2 : 1;
  FiniteElementModel model = model_of({});
  model.mesh.source = "strip";
  model.materials["steel"] = material;
  model.properties["strip"] = property;
  std::map<std::array<int, 2>, Index> number;
  for (int i = 0; i <= step * count; ++i)
    for (int j = 0; j <= step; ++j)
      if (step == 1 || shape == CellShape::triangle6 || i % 2 == 0 || j % 2 == 0)
        number[{i, j}] =
            add_node(model.mesh, placed({length * i / (step * count), width * (1.0 * j / step - 0.5), -offset}));
  for (int i = 0; i < count; ++i) {
    const auto n = [&](int di, int dj) { return number.at({step * i + di, dj}); };
    const auto add = [&](const std::vector<Index>& nodes) { add_cell(model.mesh, "strip", shape, nodes); };
    if (shape == CellShape::quadrilateral4) add({n(0, 0), n(1, 0), n(1, 1), n(0, 1)});
    if (shape == CellShape::quadrilateral8)
      add({n(0, 0), n(2, 0), n(2, 2), n(0, 2), n(1, 0), n(2, 1), n(1, 2), n(0, 1)});
    if (shape == CellShape::triangle3) add({n(0, 0), n(1, 0), n(1, 1)}), add({n(0, 0), n(1, 1), n(0, 1)});
    if (shape == CellShape::triangle6) {
      add({n(0, 0), n(2, 0), n(2, 2), n(1, 0), n(2, 1), n(1, 1)});
      add({n(0, 0), n(2, 2), n(0, 2), n(1, 1), n(1, 2), n(0, 1)});
    }
  }
  Bar bar{.name = name,
          .model = std::move(model),
          .foot = {},
          .end = {},
          .pull = {.name = "pull"},
          .body = Body(mass_of_bar, {0.5 * length, 0.0, 0.0}, {length, width, 0.0})};
  const std::array<double, 3> shares = step == 1 ? std::array{0.5, 0.5, 0.0} : std::array{1 / 6.0, 4 / 6.0, 1 / 6.0};
  const Vector3d arm = offset * bar_axes().col(2);
  for (int j = 0; j <= step; ++j) {
    bar.foot.push_back(number.at({0, j}));
    bar.end.push_back(number.at({step * count, j}));
    const Vector3d force = shares[static_cast<std::size_t>(j)] * end_force();
    bar.pull.loads.push_back({bar.end.back(), force, arm.cross(force)});
  }
  if (step == 2) replace_quadratic(bar.model);
  // The weight of triangles bends a strip whose diagonals run one way a little.
  if (corner_count(shape) == 3) bar.exact.weight = bar.exact.rotation = 0.01;
  return bar;
}

std::vector<Bar> shell_bars() {
  const ShellProperty plain{"steel", height}, above{"steel", height, 0.25};
  std::vector<Bar> bars;
  for (const auto& [shape, name] : {std::pair{CellShape::quadrilateral4, std::string("quadrilateral4")},
                                    {CellShape::triangle3, "triangle3"},
                                    {CellShape::quadrilateral8, "quadrilateral8"},
                                    {CellShape::triangle6, "triangle6"}}) {
    bars.push_back(shell_bar(name, shape, plain));
    bars.push_back(lumped(bars.back()));
    if (node_count(shape) > corner_count(shape)) continue;
    bars.push_back(shell_bar(name + "_offset", shape, above, 0.25));
    bars.push_back(shell_bar(name + "_laminate", shape, laminate_of_bar(0.0)));
    bars.push_back(shell_bar(name + "_laminate_offset", shape, laminate_of_bar(0.25), 0.25));
  }
  return bars;
}

// Bars of solids ------------------------------------------------------------------------------------------------------

Bar solid_bar(CellShape shape, SolidKind kind) {
  // A single row of quadratic hexahedra has hourglass modes in common, by reduced integration.
  const int across = kind == SolidKind::reduced ? 2 : 1;
  SolidProblem problem(
      {8, across, across, shape},
      [](const Vector3d& cube) {
        return placed({length * cube.x(), width * (cube.y() - 0.5), height * (cube.z() - 0.5)});
      },
      material, kind);
  problem.load_side(0, 1.0, [](const Vector3d&, const Vector3d& normal) -> Vector3d { return pulled * normal; });
  Bar bar{.name = name_of(shape) + "_" + name_of(kind),
          .model = problem.model,
          .foot = problem.box.side(0, 0.0),
          .end = problem.box.side(0, 1.0),
          .pull = {.name = "pull"},
          .body = Body(mass_of_bar, {0.5 * length, 0.0, 0.0}, {length, width, height})};
  for (const auto node : bar.end)
    bar.pull.loads.push_back({node, problem.forces.segment<3>(6 * node), Vector3d::Zero()});
  const bool simplex = shape == CellShape::tetrahedron4 || shape == CellShape::wedge6;
  bar.exact.weight = bar.exact.rotation = simplex ? 0.03 : 1e-3;
  return bar;
}

std::vector<Bar> solid_bars() {
  std::vector<Bar> bars;
  for (const auto shape : solid_shapes)
    for (const auto kind : solid_kinds) bars.push_back(solid_bar(shape, kind));
  for (const auto shape : solid_shapes) bars.push_back(lumped(solid_bar(shape, SolidKind::standard)));
  return bars;
}

// Loads ---------------------------------------------------------------------------------------------------------------

std::vector<Bar> all_bars() {
  std::vector<Bar> bars = line_bars();
  for (auto& bar : shell_bars()) bars.push_back(std::move(bar));
  for (auto& bar : solid_bars()) bars.push_back(std::move(bar));
  for (auto& bar : bars) clamp_foot(bar);
  return bars;
}

class LoadsByElement : public testing::TestWithParam<Bar> {
protected:
  const Bar& bar = GetParam();

  /// Force and moment about the origin of all supports.
  [[nodiscard]] static Resultant reaction(const StaticSolution& solution) {
    const auto& sum = solution.reaction_sum;
    return {sum.force, sum.moment + sum.centre.cross(sum.force), Vector3d::Zero()};
  }
  void expect_carried(const StaticSolution& solution, const Resultant& load, double tolerance, bool moments) const {
    const Resultant found = reaction(solution);
    EXPECT_LT((found.force + load.force).norm(), tolerance * load.force.norm());
    if (moments) {
      EXPECT_LT((found.moment + load.moment).norm(), tolerance * (load.moment.norm() + length * load.force.norm()))
          << found.moment.transpose() << " against " << load.moment.transpose();
    }
    EXPECT_LT(solution.imbalance, 1e-9);
  }
  /// Along the bar, the mean of the nodes at its end.
  [[nodiscard]] double stretch(const StaticSolution& solution) const {
    double sum = 0.0;
    for (const auto node : bar.end) sum += solution.displacements.segment<3>(6 * node).dot(bar_axes().col(0));
    return sum / static_cast<double>(bar.end.size());
  }
};

TEST_P(LoadsByElement, ForcesAtTheEndStretchIt) {
  const auto solution = solve_statics(bar.model, bar.pull);
  const double expected = pulled * length / material.youngs_modulus;
  EXPECT_NEAR(stretch(solution), expected, bar.exact.force * expected);
  expect_carried(solution, {end_force(), placed({length, 0.0, 0.0}).cross(end_force()), Vector3d::Zero()}, 1e-9, true);
}

TEST_P(LoadsByElement, WeightInEveryDirection) {
  for (int axis = 0; axis < 3; ++axis) {
    const LoadCase load{.name = "weight", .gravity = 9.81 * bar_axes().col(axis)};
    const auto solution = solve_statics(bar.model, load);
    expect_carried(solution, bar.body.under(load.field()), 1e-9, true);
    const double expected = material.density * 9.81 * length * length / (2.0 * material.youngs_modulus);
    if (axis == 0) EXPECT_NEAR(stretch(solution), expected, bar.exact.weight * expected);
  }
}

// About an axis across the bar, through its foot and before it: N = rho A W^2 int_x^L (r + s) ds.
TEST_P(LoadsByElement, RotationAcrossIt) {
  for (const double before : {0.0, 0.5}) {
    const double speed = 80.0;
    const LoadCase load{.name = "turn", .rotation = Rotation{bar_axes().col(2), placed({-before, 0.0, 1.0}), speed}};
    const auto solution = solve_statics(bar.model, load);
    expect_carried(solution, bar.body.under(load.field()), bar.exact.moments ? 1e-9 : 1e-3, bar.exact.moments);
    const double expected = material.density * speed * speed / material.youngs_modulus *
                            (before * length * length / 2.0 + std::pow(length, 3) / 3.0);
    EXPECT_NEAR(stretch(solution), expected, bar.exact.rotation * expected);
  }
}

// About an axis askew that does not meet the bar: forces along it and across it, all linear in space.
TEST_P(LoadsByElement, RotationAboutAnyAxis) {
  const LoadCase load{.name = "turn", .rotation = Rotation{{1.0, -0.4, 2.0}, {-0.5, 2.0, 0.3}, 40.0}};
  expect_carried(solve_statics(bar.model, load), bar.body.under(load.field()), bar.exact.moments ? 1e-9 : 1e-3,
                 bar.exact.moments);
}

// The whole side of a strip, of a solid the face across the width; lines have no faces.
TEST_P(LoadsByElement, PressureOnItsFaces) {
  std::vector<Index> nodes;
  const bool is_solid = std::holds_alternative<SolidProperty>(bar.model.properties.begin()->second);
  for (Index i = 0; i < bar.model.mesh.node_count(); ++i)
    if (!is_solid || (bar_axes().transpose() * (bar.model.mesh.nodes.col(i) - foot_place())).y() > 0.49 * width)
      nodes.push_back(i);
  const LoadCase load{.name = "pressure", .pressures = {{faces_between_nodes(bar.model, nodes), 2e5}}};
  if (std::holds_alternative<BeamProperty>(bar.model.properties.begin()->second)) {
    EXPECT_TRUE(load.pressures[0].faces.empty());
    return;
  }
  const Vector3d force = -2e5 * length * (is_solid ? height * bar_axes().col(1) : width * bar_axes().col(2));
  const Vector3d middle = placed({0.5 * length, is_solid ? 0.5 * width : 0.0, 0.0});
  expect_carried(solve_statics(bar.model, load), {force, middle.cross(force), Vector3d::Zero()}, 1e-9, true);
}

INSTANTIATE_TEST_SUITE_P(Bars, LoadsByElement, testing::ValuesIn(all_bars()),
                         [](const auto& one) { return one.param.name; });

// Across a line that leans by 45 degrees the field grows linearly, q = q_0 s / L: M = q_0 L^2 / 3 at its foot, and
// 11 q_0 L^4 / (120 E I) at its end, whatever the number of beams.
TEST(BeamFields, RotationBendsABeamThatLeans) {
  auto property = beam_property(rectangular_section(width, height, 0.0));
  property.section.shear_factor_y = property.section.shear_factor_z = 0.0;
  property.placements[0].up = Vector3d::UnitY();
  for (const bool tapered : {false, true})
    for (const int count : {1, 3}) {
      if (tapered) property.stations = {{0.0, property.section}, {1.0, property.section}};
      const Vector3d along = Vector3d(1.0, 0.0, 1.0).normalized(), across = Vector3d(1.0, 0.0, -1.0).normalized();
      FiniteElementModel model = model_of(line_mesh(Vector3d::Zero(), length * along, count));
      model.materials["steel"] = material;
      model.properties["line"] = property;
      model.fixed = {{.name = "foot", .nodes = {0}}};
      const LoadCase load{.name = "turn", .rotation = Rotation{.speed = 30.0}};
      const auto solution = solve_statics(model, load);
      const double q = material.density * area * 30.0 * 30.0 * 0.5 * length;
      const double stiffness = material.youngs_modulus * property.section.inertia_z;
      const double expected = 11.0 * q * std::pow(length, 4) / (120.0 * stiffness);
      EXPECT_NEAR(solution.displacements.segment<3>(6 * count).dot(across), expected, 1e-9 * expected);
      const auto regions = recover_stresses(model, solution.displacements, load.field());
      const auto& root = regions[0].beams.front().ends[0];
      EXPECT_NEAR(std::hypot(root[4], root[5]), q * length * length / 3.0, 1e-9 * q * length * length);
      const auto& tip = regions[0].beams.back().ends[1];
      EXPECT_LT(tip.norm(), 1e-9 * q * length);
    }
}

// A box at the end of its arm, on six springs that show what acts on its node: as eight points of the box are pulled.
TEST(MassFields, AMassIsPulledAtItsOwnPlace) {
  const Vector3d sides(0.5, 0.3, 0.2), arm(0.4, -0.2, 0.6);
  const double mass = 12.0;
  const Matrix3d second = mass / 12.0 * Matrix3d(sides.cwiseAbs2().asDiagonal());
  const Matrix3d inertia = second.trace() * Matrix3d::Identity() - second;
  const Body body(mass, arm, sides);
  FiniteElementModel model;
  model.name = "mass";
  const Index node = add_node(model.mesh, foot_place());
  model.masses.push_back({.name = "box",
                          .node = node,
                          .mass = mass,
                          .inertia = bar_axes() * inertia * bar_axes().transpose(),
                          .offset = bar_axes() * arm});
  for (int direction = 0; direction < 6; ++direction)
    model.springs.push_back(
        {.name = direction_names[static_cast<std::size_t>(direction)], .from = {node, direction}, .stiffness = 1e6});
  for (const auto& load : {LoadCase{.name = "weight", .gravity = {1.0, -3.0, 9.0}},
                           LoadCase{.name = "turn", .rotation = Rotation{{1.0, -0.4, 2.0}, {-0.5, 2.0, 0.3}, 5.0}}}) {
    const Eigen::VectorXd found = 1e6 * solve_statics(model, load).displacements;
    const Resultant expected = body.under(load.field());
    const Vector3d moment = expected.moment - foot_place().cross(expected.force);
    EXPECT_LT((found.head<3>() - expected.force).norm(), 1e-9 * expected.force.norm()) << load.name;
    EXPECT_LT((found.tail<3>() - moment).norm(), 1e-9 * moment.norm()) << load.name;
  }
}

}  // namespace
}  // namespace kalfem::test
