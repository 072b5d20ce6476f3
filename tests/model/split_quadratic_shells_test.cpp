// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/mesh/split_quadratic_shells.hpp"
#include "kalfem/model/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/mesh/laminate_theory.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using namespace test;

/// n x n cells of 8 nodes, or 2 n x n of 6, on the square a x a; corners of the grid of half cells but for the middles.
FiniteElementModel quadratic_plate(double a, int n, CellShape shape) {
  Mesh mesh;
  mesh.source = "plate.inp";
  const bool triangles = shape == CellShape::triangle6;
  std::vector<std::vector<Eigen::Index>> at(2 * n + 1, std::vector<Eigen::Index>(2 * n + 1, -1));
  for (int j = 0; j <= 2 * n; ++j)
    for (int i = 0; i <= 2 * n; ++i)
      if (triangles || i % 2 == 0 || j % 2 == 0) {
        at[i][j] = add_node(mesh, {0.5 * a * i / n, 0.5 * a * j / n, 0.0});
        if (i == 0) mesh.node_sets["clamp"].push_back(at[i][j]);
      }
  for (int j = 0; j < 2 * n; j += 2)
    for (int i = 0; i < 2 * n; i += 2) {
      const auto p = [&](int di, int dj) { return at[i + di][j + dj]; };
      if (triangles) {
        add_cell(mesh, "plate", shape, {p(0, 0), p(2, 0), p(2, 2), p(1, 0), p(2, 1), p(1, 1)});
        add_cell(mesh, "plate", shape, {p(0, 0), p(2, 2), p(0, 2), p(1, 1), p(1, 2), p(0, 1)});
      } else {
        add_cell(mesh, "plate", shape, {p(0, 0), p(2, 0), p(2, 2), p(0, 2), p(1, 0), p(2, 1), p(1, 2), p(0, 1)});
      }
    }
  auto model = model_of(std::move(mesh));
  model.materials["steel"] = {200e9, 0.3, 8000.0};
  model.properties["plate"] = ShellProperty{.material = "steel", .thickness = 0.05};
  model.fixed = {{.name = "clamp", .nodes = model.mesh.node_sets["clamp"]}};
  return model;
}

std::vector<Eigen::Index> nodes_of(const Mesh& mesh, Eigen::Index cell) {
  const auto nodes = mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell)]);
  return {nodes.begin(), nodes.end()};
}

TEST(LinearCells, QuadrilateralIsCutAboutItsMiddle) {
  auto model = model_of({});
  Mesh& mesh = model.mesh;
  // Corners and middles of the sides of x = r (1 + s / 4), y = s, z = r s / 2: the shape functions hold it exactly.
  const auto place = [](double r, double s) { return Eigen::Vector3d(r * (1.0 + 0.25 * s), s, 0.5 * r * s); };
  const std::vector<std::pair<double, double>> corners = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}},
                                               middles = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
  for (const auto& [r, s] : corners) add_node(mesh, place(r, s));
  for (const auto& [r, s] : middles) add_node(mesh, place(r, s));
  mesh.node_ids = {11, 12, 13, 14, 105, 106, 107, 108};
  add_cell(mesh, "plate", CellShape::quadrilateral8, {0, 1, 2, 3, 4, 5, 6, 7});
  mesh.regions["all"] = {0};
  mesh.node_sets["side"] = {0, 4, 1};
  model.properties["plate"] = ShellProperty{.material = "steel", .thickness = 0.1};
  replace_quadratic(model);
  ASSERT_EQ(mesh.node_count(), 9);
  EXPECT_EQ(mesh.node_ids.back(), 109);
  EXPECT_LT((mesh.nodes.col(8) - place(0, 0)).norm(), 1e-15);  // rounding
  EXPECT_EQ(mesh.regions["plate"], (std::vector<Eigen::Index>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.regions["all"], mesh.regions["plate"]);
  EXPECT_EQ(mesh.node_sets["side"], (std::vector<Eigen::Index>{0, 4, 1}));
  EXPECT_EQ(nodes_of(mesh, 0), (std::vector<Eigen::Index>{0, 4, 8, 7}));
  EXPECT_EQ(nodes_of(mesh, 2), (std::vector<Eigen::Index>{8, 5, 2, 6}));
  EXPECT_EQ(mesh.cells[0].id, 1);
  EXPECT_EQ(mesh.cells[3].id, 4);
  EXPECT_EQ(mesh.connectivity.size(), 16U);
  EXPECT_EQ(issues_of(model), "");
  const auto before = mesh.cells.size();
  replace_quadratic(model);  // nothing is left
  EXPECT_EQ(mesh.cells.size(), before);
}

