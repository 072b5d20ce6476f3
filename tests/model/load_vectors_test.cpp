// SPDX-License-Identifier: Apache-2.0
// Load vectors by element: nodal forces, forces of an edge, pressure, gravity and rotation of every shell and solid,
// against states of stress that the elements hold exactly.
#include <gtest/gtest.h>

#include "kalfem/model/mesh/split_quadratic_shells.hpp"
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

constexpr double thickness = 0.01;

Matrix3d plane(double xx, double yy, double xy) { return Matrix3d{{xx, xy, 0.0}, {xy, yy, 0.0}, {0.0, 0.0, 0.0}}; }

/// How a plate is cut into shells.
enum class Cells { quadrilaterals, triangles, alternating, mixed, quadrilaterals8, triangles6 };

const char* to_string(Cells cells) {
  constexpr std::array names = {"quadrilaterals", "triangles", "alternating", "mixed", "quadrilaterals8", "triangles6"};
  return names[static_cast<std::size_t>(cells)];
}

struct PlateCut {
  Cells cells;
  int nx, ny;
  bool distorted = false;  ///< all nodes off their places, those of the edges too
  bool is_quadratic() const { return cells == Cells::quadrilaterals8 || cells == Cells::triangles6; }
};

/// A plate a x b in the x-y plane with the lines of its edges.
struct Plate {
  FiniteElementModel model;
  PlateCut cut;
  double a, b;
  std::vector<std::pair<std::string, Index>> lines;  ///< counter-clockwise, with the edge they belong to

  Plate(const PlateCut& the_cut, double length, double width) : cut(the_cut), a(length), b(width) {
    model = model_of({});
    model.mesh.source = "plate";
    const int step = cut.is_quadratic() ? 2 : 1;
    for (int j = 0; j <= step * cut.ny; ++j)
      for (int i = 0; i <= step * cut.nx; ++i) {
        if (i % step == 1 && j % step == 1 && cut.cells == Cells::quadrilaterals8) continue;
        numbers_[{i, j}] = add_node(model.mesh, place(i, j, step));
      }
    for (int j = 0; j < cut.ny; ++j)
      for (int i = 0; i < cut.nx; ++i) add_cells(i, j);
    model.properties["plate"] = ShellProperty{"steel", thickness};
    add_lines(step);
    if (cut.is_quadratic()) replace_quadratic(model);
  }

  [[nodiscard]] Index corner(int i, int j) const {
    const int step = cut.is_quadratic() ? 2 : 1;
    return numbers_.at({step * i * cut.nx, step * j * cut.ny});
  }

private:
  Vector3d place(int i, int j, int step) const {
    const auto corner_place = [&](int ci, int cj) {
      double x = ci, y = cj;
      if (cut.distorted) x += 0.15 * ((ci + 2 * cj) % 3 - 1), y += 0.15 * ((2 * ci + cj + 1) % 3 - 1);
      return Vector3d(a * x / cut.nx, b * y / cut.ny, 0.0);
    };
    if (step == 1) return corner_place(i, j);
    return 0.25 * (corner_place(i / 2, j / 2) + corner_place((i + 1) / 2, j / 2) + corner_place(i / 2, (j + 1) / 2) +
                   corner_place((i + 1) / 2, (j + 1) / 2));
  }

