// SPDX-License-Identifier: Apache-2.0
// Points of a test are laid on a mesh under any turn, shift and noise; what cannot be told is said.
#include "kalfem/correlation/point_match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <numbers>
#include <random>
#include <set>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// A deck 12 m long and 3 m wide of squares of `size`, with a mast 4 m high at one corner and a wall along a part of
/// one side: no turn or mirror image of it is itself.
Mesh bridge(double size) {
  std::vector<Vector3d> places;
  const int length = static_cast<int>(std::lround(12.0 / size)), width = static_cast<int>(std::lround(3.0 / size));
  for (int i = 0; i <= length; ++i)
    for (int k = 0; k <= width; ++k) places.emplace_back(size * i, size * k, 0.0);
  for (int i = 1; i <= static_cast<int>(std::lround(4.0 / size)); ++i) places.emplace_back(0.0, 0.0, size * i);
  for (int i = 0; i <= static_cast<int>(std::lround(5.0 / size)); ++i)
    for (int k = 1; k <= static_cast<int>(std::lround(1.0 / size)); ++k) places.emplace_back(size * i, 3.0, size * k);
  Mesh mesh;
  mesh.nodes.resize(3, std::ssize(places));
  for (std::size_t i = 0; i < places.size(); ++i) {
    mesh.nodes.col(static_cast<Index>(i)) = places[i];
    mesh.node_ids.push_back(static_cast<std::int64_t>(i) + 1);
  }
  return mesh;
}

/// The deck alone: half a turn about its middle, and two about its axes, are itself.
Mesh rectangle(double size) {
  Mesh mesh;
  const int length = static_cast<int>(std::lround(4.0 / size)), width = static_cast<int>(std::lround(2.0 / size));
  mesh.nodes.resize(3, (length + 1) * (width + 1));
  for (int i = 0; i <= length; ++i)
    for (int k = 0; k <= width; ++k) mesh.nodes.col(i * (width + 1) + k) << size * i, size * k, 0.0;
  for (Index i = 0; i < mesh.nodes.cols(); ++i) mesh.node_ids.push_back(i + 1);
  return mesh;
}

struct SetUp {
  std::vector<TestPoint> points;
  std::vector<Index> nodes;
  Eigen::Matrix3d rotation;  ///< of the test's axes to the model's
};

SetUp set_up(const Mesh& mesh, std::size_t count, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  SetUp made;
  std::vector<Index> all(static_cast<std::size_t>(mesh.node_count()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
  std::ranges::shuffle(all, random);
  made.nodes.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
  made.rotation = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  const Vector3d shift(20.0 * normal(random), 20.0 * normal(random), 20.0 * normal(random));
  for (const auto node : made.nodes) {
    const Vector3d error = noise * Vector3d(normal(random), normal(random), normal(random));
    made.points.push_back(
        {"p" + std::to_string(node), made.rotation.transpose() * (mesh.nodes.col(node) - shift) + error});
  }
  return made;
}

struct Count {
  int right = 0, unsure = 0, wrong = 0;  ///< wrong: sure, and another node
};

Count count_of(const PointMatch& match, const SetUp& made) {
  Count count;
  for (std::size_t i = 0; i < made.nodes.size(); ++i) {
    if (match.points[i].node == made.nodes[i])
      ++count.right;
    else if (match.points[i].sure)
      ++count.wrong;
    if (!match.points[i].sure) ++count.unsure;
  }
  return count;
}

// Where all points lie within the deck, which is regular, other positions fit as well: these set-ups are said to allow
// several, and no point of them is sure of a wrong node.
TEST(PointMatch, FindsTheNodesOfRandomSetUps) {
  const Mesh mesh = bridge(0.25);
  int unique = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto made = set_up(mesh, 30, 0.005, seed);
    const auto match = match_points(made.points, mesh);
    const auto count = count_of(match, made);
    EXPECT_EQ(count.wrong, 0) << "set-up " << seed;
    if (!match.others.empty()) continue;
    ++unique;
    EXPECT_EQ(count.right, 30) << "set-up " << seed;
    EXPECT_TRUE(match.sure()) << "set-up " << seed;
    // 5 mm in each of three coordinates, less the six numbers of the fit: 8.4 mm, and three times the chance of it
    EXPECT_NEAR(match.fit.rms, 0.0084, 0.0020);
    EXPECT_LT((match.fit.rotation - made.rotation).norm(), 0.005);
  }
  std::printf("%d of 20 set-ups have one position, with all nodes right\n", unique);
  EXPECT_GE(unique, 10);
}

// Nodes 20 mm apart and 5 mm of noise: some points are nearer to a neighbour of their node. None of them may be sure.
TEST(PointMatch, SaysWhichPointsAreNotSure) {
  Mesh mesh = bridge(0.25);
  const Index count = mesh.nodes.cols();
  mesh.nodes.conservativeResize(3, 2 * count);
  mesh.nodes.rightCols(count) = mesh.nodes.leftCols(count).colwise() + Vector3d(0.02, 0.0, 0.0);
  for (Index i = 0; i < count; ++i) mesh.node_ids.push_back(count + i + 1);
  int wrong = 0, unsure = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto made = set_up(mesh, 30, 0.005, seed);
    const auto found = count_of(match_points(made.points, mesh), made);
    wrong += found.wrong;
    unsure += found.unsure;
  }
  EXPECT_GT(unsure, 0);
  EXPECT_LE(wrong, 3);  // at most 2 % of 150 where each is sure to 99 %
}