TEST(LinearCells, CollapsedQuadrilateralBecomesTrianglesAtItsPoint) {
  auto model = model_of({});
  Mesh& mesh = model.mesh;
  for (const auto& place : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.5, 1, 0),
                            Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0.75, 0.5, 0), Eigen::Vector3d(0.25, 0.5, 0)})
    add_node(mesh, place);
  add_cell(mesh, "plate", CellShape::quadrilateral8, {0, 1, 2, 2, 3, 4, 2, 5});
  model.properties["plate"] = ShellProperty{.material = "steel", .thickness = 0.1};
  replace_quadratic(model);
  EXPECT_EQ(mesh.cells[0].shape, CellShape::quadrilateral4);
  EXPECT_EQ(mesh.cells[2].shape, CellShape::triangle3);
  EXPECT_EQ(mesh.cells[3].shape, CellShape::triangle3);
  const auto properties = mass_properties(assemble(model));
  EXPECT_NEAR(properties.mass, 0.5 * 0.1 * 7850.0, 6e-13);  // rounding of 392 kg
}

TEST(LinearCells, DirectionsAndFirstSidesPassToTheParts) {
  // Parts of a laminate with the first side as its direction answer as those with it given.
  for (const auto shape : {CellShape::quadrilateral8, CellShape::triangle6}) {
    auto model = quadratic_plate(1.0, 2, shape);
    const std::size_t cells = model.mesh.regions["plate"].size();
    const OrthotropicSheet ply{.youngs_modulus_1 = 100e9,
                               .youngs_modulus_2 = 10e9,
                               .poissons_ratio_12 = 0.3,
                               .shear_modulus_12 = 5e9,
                               .density = 1500.0};
    auto property = laminated({{ply, 0.01, 0.4}, {ply, 0.01, -0.2}}, 0.0);
    auto given = model;
    model.properties["plate"] = property;
    for (std::size_t i = 0; i < cells; ++i) {
      const auto nodes = nodes_of(model.mesh, static_cast<Eigen::Index>(i));
      property.directions.emplace_back(model.mesh.nodes.col(nodes[1]) - model.mesh.nodes.col(nodes[0]));
    }
    given.properties["plate"] = property;
    replace_quadratic(model);
    replace_quadratic(given);
    ASSERT_EQ(std::get<LaminateProperty>(given.properties["plate"]).directions.size(), 4 * cells);
    EXPECT_LT(difference(stiffness_of(assemble(model)), stiffness_of(assemble(given))), 1e-15);  // rounding
  }
}

TEST(LinearCells, LinesKeepTheirHingesAndOffsetsAtTheirEnds) {
  auto model = model_of({});
  Mesh& mesh = model.mesh;
  for (const double x : {0.0, 1.0, 0.5, 2.0, 1.5, 3.0}) add_node(mesh, {x, 0.0, 0.0});
  add_cell(mesh, "line", CellShape::line3, {0, 1, 2});
  add_cell(mesh, "line", CellShape::line2, {3, 5});
  add_cell(mesh, "line", CellShape::line3, {1, 3, 4});
  auto property = beam_property(rectangular_section(0.1, 0.2));
  BeamPlacement hinged, other;
  hinged.offsets.row(2) << 0.1, 0.3;
  hinged.released[4] = hinged.released[11] = true;
  other.up = {0.0, 1.0, 1.0};
  property.placements = {hinged, other, other};
  model.properties["line"] = property;
  replace_quadratic(model);
  EXPECT_EQ(mesh.regions["line"], (std::vector<Eigen::Index>{0, 3, 1, 2, 4}));
  EXPECT_EQ(nodes_of(mesh, 0), (std::vector<Eigen::Index>{0, 2}));
  EXPECT_EQ(nodes_of(mesh, 3), (std::vector<Eigen::Index>{2, 1}));
  EXPECT_EQ(nodes_of(mesh, 4), (std::vector<Eigen::Index>{4, 3}));
  const auto& parts = std::get<BeamProperty>(model.properties["line"]).placements;
  ASSERT_EQ(parts.size(), 5U);
  EXPECT_TRUE(parts[0].released[4] && !parts[0].released[11] && !parts[1].released[4] && parts[1].released[11]);
  EXPECT_DOUBLE_EQ(parts[0].offsets(2, 0), 0.1);
  EXPECT_DOUBLE_EQ(parts[0].offsets(2, 1), 0.2);
  EXPECT_DOUBLE_EQ(parts[1].offsets(2, 1), 0.3);
  EXPECT_EQ(parts[2].up, other.up);
  EXPECT_EQ(parts[4].up, other.up);
  EXPECT_EQ(issues_of(model), "");
}

