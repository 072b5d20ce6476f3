// SPDX-License-Identifier: Apache-2.0
// Supports that hold the rotations about the normal of shells: everywhere, as decks do that stem from programs in which
// nothing stiffens them, and along clamped edges.
#include <gtest/gtest.h>

#include "model/fe_models.hpp"
#include "model/shell_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Tapered panel of Cook, 48 long, 44 and 16 high, clamped, a unit shear at its end: v = 23.96. Turned about x and z by
/// the angles, so that its plane is none of the global ones.
struct Panel {
  ShellProblem problem;
  Eigen::Matrix3d turn;

  Panel(CellShape shape, int count, const Eigen::Matrix3d& the_turn)
      : problem(
            {count, count, shape},
            [&](double u, double v) -> Vector3d {
              return the_turn * Vector3d(48.0 * u, 44.0 * u + v * (44.0 - 28.0 * u), 0.0);
            },
            {1.0, 1.0 / 3.0, 1.0}, 1.0),
        turn(the_turn) {
    problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
    const auto end = problem.grid.side('u', 1);
    for (std::size_t i = 0; i < end.size(); ++i) {
      const double share = (i == 0 || i + 1 == end.size() ? 0.5 : 1.0) / count;
      for (int axis = 0; axis < 3; ++axis) problem.load(end[i], axis, share * turn(axis, 1));
    }
  }
  [[nodiscard]] double deflection() const {
    const Index tip = problem.grid.node(problem.grid.cut.count_u, problem.grid.cut.count_v / 2);
    return turn.col(1).dot(solve(problem).segment<3>(6 * tip)) / 23.96;
  }
};

Eigen::Matrix3d no_turn() { return Eigen::Matrix3d::Identity(); }
Eigen::Matrix3d tilt() {
  return (Eigen::AngleAxisd(0.7, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.5, Vector3d::UnitX())).toRotationMatrix();
}

/// The panel with all rotations held: never stiffer than the linear membranes of the same mesh, .7140 and .8958 of
/// triangles of constant strain.
TEST(HeldRotations, ATaperedPanelIsNoStifferThanAMembrane) {
  for (const auto& [shape, count, least] : {std::tuple{CellShape::triangle3, 8, 0.7139},
                                            {CellShape::triangle3, 16, 0.8957},
                                            {CellShape::quadrilateral4, 8, 0.975},
                                            {CellShape::quadrilateral4, 16, 0.99}})
    for (const auto& turn : {no_turn(), tilt()}) {
      Panel panel(shape, count, turn);
      panel.problem.fix(panel.problem.grid.all(), {3, 4, 5});
      EXPECT_GT(panel.deflection(), least) << count;
      EXPECT_LT(panel.deflection(), 1.005) << count;
    }
}

// Held in the whole plane, as a deck of a membrane holds its nodes: z, and all rotations.
TEST(HeldRotations, OutOfPlaneSupportsChangeNothing) {
  Panel held(CellShape::triangle3, 8, no_turn()), free(CellShape::triangle3, 8, no_turn());
  held.problem.fix(held.problem.grid.all(), {2, 3, 4, 5});
  free.problem.fix(free.problem.grid.all(), {3, 4, 5});
  EXPECT_NEAR(held.deflection(), free.deflection(), 1e-9);
}

// A clamped edge holds the rotations of its nodes; that of elements with a free corner stays held.
TEST(HeldRotations, AClampedEdgeStaysClamped) {
  for (const auto shape : {CellShape::triangle3, CellShape::quadrilateral4}) {
    const auto deflection = [&](const std::vector<int>& edge) {
      ShellProblem strip(
          {20, 1, shape},
          [](double u, double v) -> Vector3d {
            return {10.0 * u, v, 0.0};
          },
          {1.0, 0.3, 1.0}, 1.0);
      strip.fix(strip.grid.all(), {2, 3, 4});
      strip.fix(strip.grid.side('u', 0), edge);
      strip.load_side(strip.grid.side('u', 1), 1, 1.0);
      return displacement(strip, strip.grid.node(20, 0), 1);
    };
    EXPECT_LT(deflection({0, 1, 5}), deflection({0, 1}));
  }
}

}  // namespace
}  // namespace kalfem::test