  void add_cells(int i, int j) {
    const auto n = [&](int di, int dj) {
      return cut.is_quadratic() ? numbers_.at({2 * i + di, 2 * j + dj}) : numbers_.at({i + di / 2, j + dj / 2});
    };
    const auto add = [&](CellShape shape, const std::vector<Index>& nodes) {
      add_cell(model.mesh, "plate", shape, nodes);
    };
    const bool as_quad = cut.cells == Cells::quadrilaterals || (cut.cells == Cells::mixed && (i + j) % 2 == 1);
    if (cut.cells == Cells::quadrilaterals8) {
      add(CellShape::quadrilateral8, {n(0, 0), n(2, 0), n(2, 2), n(0, 2), n(1, 0), n(2, 1), n(1, 2), n(0, 1)});
    } else if (cut.cells == Cells::triangles6) {
      add(CellShape::triangle6, {n(0, 0), n(2, 0), n(2, 2), n(1, 0), n(2, 1), n(1, 1)});
      add(CellShape::triangle6, {n(0, 0), n(2, 2), n(0, 2), n(1, 1), n(1, 2), n(0, 1)});
    } else if (as_quad) {
      add(CellShape::quadrilateral4, {n(0, 0), n(2, 0), n(2, 2), n(0, 2)});
    } else if (cut.cells == Cells::alternating && (i + j) % 2 == 1) {
      add(CellShape::triangle3, {n(0, 0), n(2, 0), n(0, 2)});
      add(CellShape::triangle3, {n(2, 0), n(2, 2), n(0, 2)});
    } else {
      add(CellShape::triangle3, {n(0, 0), n(2, 0), n(2, 2)});
      add(CellShape::triangle3, {n(0, 0), n(2, 2), n(0, 2)});
    }
  }

  /// Cells of the lines of the edges "x0" to "y1", in no region.
  void add_lines(int step) {
    const auto line = [&](const std::string& region, std::array<int, 2> from, std::array<int, 2> to) {
      std::vector<Index> nodes = {numbers_.at(from), numbers_.at(to)};
      if (step == 2) nodes.push_back(numbers_.at({(from[0] + to[0]) / 2, (from[1] + to[1]) / 2}));
      lines.push_back({region, model.mesh.add_cell(step == 2 ? CellShape::line3 : CellShape::line2,
                                                   static_cast<std::int64_t>(model.mesh.cells.size()) + 1, nodes)});
    };
    for (int i = 0; i < cut.nx; ++i) {
      line("y0", {step * i, 0}, {step * (i + 1), 0});
      line("y1", {step * (i + 1), step * cut.ny}, {step * i, step * cut.ny});
    }
    for (int j = 0; j < cut.ny; ++j) {
      line("x1", {step * cut.nx, step * j}, {step * cut.nx, step * (j + 1)});
      line("x0", {0, step * (j + 1)}, {0, step * j});
    }
  }

  std::map<std::array<int, 2>, Index> numbers_;
};

void hold(FiniteElementModel& model, const std::vector<Index>& nodes, const std::vector<int>& directions) {
  FixedNodes fixed{"support " + std::to_string(model.fixed.size() + 1), nodes, {}};
  fixed.directions.fill(false);
  for (const int direction : directions) fixed.directions[static_cast<std::size_t>(direction)] = true;
  model.fixed.push_back(fixed);
}

std::vector<Index> all_nodes(const FiniteElementModel& model) {
  std::vector<Index> nodes;
  for (Index i = 0; i < model.mesh.node_count(); ++i) nodes.push_back(i);
  return nodes;
}

/// Forces of the stress on the edges, line by line as `forces: {at: edge}` shares them.
LoadCase edge_forces(const Plate& plate, const Matrix3d& stress) {
  LoadCase load{.name = "edges"};
  for (const auto& [edge, index] : plate.lines) {
    const auto nodes = plate.model.mesh.nodes_of(plate.model.mesh.cells[static_cast<std::size_t>(index)]);
    const Vector3d along = plate.model.mesh.nodes.col(nodes[1]) - plate.model.mesh.nodes.col(nodes[0]);
    const Vector3d force = thickness * stress * along.cross(Vector3d::UnitZ());
    for (const auto& [node, share] : uniform_shares(plate.model.mesh, {index}))
      load.loads.push_back({node, share * force, Vector3d::Zero()});
  }
  return load;
}

class PlateLoads : public testing::TestWithParam<PlateCut> {};