TEST(PointMatch, SaysThatASymmetricStructureAllowsSeveralFits) {
  const Mesh mesh = rectangle(0.25);
  // Points at the ends allow no shift along the squares of the mesh: three turns besides the right one are left.
  std::vector<TestPoint> points;
  for (const Vector3d& place :
       {Vector3d(0, 0, 0), Vector3d(4, 0, 0), Vector3d(4, 2, 0), Vector3d(0, 2, 0), Vector3d(1, 0.5, 0)})
    points.push_back({"p" + std::to_string(points.size()), place + Vector3d(0.001, -0.001, 0.002)});
  const auto match = match_points(points, mesh);
  EXPECT_EQ(match.others.size(), 3u);
  // The one that lies within is at one of four nodes.
  EXPECT_NEAR(match.points.back().probability, 0.25, 0.01);
  EXPECT_FALSE(match.sure());
}

TEST(PointMatch, FitsAFactorOfLength) {
  const Mesh mesh = bridge(0.25);
  auto made = set_up(mesh, 30, 0.0, 6);
  for (auto& point : made.points) point.place *= 1.02;
  const auto match = match_points(made.points, mesh, {.scale = true});
  EXPECT_EQ(count_of(match, made).right, 30);
  EXPECT_NEAR(match.fit.scale, 1.0 / 1.02, 1e-9);
}

TEST(PointMatch, TurnsTheSensorsAxes) {
  const Mesh mesh = bridge(0.25);
  auto made = set_up(mesh, 30, 0.0, 6);
  // The sensor looks along +y, -x, +z of the model.
  Eigen::Matrix3d axes;
  axes.col(0) = Vector3d::UnitY();
  axes.col(1) = -Vector3d::UnitX();
  axes.col(2) = Vector3d::UnitZ();
  made.points.front().axes = made.rotation.transpose() * axes;
  const auto match = match_points(made.points, mesh);
  EXPECT_LT((match.points.front().axes - axes).norm(), 1e-9);
  EXPECT_EQ(direction_words(match.points.front().axes.col(1)), "-x");
  EXPECT_EQ(direction_words(Vector3d(1.0, 0.0, 1.0)), "(0.71, 0, 0.71)");
}

TEST(PointMatch, RefusesWhatHasNoPosition) {
  const Mesh mesh = bridge(0.5);
  const auto problem = [&](const std::vector<TestPoint>& points) {
    try {
      match_points(points, mesh);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(problem({{"a", {0, 0, 0}}, {"b", {1, 0, 0}}, {"c", {0, 1, 0}}}).find("3 points"), std::string::npos);
  EXPECT_NE(problem({{"a", {0, 0, 0}}, {"b", {1, 0, 0}}, {"c", {2, 0, 0}}, {"d", {5, 0, 0}}}).find("one line"),
            std::string::npos);
  EXPECT_NE(problem({{"a", {0, 0, 0}}, {"b", {1e4, 0, 0}}, {"c", {0, 3e3, 0}}, {"d", {5e3, 0, 4e3}}}).find("units"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem
