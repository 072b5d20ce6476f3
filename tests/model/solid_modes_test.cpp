// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "model/fe_models.hpp"
#include "solid_models.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using test::frequencies;

/// NAFEMS FV52: plate 10 x 10 x 1 m, w = 0 along the lower edges of its four sides.
test::SolidProblem thick_plate(int along, int through, CellShape shape, SolidKind kind) {
  test::SolidProblem plate(
      {along, along, through, shape},
      [](const Vector3d& cube) -> Vector3d {
        return {10 * cube.x(), 10 * cube.y(), cube.z()};
      },
      {200e9, 0.3, 8000.0}, kind);
  std::vector<Index> edge;
  for (const Index node : plate.box.side(2, 0.0)) {
    const Eigen::Vector2d place = plate.box.cube.col(node).head<2>();
    if (place.minCoeff() < 1e-9 || place.maxCoeff() > 1.0 - 1e-9) edge.push_back(node);
  }
  plate.fix(edge, {2});
  return plate;
}

/// NAFEMS' target for modes 4 to 10 [Hz].
const Eigen::Array<double, 7, 1> fv52{45.897, 109.44, 109.44, 167.89, 193.59, 206.19, 206.19};

/// Ratios to the target of another program's hexahedra on the same meshes (Altair OptiStruct, verification OS-V: 0455).
const Eigen::Array<double, 7, 1> hexa20_of_optistruct{0.9760, 1.0101, 1.0101, 1.0072, 1.0017, 1.0022, 1.0022};
const Eigen::Array<double, 7, 1> hexa8_of_optistruct{0.9874, 1.0413, 1.0413, 1.0322, 1.0164, 1.0164, 1.0164};

Eigen::Array<double, 7, 1> fv52_ratios(int along, int through, CellShape shape, SolidKind kind) {
  const Eigen::VectorXd found = frequencies(thick_plate(along, through, shape, kind).model, 10);
  EXPECT_EQ(found.head(3).maxCoeff(), 0.0);  // two shifts and a turn in the plane
  return found.tail<7>().array() / fv52;
}

TEST(SolidFV52, HexahedraHaveTheFrequenciesOfAnotherProgram) {
  const auto quadratic = fv52_ratios(4, 1, CellShape::hexahedron20, SolidKind::full);
  EXPECT_LT((quadratic - hexa20_of_optistruct).abs().maxCoeff(), 6e-5) << quadratic.transpose();  // four decimals
  // The same incompatible modes but for those of the volume change.
  const auto linear = fv52_ratios(8, 3, CellShape::hexahedron8, SolidKind::standard);
  EXPECT_LT((linear - hexa8_of_optistruct).abs().maxCoeff(), 2.5e-3) << linear.transpose();  // found .0018
}

TEST(SolidFV52, ShapesAgreeOnFineMeshes) {
  // The target is not the limit of this model: held along lines only, a solid gives way there without bound, and the
  // frequencies of bending fall slowly under it with finer meshes. So the shapes are held against each other.
  const auto reference = fv52_ratios(8, 1, CellShape::hexahedron20, SolidKind::full);
  const auto departure = [&](CellShape shape, int along, int through) {
    const auto ratios = fv52_ratios(along, through, shape, SolidKind::standard);
    return (ratios / reference - 1.0).abs().maxCoeff();
  };
  // found .019, .006, .025 and .015
  EXPECT_LT(departure(CellShape::hexahedron20, 8, 1), 0.03);
  EXPECT_LT(departure(CellShape::wedge15, 8, 1), 0.015);
  EXPECT_LT(departure(CellShape::tetrahedron10, 8, 1), 0.035);
  EXPECT_LT(departure(CellShape::hexahedron8, 16, 4), 0.025);
}

TEST(SolidModes, FreeElementHasNoOtherModesBelowItsFirst) {
  for (const auto shape : {CellShape::hexahedron8, CellShape::wedge15, CellShape::tetrahedron10}) {
    const auto first = [&](SolidKind kind) {
      const test::SolidProblem cube(
          {1, 1, 1, shape}, [](const Vector3d& x) -> Vector3d { return x; }, {1, 0.3, 1}, kind);
      return frequencies(cube.model, 7)[6];
    };
    const double ratio = first(SolidKind::standard) / first(SolidKind::full);
    EXPECT_GT(ratio, 0.7) << test::name_of(shape);
    EXPECT_LT(ratio, 1.0 + 1e-12) << test::name_of(shape);  // fewer points only soften; rounding
  }
}

TEST(SolidModes, MotionsThatEightPointsDoNotSeeAreHeldInTheStandardHexahedron20) {
  const auto of = [](SolidKind kind) {
    const test::SolidProblem cube(
        {1, 1, 1, CellShape::hexahedron20}, [](const Vector3d& x) -> Vector3d { return x; }, {1, 0.3, 1}, kind);
    return frequencies(cube.model, 13);
  };
  const auto reduced = of(SolidKind::reduced), standard = of(SolidKind::standard), full = of(SolidKind::full);
  EXPECT_EQ(reduced[11], 0.0);                              // no energy
  EXPECT_NEAR(standard[6], 0.2 * full[6], 0.01 * full[6]);  // the fifth of it that the documentation tells
  EXPECT_LT(standard[11], 0.3 * full[6]);                   // found .25
  EXPECT_NEAR(standard[12], full[6], 1e-13 * full[6]);      // then the modes of the full element
}

TEST(SolidModes, LumpedMassComesToTheSameFrequencies) {
  for (const auto shape : test::solid_shapes) {
    test::SolidProblem bar({12, 2, 2, shape},
                           [](const Vector3d& x) -> Vector3d {
                             return {6 * x.x(), x.y(), x.z()};
                           },
                           {1, 0.3, 1});
    bar.fix(bar.box.side(0, 0.0), {0, 1, 2});
    const double consistent = frequencies(bar.model, 1)[0];
    bar.model.mass_kind = MassKind::lumped;
    // found .0011 to .0052: second order in 1/12
    EXPECT_NEAR(frequencies(bar.model, 1)[0], consistent, 0.012 * consistent) << test::name_of(shape);
  }
}

}  // namespace
}  // namespace kalfem
