// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/model/gauges/gauge_placement.hpp"
#include "kalfem/model/gauges/nearest_place.hpp"
#include "model/fe_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

std::vector<Index> all_cells(const Mesh& mesh) {
  std::vector<Index> cells;
  for (Index i = 0; i < std::ssize(mesh.cells); ++i) cells.push_back(i);
  return cells;
}

/// The place that the coordinates of a cell stand for.
Vector3d place_of(const Mesh& mesh, const CellPlace& at) {
  const Cell& cell = mesh.cells[static_cast<std::size_t>(at.cell)];
  return corner_places(mesh, cell) * corner_shares(cell.shape, at.natural);
}

TEST(NearestPlace, FindsPlacesInsideDistortedSolids) {
  for (const auto shape : solid_shapes) {
    const auto box = box_mesh({3, 3, 2, shape, 0.15}, [](const Vector3d& cube) -> Vector3d {
      return {2.0 * cube.x(), cube.y() + 0.2 * cube.x(), 0.7 * cube.z()};
    });
    for (const auto& wanted : {Vector3d(0.31, 0.52, 0.2), Vector3d(1.7, 0.9, 0.65), Vector3d(1.0, 0.6, 0.0)}) {
      const auto found = nearest_places(box.mesh, all_cells(box.mesh), wanted);
      ASSERT_FALSE(found.empty());
      EXPECT_LT((place_of(box.mesh, found[0]) - wanted).norm(), 1e-9) << name_of(shape);
      EXPECT_LT(found[0].distance, 1e-9);
    }
  }
}

