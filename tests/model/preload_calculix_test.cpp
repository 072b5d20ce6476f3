// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "base/absent.hpp"
#include "base/figures.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/calculix_deck.hpp"
#include "model/fe_models.hpp"
#include "model/preloaded.hpp"
#include "model/shell_models.hpp"
#include "model/solid_models.hpp"

// Frequencies of preloaded structures against CalculiX: a static step, and the modes of a perturbation of its state.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr int count = 6;

struct Deck {
  std::string type, section;
  std::string more = {};  ///< loads beside forces, "*DLOAD ..."
};

/// Frequencies [Hz] that CalculiX finds; without `preloaded` those without the loads.
std::vector<double> calculix_frequencies(const FiniteElementModel& model, const LoadCase& load, const Deck& given,
                                         bool preloaded) {
  const ScratchFolder folder("preload-" + given.type);
  {
    std::ofstream deck(folder / "model.inp");
    write_mesh(model, given.type, steel, deck);
    deck << given.section;
    write_supports(model, deck);
    if (preloaded) {
      deck << "*STEP, NLGEOM\n*STATIC\n1., 1.\n";
      if (!load.loads.empty() || !load.pressures.empty()) write_forces(nodal_forces(model, load), deck);
      deck << given.more << "*END STEP\n*STEP, PERTURBATION\n";
    } else {
      deck << "*STEP\n";
    }
    deck << "*FREQUENCY\n" << count << "\n*END STEP\n";
  }
  EXPECT_TRUE(run_calculix(folder, "model"));
  return frequencies_in(folder / "model.dat");
}

/// Worst relative difference of the frequencies under the load. They must differ by far more from those without it.
double worst_difference(const FiniteElementModel& model, const LoadCase& load, const Deck& deck) {
  const auto theirs = calculix_frequencies(model, load, deck, true);
  const auto unloaded = calculix_frequencies(model, load, deck, false);
  const Eigen::VectorXd ours = preloaded_frequencies(model, load, count);
  if (theirs.size() < count || unloaded.size() < count || ours.size() < count) {
    ADD_FAILURE() << theirs.size() << " modes of CalculiX, " << ours.size() << " of ours";
    return 1.0;
  }
  EXPECT_GT(std::abs(theirs[0] / unloaded[0] - 1.0), 0.1) << "the preload hardly matters";
  double worst = 0.0;
  std::string rows;
  for (int i = 0; i < count; ++i) {
    const auto place = static_cast<std::size_t>(i);
    worst = std::max(worst, std::abs(ours[i] / theirs[place] - 1.0));
    rows +=
        std::to_string(ours[i]) + " " + std::to_string(theirs[place]) + " " + std::to_string(unloaded[place]) + "\n";
  }
  EXPECT_LT(worst, 0.01) << rows;
  return worst;
}

const std::string solid_section = "*SOLID SECTION, ELSET=all, MATERIAL=material\n";

SolidProblem bar(SolidKind kind, CellShape shape, const BoxCut& cut) {
  SolidProblem problem(
      {cut.u, cut.v, cut.w, shape},
      [](const Vector3d& cube) -> Vector3d {
        return {cube.x(), 0.05 * cube.y(), 0.02 * cube.z()};
      },
      steel, kind);
  problem.fix(problem.box.side(0, 0.0), {0, 1, 2});
  return problem;
}

TEST(PreloadAgainstCalculiX, TensionedBarOfSolids) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const auto problem = bar(SolidKind::reduced, CellShape::hexahedron20, {12, 2, 2});
  const auto end = faces_between_nodes(problem.model, problem.box.side(0, 1.0));
  const LoadCase pull{.name = "pull", .pressures = {{end, -2e7}}};
  expect_figure("static.calculix.bar", worst_difference(problem.model, pull, {"C3D20R", solid_section}));
}

TEST(PreloadAgainstCalculiX, RotatingBladeOfSolids) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const auto problem = bar(SolidKind::reduced, CellShape::hexahedron20, {12, 2, 2});
  const double speed = 200.0;
  const LoadCase turn{.name = "turn", .rotation = Rotation{{0.0, 0.0, 1.0}, {-0.1, 0.025, 0.0}, speed}};
  const Deck deck{"C3D20R", solid_section, "*DLOAD\nall, CENTRIF, 40000., -0.1, 0.025, 0., 0., 0., 1.\n"};
  expect_figure("static.calculix.blade", worst_difference(problem.model, turn, deck));
}

TEST(PreloadAgainstCalculiX, PlateOfShellsUnderMembraneForce) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const double thickness = 0.01;
  ShellProblem problem(
      {24, 16, CellShape::quadrilateral4},
      [](double u, double v) -> Vector3d {
        return {u, 0.7 * v, 0.0};
      },
      steel, thickness);
  problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  problem.fix(problem.grid.side('u', 1), {1, 2});
  LoadCase pull{.name = "pull"};
  const auto edge = problem.grid.side('u', 1);
  for (std::size_t i = 0; i < edge.size(); ++i) {
    const double share = (i == 0 || i + 1 == edge.size() ? 0.5 : 1.0) / 16.0;
    pull.loads.push_back({edge[i], {5e5 * share, 0.0, 0.0}, Vector3d::Zero()});
  }
  const Deck deck{"S4", "*SHELL SECTION, ELSET=all, MATERIAL=material\n" + std::to_string(thickness) + "\n"};
  expect_figure("static.calculix.plate", worst_difference(problem.model, pull, deck));
}

}  // namespace
}  // namespace kalfem::test
