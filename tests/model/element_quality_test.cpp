// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/checks/model_check.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {
namespace {

Mesh one_cell(CellShape shape, const std::vector<Eigen::Vector3d>& places, std::vector<Eigen::Index> nodes = {}) {
  Mesh mesh;
  mesh.nodes.resize(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    mesh.nodes.col(static_cast<Eigen::Index>(i)) = places[i];
    mesh.node_ids.push_back(static_cast<std::int64_t>(i) + 1);
    if (nodes.size() < places.size() && nodes.size() == i) nodes.push_back(static_cast<Eigen::Index>(i));
  }
  mesh.regions["part"] = {mesh.add_cell(shape, 1, nodes)};
  return mesh;
}

CellQuality quality(const Mesh& mesh) { return cell_quality(mesh, mesh.cells.front()); }

double of(const Mesh& mesh, QualityMeasure measure) { return quality(mesh)[static_cast<std::size_t>(measure)]; }

using M = QualityMeasure;

void expect_quality(const Mesh& mesh, const CellQuality& expected) {
  const CellQuality found = quality(mesh);
  for (std::size_t m = 0; m < found.size(); ++m)
    EXPECT_NEAR(found[m], expected[m], 1e-13) << to_string(static_cast<M>(m));  // rounding of angles in degrees
}

const std::vector<Eigen::Vector3d> cube = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                           {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const double h = std::sqrt(3.0) / 2.0;

TEST(ElementQuality, IdealCellsHaveIdealValues) {
  expect_quality(one_cell(CellShape::triangle3, {{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}}), {1, 60, 60, 0, 1, 1});
  expect_quality(one_cell(CellShape::quadrilateral4, {{0, 0, 0}, {0, 2, 0}, {0, 2, 2}, {0, 0, 2}}),
                 {1, 90, 90, 0, 1, 1});
  expect_quality(
      one_cell(CellShape::tetrahedron4, {{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0.5, h / 3.0, std::sqrt(2.0 / 3.0)}}),
      {1, 60, 60, 0, 1, 1});
  expect_quality(one_cell(CellShape::wedge6, {{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0, 0, 1}, {1, 0, 1}, {0.5, h, 1}}),
                 {1, 60, 90, 0, 1, 1});
  expect_quality(one_cell(CellShape::hexahedron8, cube), {1, 90, 90, 0, 1, 1});
}

/// Of values of the size of 1; found up to 2e-16.
constexpr double rounding = 3e-15;

TEST(ElementQuality, KnowsEachDefect) {
  const auto quad = [](double x2, double y2, double z2 = 0.0) {
    return one_cell(CellShape::quadrilateral4, {{0, 0, 0}, {1, 0, 0}, {x2, y2, z2}, {0, 1, 0}});
  };
  EXPECT_NEAR(of(one_cell(CellShape::quadrilateral4, {{0, 0, 0}, {7, 0, 0}, {7, 1, 0}, {0, 1, 0}}), M::aspect_ratio),
              7.0, 3 * rounding);
  // a corner raised by z: the triangles meet at atan(sqrt(2) z) beside one diagonal, at more, acos(1 / (1 + z^2)),
  // beside the other, on which the corner is; the cosine's rounding is magnified by 1 / sin
  EXPECT_NEAR(of(quad(1, 1, 0.1), M::warp), std::acos(1.0 / 1.01) * 180.0 / M_PI, 1e-12);
  EXPECT_NEAR(of(quad(0.5, 1.0), M::taper), 4.0 * 0.5 / (1.0 + 1.0 + 0.5 + 0.5), rounding);
  EXPECT_LT(of(quad(0.3, 0.3), M::scaled_jacobian), 0.0);           // an arrow head
  EXPECT_NEAR(of(quad(0.5, 0.5), M::largest_angle), 180.0, 1e-12);  // rounding of degrees
  EXPECT_NEAR(of(one_cell(CellShape::triangle3, {{0, 0, 0}, {1, 0, 0}, {0, 0.01, 0}}), M::smallest_angle),
              std::atan(0.01) * 180.0 / M_PI, 1e-14);
}

TEST(ElementQuality, TurnedInsideOutIsNegative) {
  auto turned = cube;
  std::rotate(turned.begin(), turned.begin() + 4, turned.end());
  EXPECT_NEAR(of(one_cell(CellShape::hexahedron8, turned), M::scaled_jacobian), -1.0, rounding);
  EXPECT_NEAR(cell_measure(one_cell(CellShape::hexahedron8, turned), Cell{CellShape::hexahedron8}), -1.0, rounding);
  EXPECT_LT(of(one_cell(CellShape::tetrahedron4, {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}}), M::scaled_jacobian),
            0.0);
}

TEST(ElementQuality, CollapsedAndCoincidentCornersAreFinite) {
  // a hexahedron that names two nodes twice is a wedge of good shape
  const Mesh wedge =
      one_cell(CellShape::hexahedron8, {{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0, 0, 1}, {1, 0, 1}, {0.5, h, 1}},
               {0, 1, 2, 2, 3, 4, 5, 5});
  EXPECT_NEAR(of(wedge, M::aspect_ratio), 1.0, rounding);
  EXPECT_GT(of(wedge, M::scaled_jacobian), 0.8);
  EXPECT_NEAR(cell_measure(wedge, wedge.cells[0]), 0.5 * h, rounding);
  // two nodes at one place
  const Mesh flat = one_cell(CellShape::quadrilateral4, {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  for (const double value : quality(flat)) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(of(flat, M::aspect_ratio), 1e9);
  const Mesh point = one_cell(CellShape::hexahedron8, std::vector<Eigen::Vector3d>(8, {1, 1, 1}));
  for (const double value : quality(point)) EXPECT_TRUE(std::isfinite(value));
  EXPECT_LE(of(point, M::scaled_jacobian), 0.0);
}

TEST(ElementQuality, MeasuresOfCells) {
  const Mesh hexahedron = one_cell(CellShape::hexahedron8, cube);
  EXPECT_NEAR(cell_measure(hexahedron, hexahedron.cells[0]), 1.0, rounding);
  const Mesh tetrahedron = one_cell(CellShape::tetrahedron4, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  EXPECT_NEAR(cell_measure(tetrahedron, tetrahedron.cells[0]), 1.0 / 6.0, rounding);
  const Mesh wedge = one_cell(CellShape::wedge6, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}, {1, 0, 2}, {0, 1, 2}});
  EXPECT_NEAR(cell_measure(wedge, wedge.cells[0]), 1.0, rounding);
  const Mesh line = one_cell(CellShape::line2, {{0, 0, 0}, {3, 4, 0}});
  EXPECT_NEAR(cell_measure(line, line.cells[0]), 5.0, 2 * rounding);
  const Mesh quad = one_cell(CellShape::quadrilateral4, {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}});
  EXPECT_NEAR(cell_measure(quad, quad.cells[0]), 2.0, rounding);
}

TEST(ElementQuality, ARegionCountsAndNamesTheWorst) {
  Mesh mesh;
  mesh.nodes.resize(3, 44);
  for (Eigen::Index i = 0; i < 22; ++i) {  // a strip whose cells get longer
    mesh.nodes.col(2 * i) << 0.1 * double(i * i), 0.0, 0.0;
    mesh.nodes.col(2 * i + 1) << 0.1 * double(i * i), 0.1, 0.0;
  }
  for (Eigen::Index i = 0; i < 21; ++i)
    mesh.regions["strip"].push_back(mesh.add_cell(CellShape::quadrilateral4, 100 + i,
                                                  std::vector<Eigen::Index>{2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1}));
  const RegionQuality strip = region_quality(mesh, "strip", {.limits = {30.0, 15.0, 165.0, 15.0, 0.3, 0.2}});
  EXPECT_EQ(strip.measured, 21);
  EXPECT_EQ(strip.cells.at(CellShape::quadrilateral4), 21);
  const auto& aspect = strip.measures[0];
  EXPECT_NEAR(aspect.worst, 41.0, 2e-13);  // rounding; cell i is 2 i + 1 times as long as wide
  EXPECT_NEAR(aspect.mean, 21.0, 1e-13);
  EXPECT_EQ(aspect.beyond, 6);  // 31 .. 41
  EXPECT_EQ(aspect.worst_cells, (std::vector<Eigen::Index>{20, 19, 18, 17, 16}));
  EXPECT_EQ(strip.measures[5].beyond, 0);
  EXPECT_EQ(region_quality(mesh, "nothing").measured, 0);
}

}  // namespace
}  // namespace kalfem
