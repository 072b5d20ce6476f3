// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/mesh_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace kalfem {
namespace {

using Eigen::Index;

/// nx x ny x nz hexahedra of a box of 2 x 1 x 1, in two regions along x.
Mesh block(Index nx, Index ny, Index nz) {
  Mesh mesh;
  const auto node = [&](Index i, Index j, Index k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  mesh.nodes.resize(3, (nx + 1) * (ny + 1) * (nz + 1));
  mesh.node_ids.resize(static_cast<std::size_t>(mesh.node_count()));
  std::iota(mesh.node_ids.begin(), mesh.node_ids.end(), 1);
  for (Index k = 0; k <= nz; ++k)
    for (Index j = 0; j <= ny; ++j)
      for (Index i = 0; i <= nx; ++i)
        mesh.nodes.col(node(i, j, k)) << 2.0 * double(i) / double(nx), double(j) / double(ny), double(k) / double(nz);
  for (Index k = 0; k < nz; ++k)
    for (Index j = 0; j < ny; ++j)
      for (Index i = 0; i < nx; ++i) {
        const std::vector<Index> nodes = {
            node(i, j, k),     node(i + 1, j, k),     node(i + 1, j + 1, k),     node(i, j + 1, k),
            node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)};
        mesh.regions[2 * i < nx ? "left" : "right <&>"].push_back(
            mesh.add_cell(CellShape::hexahedron8, static_cast<std::int64_t>(mesh.cells.size()) + 1, nodes));
      }
  return mesh;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto place = text.find(part); place != std::string::npos; place = text.find(part, place + part.size())) ++count;
  return count;
}

TEST(OuterFaces, AreThoseOfOneSolidOnly) {
  const Mesh mesh = block(4, 3, 2);
  EXPECT_EQ(outer_faces(mesh, {"left", "right <&>"}).size(), 2u * (4 * 3 + 4 * 2 + 3 * 2));
  EXPECT_EQ(outer_faces(mesh, {"left"}).size(), 2u * (2 * 3 + 2 * 2 + 3 * 2));  // the cut is outside then
  EXPECT_EQ(outer_faces(mesh, {"left", "left"}).size(), 32u);                   // each cell once
  EXPECT_TRUE(outer_faces(mesh, {"nothing"}).empty());
}

TEST(OuterFaces, CoarseningKeepsTheShape) {
  const Mesh mesh = block(80, 40, 40);
  const auto faces = outer_faces(mesh, {"left", "right <&>"});
  const DrawnSurface coarse = coarsened(mesh.nodes, faces, shape_weights(mesh.nodes, faces), 3000);
  EXPECT_TRUE(coarse.coarsened);
  EXPECT_LE(coarse.faces.size(), 3000u);
  EXPECT_GE(coarse.faces.size(), 1000u);
  // nodes at corners count most: the box stays the same
  // the outermost places stay
  EXPECT_LT((coarse.places.rowwise().maxCoeff() - Eigen::Vector3d(2, 1, 1)).norm(), 1e-12);
  EXPECT_LT(coarse.places.rowwise().minCoeff().norm(), 1e-12);
  EXPECT_FALSE(coarsened(mesh.nodes, faces, {}, faces.size()).coarsened);
}

ScreenPolygon square(double x, double y, double size, double depth, double slope = 0.0) {
  ScreenPolygon polygon{Eigen::Matrix3Xd(3, 4)};
  polygon.corners << x, x + size, x + size, x, y, y, y + size, y + size, depth, depth + slope * size,
      depth + slope * size, depth;
  return polygon;
}

TEST(PaintersOrder, PaintsTheFartherFirstAndLeavesOutTheHidden) {
  const std::vector<ScreenPolygon> polygons = {square(10, 10, 30, 5.0), square(20, 20, 30, 9.0),
                                               square(12, 12, 5, 20.0)};
  const auto screen = screen_depth(polygons, 100, 100);
  EXPECT_EQ(painters_order(polygons, screen), (std::vector<std::size_t>{1, 0}));
  EXPECT_EQ(screen.at(45.0, 45.0), 9.0);
  EXPECT_EQ(screen.at(25.0, 25.0), 5.0);
  EXPECT_FALSE(std::isfinite(screen.at(90.0, 5.0)));
  EXPECT_FALSE(std::isfinite(screen.at(-1.0, 5.0)));
}

TEST(PaintersOrder, GoesByWhatCoversAndNotByMeanDepth) {
  // the large one is nearer on average, and yet lies behind the small one where they meet
  const std::vector<ScreenPolygon> polygons = {square(0, 0, 90, 100.0, -2.0), square(2, 40, 10, 70.0)};
  EXPECT_EQ(painters_order(polygons, screen_depth(polygons, 100, 100)), (std::vector<std::size_t>{0, 1}));
}