TEST(LinearCells, CantileverOfThreeNodeLinesIsExactUnderEndLoads) {
  auto model = model_of({});
  for (int i = 0; i <= 4; ++i) add_node(model.mesh, {0.25 * i, 0.0, 0.0});
  add_cell(model.mesh, "line", CellShape::line3, {0, 2, 1});
  add_cell(model.mesh, "line", CellShape::line3, {2, 4, 3});
  const auto section = rectangular_section(0.02, 0.03);
  model.properties["line"] = beam_property(section);
  model.fixed = {{.name = "clamp", .nodes = {0}}};
  replace_quadratic(model);
  const auto assembled = assemble(model);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(assembled.size());
  force[assembled.find({4, 2})] = 100.0;
  const double tip = stiffness_of(assembled).ldlt().solve(force)[assembled.find({4, 2})];
  const double exact = 100.0 / (3.0 * steel.youngs_modulus * section.inertia_y) +
                       100.0 / (steel.shear_modulus() * section.area * section.shear_factor_z);
  EXPECT_NEAR(tip / exact, 1.0, 7e-14);  // rounding times the condition
}

TEST(LinearCells, OthersStayAsTheyAre) {
  auto model = quadratic_plate(1.0, 1, CellShape::quadrilateral8);
  add_cell(model.mesh, "skin of a solid", CellShape::quadrilateral8, nodes_of(model.mesh, 0));
  replace_quadratic(model);
  EXPECT_EQ(model.mesh.cells[1].shape, CellShape::quadrilateral8);
  EXPECT_EQ(nodes_of(model.mesh, 1).size(), 8U);
  EXPECT_EQ(model.mesh.regions["skin of a solid"], (std::vector<Eigen::Index>{1}));
}

class ReplacedPlate : public testing::TestWithParam<CellShape> {};

TEST_P(ReplacedPlate, FrequenciesOfTheCantileveredPlateConvergeAtTheSecondOrder) {
  // NAFEMS FV16, 10 x 10 x 0.05, published 0.421 1.029 2.582 3.306 3.753 6.555 (Abbassian, Dawswell, Knowles 1987),
  // against the values to which the elements go, by extrapolation from the two finest meshes.
  const std::vector<double> published = {0.421, 1.029, 2.582, 3.306, 3.753, 6.555};
  const auto found = [&](int n) {
    auto model = quadratic_plate(10.0, n, GetParam());
    replace_quadratic(model);
    return frequencies(model, 6);
  };
  const Eigen::ArrayXd coarse = found(4), middle = found(8), fine = found(16);
  const Eigen::ArrayXd limit = fine + (fine - middle) / 3.0;
  const Eigen::ArrayXd coarse_error = coarse / limit - 1.0, error = middle / limit - 1.0;
  RecordProperty("error_4", std::to_string(coarse_error.abs().maxCoeff()));
  RecordProperty("error_8", std::to_string(error.abs().maxCoeff()));
  const bool triangles = GetParam() == CellShape::triangle6;
  // discretisation, found .070 and .039; .018 and .010; .0027 and .0017; the published values have four digits
  EXPECT_LT(coarse_error.abs().maxCoeff(), triangles ? 0.072 : 0.042) << coarse_error.transpose();
  EXPECT_LT(error.abs().maxCoeff(), triangles ? 0.019 : 0.011) << error.transpose();
  EXPECT_LT(error.head(2).maxCoeff(), triangles ? 0.003 : 0.002) << error.transpose();
  for (std::size_t i = 0; i < published.size(); ++i)
    EXPECT_NEAR(fine[static_cast<Eigen::Index>(i)] / published[i], 1.0, 0.01) << i;
}

INSTANTIATE_TEST_SUITE_P(Cells, ReplacedPlate, testing::Values(CellShape::quadrilateral8, CellShape::triangle6),
                         [](const auto& one) {
                           return one.param == CellShape::triangle6 ? "triangles" : "quadrilaterals";
                         });

}  // namespace
}  // namespace kalfem