TEST(NearestPlace, LiesOnTheBoundaryForPlacesOutside) {
  const auto plate = plate_mesh(2.0, 1.0, 2, 1);
  const auto found = nearest_places(plate, all_cells(plate), {2.3, 0.4, 0.5});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].cell, 1);
  EXPECT_LT((place_of(plate, found[0]) - Vector3d(2.0, 0.4, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(found[0].distance, std::hypot(0.3, 0.5), 1e-12);
}

TEST(NearestPlace, IsInEveryCellThatMeetsThere) {
  const auto plate = plate_mesh(2.0, 2.0, 2, 2);
  EXPECT_EQ(nearest_places(plate, all_cells(plate), {1.0, 1.0, 0.0}).size(), 4u);
  EXPECT_EQ(nearest_places(plate, all_cells(plate), {1.0, 0.5, 0.0}).size(), 2u);
}

/// A plate in the x-y plane whose right edge a wall stands on, a beam along y beside it, and a point without element.
FiniteElementModel plate_wall_and_beam() {
  Mesh mesh = plate_mesh(1.0, 1.0, 2, 2);
  const Index low = add_node(mesh, {1.0, 0.0, 1.0}), high = add_node(mesh, {1.0, 0.5, 1.0});
  add_cell(mesh, "wall", CellShape::quadrilateral4, {2, 5, high, low});
  const Index start = add_node(mesh, {3.0, 0.0, 0.0}), end = add_node(mesh, {3.0, 1.0, 0.0});
  add_cell(mesh, "bar", CellShape::line2, {start, end});
  auto model = model_of(mesh);
  model.name = "frame";
  model.properties["plate"] = ShellProperty{"steel", 0.01};
  model.properties["wall"] = ShellProperty{"steel", 0.01};
  model.properties["bar"] = beam_property(rectangular_section(0.02, 0.03));
  return model;
}

GaugeDescription on_plate() {
  return {.name = "g", .place = Vector3d(0.2, 0.3, 0.0), .direction = Vector3d::UnitX(), .surface = Layer::top};
}

std::string refusal_of(const GaugeDescription& given) {
  return message_of([&] { place_gauge(plate_wall_and_beam(), given); });
}

TEST(GaugePlacement, ByPlaceOrByNumber) {
  const auto model = plate_wall_and_beam();
  const auto at_place = place_gauge(model, on_plate());
  EXPECT_EQ(at_place.cell, 0);
  EXPECT_LT((at_place.natural - Vector3d(-0.2, 0.2, 0.0)).norm(), 1e-12);
  auto by_number = on_plate();
  by_number.place = std::int64_t{4};
  EXPECT_EQ(place_gauge(model, by_number).cell, 3);
  EXPECT_TRUE(place_gauge(model, by_number).natural.isZero());
}

TEST(GaugePlacement, ARegionChoosesBetweenShellsThatMeet) {
  auto at_edge = on_plate();
  at_edge.place = Vector3d(1.0, 0.25, 0.0);
  at_edge.direction = Vector3d::UnitY();
  EXPECT_THAT(refusal_of(at_edge), AllOf(HasSubstr("elements 2 and 5 meet"), HasSubstr("name its region")));
  at_edge.region = "wall";
  EXPECT_EQ(place_gauge(plate_wall_and_beam(), at_edge).cell, 4);
}

TEST(GaugePlacement, ABeamNeedsNoDirection) {
  const auto gauge = place_gauge(plate_wall_and_beam(), {.name = "g", .place = Vector3d(3.01, 0.25, 0.0)});
  EXPECT_EQ(gauge.cell, 5);
  EXPECT_NEAR(gauge.natural[0], -0.5, 1e-12);
  EXPECT_LT((gauge.direction - Vector3d::UnitY()).norm(), 1e-12);
}

TEST(GaugePlacement, RefusesWhatDoesNotExist) {
  auto given = on_plate();
  given.place = std::int64_t{99};
  EXPECT_THAT(refusal_of(given),
              AllOf(HasSubstr("strain gauge 'g' stands on element 99, which is no beam, shell or solid of plate.msh"),
                    HasSubstr("at: [x, y, z]")));
  given = on_plate();
  given.region = "wal";
  EXPECT_THAT(refusal_of(given), HasSubstr("did you mean 'wall'"));
  given = on_plate();
  given.place = Vector3d(200.0, 300.0, 0.0);
  EXPECT_THAT(refusal_of(given), AllOf(HasSubstr("away from the nearest element"), HasSubstr("coordinates in metres")));
}

TEST(GaugePlacement, RefusesWhatDoesNotSuitTheElement) {
  auto given = on_plate();
  given.direction = Vector3d(0.05, 0.0, 1.0);
  EXPECT_THAT(refusal_of(given), HasSubstr("is normal to its shell"));
  given.direction = {};
  EXPECT_THAT(refusal_of(given), HasSubstr("has no direction"));
  given.direction = Vector3d::Zero();
  EXPECT_THAT(refusal_of(given), HasSubstr("a direction of no length"));
  given = on_plate();
  given.surface = {};
  EXPECT_THAT(refusal_of(given), HasSubstr("does not say on which side"));
  given = on_plate();
  given.fibre = Eigen::Vector2d(0.0, 0.01);
  EXPECT_THAT(refusal_of(given), HasSubstr("only a beam has fibres"));
  GaugeDescription on_beam{.name = "g", .place = std::int64_t{6}, .surface = Layer::top};
  EXPECT_THAT(refusal_of(on_beam), HasSubstr("only a shell has a top and a bottom"));
  on_beam.surface = {};
  on_beam.direction = Vector3d::UnitX();
  EXPECT_THAT(refusal_of(on_beam), HasSubstr("strained along its axis alone"));
}

TEST(GaugePlacement, ASolidHasNoSurfaces) {
  const auto box =
      box_mesh({2, 2, 2, CellShape::hexahedron8, 0.0}, [](const Vector3d& cube) -> Vector3d { return cube; });
  auto model = model_of(box.mesh);
  model.properties["solid"] = SolidProperty{"steel"};
  GaugeDescription given{.name = "g", .place = Vector3d(0.3, 0.3, 1.0), .direction = Vector3d::UnitX()};
  EXPECT_NEAR(place_gauge(model, given).natural[2], 1.0, 1e-12);  // on the surface
  given.surface = Layer::top;
  EXPECT_THAT(message_of([&] { place_gauge(model, given); }), HasSubstr("the place itself says where in the solid"));
}

TEST(GaugePlacement, NeedsElements) {
  auto model = plate_wall_and_beam();
  model.properties.clear();
  EXPECT_THAT(message_of([&] { place_gauge(model, on_plate()); }), HasSubstr("has no element to stand on"));
}

}  // namespace
}  // namespace kalfem::test
