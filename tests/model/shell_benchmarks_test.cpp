// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "base/figures.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "model/fe_models.hpp"
#include "shell_models.hpp"

// Problems with published values, by quadrilaterals and triangles on even and on distorted meshes. [MH85]: MacNeal and
// Harder, Finite Elements in Analysis and Design 1 (1985) 3-20. [NAFEMS]: Abbassian, Dawswell, Knowles, Selected
// benchmarks for natural frequency analysis, 1987.

namespace kalfem {
namespace {

using std::numbers::pi;
using test::Cut;
using test::frequencies;
using test::nafems_steel;
using test::ShellProblem;

struct Kind {
  CellShape shape;
  bool distorted;

  [[nodiscard]] bool quadrilateral() const { return shape == CellShape::quadrilateral4; }
};

/// Results on finer and finer meshes over the published value.
struct Convergence {
  std::vector<int> counts;
  std::vector<double> ratios;

  [[nodiscard]] double last_error() const { return std::abs(ratios.back() - 1.0); }
  /// Each mesh is nearer than the one before, or nearer than `settled`: as much do the published values, and the models
  /// behind them, differ (0.0924 to 0.0940 for the hemisphere, 0.3006 to 0.3024 for the roof).
  [[nodiscard]] bool improves(double settled = 0.0075) const {
    for (std::size_t i = 1; i < ratios.size(); ++i) {
      const double now = std::abs(ratios[i] - 1.0);
      if (now > std::abs(ratios[i - 1] - 1.0) && now > settled) return false;
    }
    return true;
  }
  [[nodiscard]] std::string table() const {
    std::ostringstream text;
    for (std::size_t i = 0; i < ratios.size(); ++i) text << counts[i] << ": " << ratios[i] << "\n";
    return text.str();
  }
};

template <typename Problem>
Convergence converge(const Kind& kind, const std::vector<int>& counts, const Problem& problem) {
  Convergence convergence;
  for (const int count : counts) {
    convergence.counts.push_back(count);
    convergence.ratios.push_back(problem(Cut{count, count, kind.shape, kind.distorted}));
    testing::Test::RecordProperty("mesh_" + std::to_string(count), std::to_string(convergence.ratios.back()));
  }
  return convergence;
}

class ShellBenchmarks : public testing::TestWithParam<Kind> {
protected:
  /// The ratios on meshes of 8, 16 and 32 cells a side, which docs/accuracy.md shows.
  void expect_figures(const std::string& problem, const Convergence& convergence) const {
    const std::string kind = std::string(GetParam().quadrilateral() ? "quadrilaterals" : "triangles") +
                             (GetParam().distorted ? ".distorted." : ".even.");
    for (std::size_t i = 0; i < convergence.counts.size(); ++i)
      if (const int count = convergence.counts[i]; count >= 8 && count <= 32)
        test::expect_figure("shells." + problem + "." + kind + std::to_string(count), convergence.ratios[i]);
  }
  /// Finest mesh within `tolerance` of the published value, and the finer the nearer. With a figure, the tolerance is
  /// what the published value is good for, and the figure holds the value itself to its digits.
  template <typename Problem>
  void expect_convergence(const std::vector<int>& counts, double tolerance, const Problem& problem,
                          const std::string& figure = "") {
    const auto convergence = converge(GetParam(), counts, problem);
    if (!figure.empty()) expect_figures(figure, convergence);
    EXPECT_LT(convergence.last_error(), tolerance) << convergence.table();
    EXPECT_TRUE(convergence.improves()) << convergence.table();
  }
};

// Static ------------------------------------------------------------------------------------------------------------

/// Tapered panel 48 wide, 44 and 16 high, t = 1, E = 1, nu = 1/3, clamped, unit shear at the other end: v = 23.96.
double cooks_membrane(const Cut& cut) {
  ShellProblem problem(
      cut, [](double u, double v) { return Eigen::Vector3d(48.0 * u, 44.0 * u + v * (44.0 - 28.0 * u), 0.0); },
      {1.0, 1.0 / 3.0, 1.0}, 1.0);
  problem.fix(problem.grid.all(), {2, 3, 4});
  problem.fix(problem.grid.side('u', 0), {0, 1, 5});
  problem.load_side(problem.grid.side('u', 1), 1, 1.0);
  return test::displacement(problem, problem.grid.node(cut.count_u, cut.count_v / 2), 1) / 23.96;
}

TEST_P(ShellBenchmarks, CooksMembrane) { expect_convergence({4, 8, 16, 32}, 0.01, cooks_membrane, "cook"); }

/// Barrel roof on diaphragms under its weight, a quarter: 0.3024 [MH85]; the deep-shell solution is 0.3006.
double scordelis_lo_roof(const Cut& cut) {
  const double angle = 40.0 * pi / 180.0;
  ShellProblem problem(
      cut,
      [&](double u, double v) {
        return Eigen::Vector3d(25.0 * std::sin(angle * u), 25.0 * v, 25.0 * std::cos(angle * u));
      },
      {4.32e8, 0.0, 1.0}, 0.25);
  problem.fix(problem.grid.side('v', 1), {0, 2});
  problem.fix(problem.grid.side('v', 0), {1, 3, 5});
  problem.fix(problem.grid.side('u', 0), {0, 4, 5});
  problem.load_area(2, -90.0);
  return -test::displacement(problem, problem.grid.node(cut.count_u, 0), 2) / 0.3024;
}

TEST_P(ShellBenchmarks, ScordelisLoRoof) { expect_convergence({4, 8, 16, 32}, 0.01, scordelis_lo_roof, "roof"); }

/// Cylinder on diaphragms pinched by two unit forces, an eighth: 1.8248e-5 under the force.
double pinched_cylinder(const Cut& cut) {
  ShellProblem problem(
      cut,
      [](double u, double v) {
        return Eigen::Vector3d(300.0 * std::sin(0.5 * pi * u), 300.0 * v, 300.0 * std::cos(0.5 * pi * u));
      },
      {3e6, 0.3, 1.0}, 3.0);
  problem.fix(problem.grid.side('v', 1), {0, 2});
  problem.fix(problem.grid.side('v', 0), {1, 3, 5});
  problem.fix(problem.grid.side('u', 0), {0, 4, 5});
  problem.fix(problem.grid.side('u', 1), {2, 3, 4});
  problem.load(problem.grid.node(0, 0), 2, -0.25);
  return -test::displacement(problem, problem.grid.node(0, 0), 2) / 1.8248e-5;
}

TEST_P(ShellBenchmarks, PinchedCylinder) {
  // The dimple is as wide as sqrt(R t) = 30, four to five cells of the finest mesh. Quadrilaterals pass the published
  // value, of a shell without shear deformation, by .7 %; triangles come within .04 %.
  expect_convergence({8, 16, 32, 64}, GetParam().quadrilateral() ? 0.01 : 0.001, pinched_cylinder, "cylinder");
}

/// Hemisphere with a hole of 18 degrees pulled and pushed at its rim, a quarter: 0.0940 [MH85], 0.0924 by series; the
/// finest meshes of many elements go to 0.0935.
double hemisphere(const Cut& cut) {
  ShellProblem problem(
      cut,
      [](double u, double v) {
        const double a = 0.5 * pi * u, b = 0.4 * pi * v;
        return Eigen::Vector3d(10.0 * std::cos(a) * std::cos(b), 10.0 * std::sin(a) * std::cos(b), 10.0 * std::sin(b));
      },
      {6.825e7, 0.3, 1.0}, 0.04);
  problem.fix(problem.grid.side('u', 0), {1, 3, 5});
  problem.fix(problem.grid.side('u', 1), {0, 4, 5});
  problem.fix({problem.grid.node(0, cut.count_v)}, {2});
  problem.load(problem.grid.node(0, 0), 0, 1.0);
  problem.load(problem.grid.node(cut.count_u, 0), 1, -1.0);
  return test::displacement(problem, problem.grid.node(0, 0), 0) / 0.0935;
}

TEST_P(ShellBenchmarks, HemisphereWithHole) { expect_convergence({4, 8, 16, 32}, 0.01, hemisphere, "hemisphere"); }

/// Strip 12 x 1.1 twisted by a right angle, clamped, a force at the end along its width or across it [MH85].
double twisted_strip(const Cut& cut, double thickness, int direction, double force, double published) {
  ShellProblem problem(
      {6 * cut.count_u, cut.count_v, cut.shape, cut.distorted},
      [](double u, double v) {
        const double angle = 0.5 * pi * u, y = 1.1 * (v - 0.5);
        return Eigen::Vector3d(12.0 * u, y * std::cos(angle), y * std::sin(angle));
      },
      {29e6, 0.22, 1.0}, thickness);
  problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  problem.load_side(problem.grid.side('u', 1), direction, force);
  const Eigen::Index end = problem.grid.node(6 * cut.count_u, cut.count_v / 2);
  return test::displacement(problem, end, direction) / published;
}

TEST_P(ShellBenchmarks, TwistedStripThick) {
  // found .0010 to .0049
  expect_convergence({2, 4, 8}, 0.006, [](const Cut& cut) { return twisted_strip(cut, 0.32, 2, 1.0, 5.424e-3); });
  expect_convergence({2, 4, 8}, 0.006, [](const Cut& cut) { return twisted_strip(cut, 0.32, 1, 1.0, 1.754e-3); });
}

TEST_P(ShellBenchmarks, TwistedStripThin) {
  // 3750 times as long as thick [BWS89]. Even quadrilaterals need no more than the thick strip does; on the others the
  // facets bend against each other in their planes, which dies out with h^2.
  const bool even = GetParam().quadrilateral() && !GetParam().distorted;
  const std::vector<int> counts = even ? std::vector<int>{2, 4, 8} : std::vector<int>{4, 8, 16};
  const double tolerance = even ? 0.004 : 0.025;  // found .0019 and .0149
  expect_convergence(counts, tolerance, [](const Cut& cut) { return twisted_strip(cut, 0.0032, 2, 1e-6, 5.256e-3); });
  expect_convergence(counts, tolerance, [](const Cut& cut) { return twisted_strip(cut, 0.0032, 1, 1e-6, 1.294e-3); });
}

/// How the sides between the six cells of a straight beam lean, by 45 degrees.
enum class Lean { none, trapezoids, parallelograms };

/// Straight beam 6 x 0.2 x 0.1 of [MH85], `count` x `count` elements in each of its six cells: displacement at the end
/// along a unit force in its plane (1) or across it (2).
double straight_beam(const Cut& cut, Lean lean, int direction) {
  const auto shift = [lean](double joint) {  // of the upper end of a side, in widths; linear between joints
    const auto at = [lean](int number) {
      if (lean == Lean::none || number <= 0 || number >= 6) return 0.0;
      return lean == Lean::parallelograms || number % 2 == 0 ? 1.0 : -1.0;
    };
    const int below = std::min(static_cast<int>(joint), 5);
    return at(below) + (joint - below) * (at(below + 1) - at(below));
  };
  ShellProblem problem(
      {6 * cut.count_u, cut.count_v, cut.shape, false},
      [&](double u, double v) { return Eigen::Vector3d(6.0 * u + 0.2 * (v - 0.5) * shift(6.0 * u), 0.2 * v, 0.0); },
      {1e7, 0.3, 1.0}, 0.1);
  problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  problem.load_side(problem.grid.side('u', 1), direction, 1.0);
  const Eigen::Index end = problem.grid.node(6 * cut.count_u, cut.count_v / 2);
  return test::displacement(problem, end, direction) / (direction == 1 ? 0.1081 : 0.4321);
}

/// A quarter of a ring between the radii 4.12 and 4.32, 0.1 thick [MH85], six cells along: displacement at the free end
/// along a unit force in its plane, radial (0), or across it (2).
double curved_beam(const Cut& cut, int direction) {
  ShellProblem problem(
      {6 * cut.count_u, cut.count_v, cut.shape, cut.distorted},
      [](double u, double v) {
        const double angle = 0.5 * pi * u, radius = 4.12 + 0.2 * v;
        return Eigen::Vector3d(radius * std::sin(angle), radius * std::cos(angle), 0.0);
      },
      {1e7, 0.25, 1.0}, 0.1);
  problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  problem.load_side(problem.grid.side('u', 1), direction, 1.0);
  const Eigen::Index end = problem.grid.node(6 * cut.count_u, cut.count_v / 2);
  return test::displacement(problem, end, direction) / (direction == 0 ? 0.08734 : 0.5022);
}

TEST(ShellBeams, StraightWhateverTheirCells) {
  // Leaning triangles come from below, .93 at the last mesh of parallelograms, and are left out.
  for (const auto& [shape, lean] : {std::pair{CellShape::quadrilateral4, Lean::none},
                                    {CellShape::quadrilateral4, Lean::trapezoids},
                                    {CellShape::quadrilateral4, Lean::parallelograms},
                                    {CellShape::triangle3, Lean::none}})
    for (const int direction : {1, 2}) {
      const auto convergence = converge({shape, false}, {2, 4, 8, 16}, [&, lean = lean](const Cut& cut) {
        return straight_beam(cut, lean, direction);
      });
      EXPECT_LT(convergence.last_error(), 0.01) << convergence.table();
      EXPECT_TRUE(convergence.improves()) << convergence.table();
    }
}

TEST(ShellBeams, Curved) {
  for (const auto shape : {CellShape::quadrilateral4, CellShape::triangle3})
    for (const int direction : {0, 2}) {
      const auto convergence =
          converge({shape, false}, {2, 4, 8, 16}, [&](const Cut& cut) { return curved_beam(cut, direction); });
      EXPECT_LT(convergence.last_error(), shape == CellShape::quadrilateral4 ? 0.01 : 0.02) << convergence.table();
      EXPECT_TRUE(convergence.improves(0.02)) << convergence.table();
    }
}

// Natural frequencies -----------------------------------------------------------------------------------------------

ShellProblem plate(const Cut& cut, double a, double b, double thickness) {
  return {cut, [=](double u, double v) { return Eigen::Vector3d(a * u, b * v, 0.0); }, nafems_steel, thickness};
}

void expect_frequencies(const Eigen::VectorXd& found, const std::vector<double>& published, double tolerance) {
  for (std::size_t i = 0; i < published.size(); ++i) {
    const double value = found[static_cast<Eigen::Index>(i)];
    EXPECT_NEAR(value, published[i], tolerance * published[i])
        << "mode " << i + 1 << " of [" << found.transpose() << "]";
  }
}

TEST_P(ShellBenchmarks, FreeSquarePlate) {
  // [NAFEMS] FV12; its values are of thin plates, and to four digits.
  const auto found = frequencies(plate({24, 24, GetParam().shape, GetParam().distorted}, 10.0, 10.0, 0.05).model, 11);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(found[i], 0.0) << "rigid-body mode " << i + 1;
  expect_frequencies(found.tail<5>(), {1.622, 2.360, 2.922, 4.233, 4.233}, 0.01);
}

TEST_P(ShellBenchmarks, CantileveredSquarePlate) {
  // [NAFEMS] FV16. The published values are of a Ritz series, hence upper bounds: those of finer series are up to 0.8 %
  // lower. A consistent mass comes from above, a lumped one from below.
  const std::vector<double> published = {0.421, 1.029, 2.582, 3.306, 3.753, 6.555};
  auto problem = plate({32, 32, GetParam().shape, GetParam().distorted}, 10.0, 10.0, 0.05);
  problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  const auto consistent = frequencies(problem.model, 6);
  expect_frequencies(consistent, published, 0.01);
  problem.model.mass_kind = MassKind::lumped;
  const auto lumped = frequencies(problem.model, 6);
  expect_frequencies(lumped, published, 0.015);
  EXPECT_TRUE((lumped.array() < consistent.array()).all());
}

TEST_P(ShellBenchmarks, SimplySupportedPlateHasItsClosedForm) {
  const double a = 2.0, b = 1.5, t = 0.005;
  const double rigidity = 200e9 * t * t * t / (12.0 * (1.0 - 0.09));
  const std::vector<std::pair<int, int>> waves = {{1, 1}, {2, 1}, {1, 2}, {3, 1}, {2, 2}};
  const auto errors = [&](int count) {
    auto problem = plate({count, count, GetParam().shape, GetParam().distorted}, a, b, t);
    problem.fix(problem.grid.all(), {0, 1, 5});
    for (const int end : {0, 1}) {
      problem.fix(problem.grid.side('u', end), {2, 3});
      problem.fix(problem.grid.side('v', end), {2, 4});
    }
    Eigen::ArrayXd relative = frequencies(problem.model, 5);
    for (std::size_t i = 0; i < waves.size(); ++i) {
      const auto [m, n] = waves[i];
      const double exact = 0.5 * pi * (m * m / (a * a) + n * n / (b * b)) * std::sqrt(rigidity / (8000.0 * t));
      relative[static_cast<Eigen::Index>(i)] /= exact;
    }
    return Eigen::ArrayXd(relative - 1.0);
  };
  const auto coarse = errors(16), fine = errors(32);
  EXPECT_LT(fine.abs().maxCoeff(), 0.015)
      << fine.transpose();  // found .0125: eleven cells to a half wave of the fourth
  // Second order: a quarter, give or take the shear deformation that the closed form leaves out.
  EXPECT_LT((fine / coarse).maxCoeff(), 0.3) << (fine / coarse).transpose();
  EXPECT_GT((fine / coarse).minCoeff(), 0.2) << (fine / coarse).transpose();
}

TEST_P(ShellBenchmarks, PlateInItsPlaneVibratesLikeABeam) {
  // A slender cantilever upright, one layer of cells: the drilling rotations are not loaded and must not stiffen.
  const double length = 10.0, height = 0.25;
  auto problem = plate({40, 1, GetParam().shape, false}, length, height, 0.01);
  problem.fix(problem.grid.all(), {2, 3, 4});
  problem.fix(problem.grid.side('u', 0), {0, 1, 5});
  const double slope = std::sqrt(200e9 * height * height / 12.0 / 8000.0) / (2.0 * pi * length * length);
  // Found .15 % low, of which shear and rotary inertia are most; triangles 1 %.
  expect_frequencies(frequencies(problem.model, 2), {1.8751 * 1.8751 * slope, 4.6941 * 4.6941 * slope},
                     GetParam().quadrilateral() ? 0.003 : 0.0125);
}

TEST(ShellModes, DrillingRotationsAddNoModesInThePlane) {
  // Triangles have no rotations that only a small stiffness holds: their modes are the standard, to the error of h.
  const auto modes = [](CellShape shape) {
    auto problem = plate({16, 16, shape, true}, 10.0, 8.0, 0.05);
    problem.fix(problem.grid.all(), {2, 3, 4});
    problem.fix(problem.grid.side('u', 0), {0, 1});
    return frequencies(problem.model, 15);
  };
  const Eigen::ArrayXd ratios = modes(CellShape::quadrilateral4).array() / modes(CellShape::triangle3).array();
  EXPECT_LT((ratios - 1.0).abs().maxCoeff(), 0.02) << ratios.transpose();  // found .017
}

INSTANTIATE_TEST_SUITE_P(Cells, ShellBenchmarks,
                         testing::Values(Kind{CellShape::quadrilateral4, false}, Kind{CellShape::quadrilateral4, true},
                                         Kind{CellShape::triangle3, false}, Kind{CellShape::triangle3, true}),
                         [](const auto& one) {
                           return std::string(one.param.quadrilateral() ? "quadrilaterals" : "triangles") +
                                  (one.param.distorted ? "_distorted" : "_even");
                         });

}  // namespace
}  // namespace kalfem