TEST(PaintersOrder, EndsWherePolygonsCoverOneAnotherInARing) {
  std::vector<ScreenPolygon> polygons;
  for (int i = 0; i < 3; ++i) {  // three planks, each over the next at one end and under the last at the other
    const double angle = 2.0 * 3.14159265358979 * i / 3.0;
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle)), across(-along[1], along[0]);
    ScreenPolygon plank{Eigen::Matrix3Xd(3, 4)};
    const Eigen::Vector2d middle = Eigen::Vector2d(50, 50) + 12.0 * across;
    int k = 0;
    for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      plank.corners.col(k++) << middle + 40.0 * u * along + 5.0 * v * across, 10.0 + u;
    polygons.push_back(plank);
  }
  EXPECT_EQ(painters_order(polygons, screen_depth(polygons, 100, 100)).size(), 3u);
}

TEST(MeshPicture, ShowsTheVisibleFacesAndTheLegend) {
  const std::string svg = mesh_picture_svg(block(4, 3, 2));
  // three sides of the block are seen
  EXPECT_EQ(occurrences(svg, "z\" fill="), 4u * 3 + 4 * 2 + 3 * 2);
  EXPECT_NE(svg.find(">left<"), std::string::npos);
  EXPECT_NE(svg.find("right &lt;&amp;&gt;"), std::string::npos);
  EXPECT_EQ(svg.find("<&>"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(occurrences(svg, "<svg"), 1u);
  EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
  for (const char* axis : {">x<", ">y<", ">z<", " m<"}) EXPECT_NE(svg.find(axis), std::string::npos) << axis;
}

TEST(MeshPicture, StaysSmallForFineMeshes) {
  const std::string svg = mesh_picture_svg(block(60, 50, 50), {.most_faces = 5000});
  EXPECT_LT(svg.size(), 600'000u);
  EXPECT_GT(occurrences(svg, "z\" fill="), 500u);
}

TEST(MeshPicture, ShowsWhatAModelHangsOn) {
  FiniteElementModel model;
  model.mesh = block(2, 2, 2);
  model.properties["left"] = SolidProperty{};
  model.properties["right <&>"] = SolidProperty{};
  model.fixed.push_back({.name = "base", .nodes = {0}});
  model.masses.push_back({.name = "mass", .node = 26, .mass = 1.0});
  model.links.push_back({.name = "link", .master = 26, .slaves = {24, 25}});
  const std::string svg = mesh_picture_svg(model, {.marks = {{MarkKind::point, 2, "p1"}, {MarkKind::finding, 8}}});
  for (const char* text : {">mass<", ">support<", ">link<", ">point<", ">finding<", ">p1<"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  EXPECT_EQ(svg.find(">spring<"), std::string::npos);
}

TEST(MeshPicture, SymbolsBehindTheSurfaceAreFaint) {
  const Mesh mesh = block(2, 2, 2);
  const auto faint = [&](Index node) {
    return mesh_picture_svg(mesh, {.marks = {{MarkKind::mass, node}}}).find("<g opacity") != std::string::npos;
  };
  EXPECT_TRUE(faint(13));   // the middle of the block
  EXPECT_FALSE(faint(20));  // the corner nearest to the eye: x = 2, y = 0, z = 1
}

TEST(MeshPicture, OddMeshesGivePictures) {
  EXPECT_NE(mesh_picture_svg(Mesh{}).find("nothing to draw"), std::string::npos);
  Mesh mesh;  // one line along the eye's direction, one cell without extent
  mesh.nodes.setZero(3, 3);
  mesh.node_ids = {1, 2, 3};
  mesh.regions["flat"].push_back(mesh.add_cell(CellShape::triangle3, 1, std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(mesh_picture_svg(mesh).find("nan"), std::string::npos);
  mesh.nodes.col(1) << 1e-9, 0.0, 0.0;
  mesh.regions["line"].push_back(mesh.add_cell(CellShape::line2, 2, std::vector<Index>{0, 1}));
  const std::string svg = mesh_picture_svg(mesh);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(DrawnRegions, StandInNaturalOrder) {
  FiniteElementModel model;
  for (const std::string region : {"1", "2", "10", "11", "arm2", "arm10"}) {
    model.mesh.regions[region] = {};
    model.properties[region] = {};
  }
  model.properties["without cells"] = {};
  EXPECT_EQ(drawn_regions(model), (std::vector<std::string>{"1", "2", "10", "11", "arm2", "arm10"}));
}

}  // namespace
}  // namespace kalfem
