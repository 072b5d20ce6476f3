// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "base/absent.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"
#include "model/calculix_deck.hpp"
#include "model/fe_models.hpp"
#include "model/shell_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Supports and loads of a model, and the output of displacements and nodal stresses.
void write_step(const FiniteElementModel& model, const Eigen::VectorXd& forces, std::ofstream& deck) {
  write_supports(model, deck);
  deck << "*STEP\n*STATIC\n";
  write_forces(forces, deck);
  deck << "*NODE FILE, OUTPUT=2D\nU\n*EL FILE, OUTPUT=2D\nS\n*END STEP\n";
}

/// Blocks of a .frd file by node: "DISP" and "STRESS" [xx yy zz xy yz zx].
std::map<std::string, std::map<Index, std::vector<double>>> read_frd(const std::filesystem::path& file) {
  std::map<std::string, std::map<Index, std::vector<double>>> blocks;
  std::ifstream stream(file);
  std::string line, block;
  while (std::getline(stream, line)) {
    if (line.starts_with(" -4")) std::istringstream(line.substr(3)) >> block;
    if (line.starts_with(" -3")) block.clear();
    if (!line.starts_with(" -1") || block.empty()) continue;
    auto& values = blocks[block][std::stol(line.substr(3, 10)) - 1];
    for (std::size_t at = 13; at + 12 <= line.size(); at += 12) values.push_back(std::stod(line.substr(at, 12)));
  }
  return blocks;
}

Stress stress_in(const std::vector<double>& values) { return Eigen::Map<const Stress>(values.data()); }

/// A quarter ring, clamped at one end, under pressure inside and a force along x at the other.
struct Ring {
  SolidProblem problem;
  LoadCase loads{.name = "ring"};

  Ring(const BoxCut& cut, SolidKind kind)
      : problem(
            cut,
            [](const Vector3d& cube) -> Vector3d {
              const double r = 1.0 + 0.5 * cube.x(), angle = 0.5 * std::numbers::pi * cube.y();
              return {r * std::cos(angle), r * std::sin(angle), 0.4 * cube.z()};
            },
            steel, kind) {
    problem.fix(problem.box.side(1, 0.0), {0, 1, 2});
    loads.pressures = {{faces_between_nodes(problem.model, problem.box.side(0, 0.0)), 2e7}};
    loads.loads = {{problem.box.at(0.5, 1.0, 0.5), {3e5, 0.0, 1e5}, Vector3d::Zero()}};
  }
};

struct Case {
  std::string type;
  BoxCut cut;
  SolidKind kind;
  double displacement, stress;  ///< relative tolerances, of the largest value
};

// The elements with the same integration have the same stresses to the digits of CalculiX's file; hexahedron8 has the
// enhanced strains that CalculiX implements in part, and other values at its edges (see nodal_stresses()).
TEST(StressesAgainstCalculiX, QuarterRingOfSolids) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  for (const auto& [type, cut, kind, displacement_tolerance, stress_tolerance] :
       {Case{"C3D20R", {3, 8, 2, CellShape::hexahedron20}, SolidKind::reduced, 1e-4, 1e-3},
        Case{"C3D10", {2, 6, 2, CellShape::tetrahedron10}, SolidKind::standard, 1e-4, 1e-3},
        Case{"C3D20R", {3, 8, 2, CellShape::hexahedron20}, SolidKind::standard, 0.01, 0.03},
        Case{"C3D8I", {6, 16, 4, CellShape::hexahedron8}, SolidKind::standard, 0.01, 0.03}}) {
    const Ring ring(cut, kind);
    const ScratchFolder folder("ring-" + type);
    {
      std::ofstream deck(folder / "ring.inp");
      write_mesh(ring.problem.model, type, steel, deck);
      deck << "*SOLID SECTION, ELSET=all, MATERIAL=material\n";
      write_step(ring.problem.model, nodal_forces(ring.problem.model, ring.loads), deck);
    }
    ASSERT_TRUE(run_calculix(folder, "ring"));
    const auto theirs = read_frd(folder / "ring.frd");
    const auto solution = solve_statics(ring.problem.model, ring.loads);
    double largest = 0.0, difference = 0.0;
    for (const auto& [node, values] : theirs.at("DISP")) {
      const Vector3d expected = Eigen::Map<const Vector3d>(values.data());
      largest = std::max(largest, expected.norm());
      difference = std::max(difference, (solution.displacements.segment<3>(6 * node) - expected).norm());
    }
    EXPECT_LT(difference, displacement_tolerance * largest) << type;
    const auto region = recover_stresses(ring.problem.model, solution.displacements)[0];
    double highest = 0.0, error = 0.0;
    for (const auto& mean : nodal_stresses(ring.problem.model.mesh, region)) {
      const Vector3d cube = ring.problem.box.cube.col(mean.node);
      const Stress expected = stress_in(theirs.at("STRESS").at(mean.node));
      highest = std::max(highest, von_mises(expected));
      // Of the linear elements, inside only: at the edges CalculiX's values are of the first order.
      const bool inside = ((cube.array() > 1e-9) && (cube.array() < 1.0 - 1e-9)).all();
      if (inside || cut.shape != CellShape::hexahedron8) error = std::max(error, von_mises(mean.stress - expected));
    }
    EXPECT_LT(error, stress_tolerance * highest) << type;
  }
}

// CalculiX makes solids with incompatible modes of its shells: another formulation on the same mesh.
TEST(StressesAgainstCalculiX, ClampedPlateOfShells) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const double t = 0.02, pressure = 1e5;
  const int count = 24;
  ShellProblem problem(
      {count, count, CellShape::quadrilateral4},
      [](double u, double v) -> Vector3d {
        return {u, 0.7 * v, 0.0};
      },
      steel, t);
  for (const char side : {'u', 'v'})
    for (const int end : {0, 1}) problem.fix(problem.grid.side(side, end), {0, 1, 2, 3, 4, 5});
  const LoadCase loads{
      .name = "pressure",
      .pressures = {{faces_of_cells(problem.model, problem.model.mesh.regions.at("shell")), pressure}}};
  const ScratchFolder folder("plate-S4");
  {
    std::ofstream deck(folder / "plate.inp");
    write_mesh(problem.model, "S4", steel, deck);
    deck << "*SHELL SECTION, ELSET=all, MATERIAL=material\n" << t << "\n";
    write_step(problem.model, nodal_forces(problem.model, loads), deck);
  }
  ASSERT_TRUE(run_calculix(folder, "plate"));
  const auto theirs = read_frd(folder / "plate.frd");
  const auto solution = solve_statics(problem.model, loads);
  const Index middle = problem.grid.node(count / 2, count / 2);
  const double expected = theirs.at("DISP").at(middle)[2];
  EXPECT_NEAR(solution.displacements[6 * middle + 2], expected, 0.01 * std::abs(expected));
}

}  // namespace
}  // namespace kalfem::test