/// Stresses [xx yy xy] of all cells against one state, relative.
void expect_stress(const FiniteElementModel& model, const Eigen::VectorXd& displacements, const Matrix3d& stress,
                   double tolerance) {
  const auto regions = recover_stresses(model, displacements);
  for (const auto& cell : regions[0].cells)
    for (const auto& layer : cell.layers)
      for (Index i = 0; i < layer.at_nodes.cols(); ++i) {
        const Stress s = layer.at_nodes.col(i);
        const Matrix3d found{{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
        ASSERT_LT((found - stress).norm(), tolerance * stress.norm()) << s.transpose() << " in cell " << cell.cell;
      }
}

// Three states of constant stress by nodal forces alone: the displacements are linear, so every element holds them.
TEST_P(PlateLoads, NodalForcesOfAConstantStressAreInEquilibriumWithIt) {
  for (const auto& stress : {plane(1e8, 0.0, 0.0), plane(0.0, 7e7, 0.0), plane(2e7, -3e7, 5e7)}) {
    Plate plate(GetParam(), 1.0, 0.8);
    hold(plate.model, all_nodes(plate.model), {2, 3, 4});
    hold(plate.model, {plate.corner(0, 0)}, {0, 1, 5});
    const auto solution = solve_statics(plate.model, edge_forces(plate, stress));
    expect_stress(plate.model, solution.displacements, stress, 1e-9);
    const double e = steel.youngs_modulus;
    const Vector3d arm =
        plate.model.mesh.nodes.col(plate.corner(1, 1)) - plate.model.mesh.nodes.col(plate.corner(0, 0));
    const Matrix3d strain = 1.3 / e * stress - 0.3 / e * stress.trace() * Matrix3d::Identity();
    const Vector3d moved = (strain * arm).head<2>().homogeneous() - Vector3d::UnitZ();
    EXPECT_LT((solution.displacements.segment<3>(6 * plate.corner(1, 1)) - moved).norm(), 1e-8 * moved.norm());
    EXPECT_LT(solution.imbalance, 1e-9);
  }
}

// The usual symmetric support of a pulled plate: rollers along an edge, which nodal forces reach too.
TEST_P(PlateLoads, APlateOnRollersIsPulledEvenly) {
  if (GetParam().distorted) return;  // its edges are not straight
  Plate plate(GetParam(), 1.0, 1.0);
  hold(plate.model, all_nodes(plate.model), {2});
  std::set<Index> edge;
  LoadCase pull{.name = "pull"};
  for (const auto& [name, index] : plate.lines) {
    const auto nodes = plate.model.mesh.nodes_of(plate.model.mesh.cells[static_cast<std::size_t>(index)]);
    if (name == "x0") edge.insert(nodes.begin(), nodes.end());
    if (name != "x1") continue;
    for (const auto& [node, share] : uniform_shares(plate.model.mesh, {index}))
      pull.loads.push_back({node, {share * 1e8 * thickness / plate.cut.ny, 0.0, 0.0}, Vector3d::Zero()});
  }
  hold(plate.model, {edge.begin(), edge.end()}, {0});
  hold(plate.model, {plate.corner(0, 0)}, {1});
  const auto solution = solve_statics(plate.model, pull);
  expect_stress(plate.model, solution.displacements, plane(1e8, 0.0, 0.0), 1e-9);
  const Vector3d corner = solution.displacements.segment<3>(6 * plate.corner(1, 1));
  EXPECT_NEAR(corner.x(), 1e8 / steel.youngs_modulus, 1e-9 * corner.x());
  EXPECT_NEAR(corner.y(), -0.3e8 / steel.youngs_modulus, 1e-9 * corner.x());
}

// With the rotations about the normal held everywhere the elements are membranes; a constant shear turns them.
TEST_P(PlateLoads, HeldDrillingRotationsDoNotHoldTheSurface) {
  const Matrix3d stress = plane(2e7, -3e7, 5e7);
  Plate plate(GetParam(), 1.0, 0.8);
  hold(plate.model, all_nodes(plate.model), {2, 3, 4, 5});
  hold(plate.model, {plate.corner(0, 0)}, {0, 1});
  hold(plate.model, {plate.corner(1, 0)}, {1});
  const auto solution = solve_statics(plate.model, edge_forces(plate, stress));
  expect_stress(plate.model, solution.displacements, stress, 1e-9);
}

// Hanging by an edge, nu = 0: rho g (1 - x) everywhere, and no more where the edge ends.
TEST_P(PlateLoads, WeightInThePlaneHangsAsABarDoes) {
  if (GetParam().distorted) return;
  Plate plate(GetParam(), 1.0, 1.0);
  plate.model.materials["steel"].poissons_ratio = 0.0;
  hold(plate.model, all_nodes(plate.model), {2});
  std::set<Index> edge;
  for (const auto& [name, index] : plate.lines) {
    const auto nodes = plate.model.mesh.nodes_of(plate.model.mesh.cells[static_cast<std::size_t>(index)]);
    if (name == "x0") edge.insert(nodes.begin(), nodes.end());
  }
  hold(plate.model, {edge.begin(), edge.end()}, {0});
  hold(plate.model, {plate.corner(0, 0)}, {1});
  const double weight = steel.density * 10.0;
  const auto solution = solve_statics(plate.model, {.name = "weight", .gravity = {10.0, 0.0, 0.0}});
  const double end = weight / (2.0 * steel.youngs_modulus);
  // Where all diagonals run one way, or triangles lie on one side, their weight bends the plate a little: the mean of
  // both corners, 2.7 % beside the bar in the mixed plate.
  const double found =
      0.5 * (solution.displacements[6 * plate.corner(1, 0)] + solution.displacements[6 * plate.corner(1, 1)]);
  EXPECT_NEAR(found, end, 0.03 * end);
  const auto regions = recover_stresses(plate.model, solution.displacements);
  for (const auto& cell : regions[0].cells) EXPECT_LT(cell.layers[1].centre[0], 1.1 * weight) << cell.cell;
}

INSTANTIATE_TEST_SUITE_P(Cells, PlateLoads,
                         testing::Values(PlateCut{Cells::quadrilaterals, 4, 4}, PlateCut{Cells::triangles, 1, 1},
                                         PlateCut{Cells::triangles, 4, 4}, PlateCut{Cells::triangles, 16, 16},
                                         PlateCut{Cells::alternating, 4, 3}, PlateCut{Cells::mixed, 4, 4},
                                         PlateCut{Cells::quadrilaterals8, 2, 2}, PlateCut{Cells::triangles6, 2, 2},
                                         PlateCut{Cells::quadrilaterals, 3, 4, true},
                                         PlateCut{Cells::triangles, 4, 4, true}, PlateCut{Cells::mixed, 4, 3, true},
                                         PlateCut{Cells::triangles6, 3, 2, true}),
                         [](const auto& one) {
                           return std::string(to_string(one.param.cells)) + "_" + std::to_string(one.param.nx) + "x" +
                                  std::to_string(one.param.ny) + (one.param.distorted ? "_distorted" : "");
                         });

// Springs at an edge load it by nodal forces too.
TEST(PlateLoadsOfOthers, SpringsHoldAnEdgeEvenly) {
  Plate plate({Cells::triangles, 4, 4}, 1.0, 1.0);
  hold(plate.model, all_nodes(plate.model), {2});
  LoadCase pull{.name = "pull"};
  for (const auto& [name, index] : plate.lines) {
    const auto nodes = plate.model.mesh.nodes_of(plate.model.mesh.cells[static_cast<std::size_t>(index)]);
    for (std::size_t i = 0; i < 2; ++i) {
      if (name == "x1") pull.loads.push_back({nodes[i], {0.125 * 1e8 * thickness, 0.0, 0.0}, Vector3d::Zero()});
      // Springs to the ground whose stiffness is that of the length of edge that they hold.
      if (name == "x0")
        plate.model.springs.push_back(
            {.name = "s" + std::to_string(plate.model.springs.size()), .from = {nodes[i], 0}, .stiffness = 1e9});
    }
  }
  hold(plate.model, {plate.corner(0, 0)}, {1});
  const auto solution = solve_statics(plate.model, pull);
  expect_stress(plate.model, solution.displacements, plane(1e8, 0.0, 0.0), 1e-9);
}

// The same pressure on all faces of a distorted block: p everywhere.
TEST(SolidLoads, PressureAllAroundIsTheStressEverywhere) {
  for (const auto shape : solid_shapes) {
    SolidProblem problem(
        {2, 2, 2, shape, 0.1},
        [](const Vector3d& cube) -> Vector3d {
          return {cube.x() + 0.1 * cube.y(), 0.8 * cube.y(), 0.6 * cube.z() + 0.1 * cube.x()};
        },
        steel);
    problem.fix({problem.box.at(0, 0, 0)}, {0, 1, 2});
    problem.fix({problem.box.at(1, 0, 0)}, {1, 2});
    problem.fix({problem.box.at(0, 1, 0)}, {2});
    LoadCase load{.name = "around"};
    for (int axis = 0; axis < 3; ++axis)
      for (const double end : {0.0, 1.0})
        load.pressures.push_back({faces_between_nodes(problem.model, problem.box.side(axis, end)), 3e7});
    const auto solution = solve_statics(problem.model, load);
    SCOPED_TRACE(name_of(shape));
    expect_stress(problem.model, solution.displacements, -3e7 * Matrix3d::Identity(), 1e-9);
  }
}

// Nodal forces of a constant stress on the faces of a block, for all shapes and kinds.
TEST(SolidLoads, NodalForcesOfAConstantStressAreInEquilibriumWithIt) {
  const Matrix3d stress{{4e7, 1e7, -2e7}, {1e7, -3e7, 2e7}, {-2e7, 2e7, 5e7}};
  for (const auto shape : solid_shapes)
    for (const auto kind : solid_kinds) {
      SolidProblem problem(
          {2, 2, 2, shape, 0.1}, [](const Vector3d& cube) -> Vector3d { return cube; }, steel, kind);
      for (int axis = 0; axis < 3; ++axis)
        for (const double end : {0.0, 1.0})
          problem.load_side(axis, end,
                            [&](const Vector3d&, const Vector3d& normal) -> Vector3d { return stress * normal; });
      problem.fix({problem.box.at(0, 0, 0)}, {0, 1, 2});
      problem.fix({problem.box.at(1, 0, 0)}, {1, 2});
      problem.fix({problem.box.at(0, 1, 0)}, {2});
      LoadCase load{.name = "faces"};
      for (Index i = 0; i < problem.box.cube.cols(); ++i)
        load.loads.push_back({i, problem.forces.segment<3>(6 * i), Vector3d::Zero()});
      const auto solution = solve_statics(problem.model, load);
      SCOPED_TRACE(name_of(shape) + " " + name_of(kind));
      expect_stress(problem.model, solution.displacements, stress, 1e-8);
    }
}

// A column, nu = 0: its own weight, and the rotation about an axis through its foot. The quadratic shapes hold the
// displacement of the weight, and linear hexahedra that of the nodes.
TEST(SolidLoads, WeightAndRotationOfAColumn) {
  const double e = steel.youngs_modulus, rho = steel.density, length = 2.0, speed = 50.0;
  for (const auto shape : solid_shapes) {
    auto material = steel;
    material.poissons_ratio = 0.0;
    SolidProblem problem(
        {1, 1, 8, shape},
        [&](const Vector3d& cube) -> Vector3d {
          return {0.1 * cube.x(), 0.1 * cube.y(), length * cube.z()};
        },
        material);
    problem.fix(problem.box.side(2, 0.0), {2});
    problem.fix({problem.box.at(0, 0, 0)}, {0, 1});
    problem.fix({problem.box.at(1, 0, 0)}, {1});
    const auto mean_end = [&](const LoadCase& load) {
      const auto solution = solve_statics(problem.model, load);
      double sum = 0.0;
      const auto top = problem.box.side(2, 1.0);
      for (const auto node : top) sum += solution.displacements[6 * node + 2] / static_cast<double>(top.size());
      return sum;
    };
    const bool exact = shape != CellShape::tetrahedron4 && shape != CellShape::wedge6;
    const double weight = rho * 10.0 * length * length / (2.0 * e);
    EXPECT_NEAR(mean_end({.name = "weight", .gravity = {0.0, 0.0, 10.0}}), weight, (exact ? 1e-9 : 0.05) * weight)
        << name_of(shape);
    const double stretch = rho * speed * speed * length * length * length / (3.0 * e);
    EXPECT_NEAR(mean_end({.name = "turn",
                          .rotation = Rotation{.axis = {1.0, 0.0, 0.0}, .about = {0.0, 0.05, 0.0}, .speed = speed}}),
                stretch, 0.02 * stretch)
        << name_of(shape);
  }
}

}  // namespace
}  // namespace kalfem::test
