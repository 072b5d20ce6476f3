// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/scene.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "pictures/sample_scene.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// The numbers in a base64 text.
template <typename Number>
std::vector<Number> unpacked(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text.substr(0, text.find('='))) {
    bits = bits << 6U | static_cast<std::uint32_t>(digits.find(c));
    if ((count += 6) >= 8) bytes += static_cast<char>(bits >> static_cast<std::uint32_t>(count -= 8) & 255U);
  }
  EXPECT_EQ(bytes.size() % sizeof(Number), 0u);
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

/// A triangle with one mode.
Scene triangle() {
  Scene scene{.title = "t", .regions = {"r"}};
  scene.places = Eigen::Matrix3d::Identity();
  scene.faces = {{{0, 1, 2}, 3, 0}};
  scene.fields = {{"mode 1: 1.00 Hz", Eigen::VectorXd::LinSpaced(9, -4.0, 4.0)}};
  return scene;
}

TEST(Scene, NumbersSurviveTheirPacking) {
  const auto json = as_json(triangle());
  EXPECT_EQ(unpacked<float>(json["places"]), (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(unpacked<std::int32_t>(json["faces"]), (std::vector<std::int32_t>{0, 3, 0, 1, 2}));
  const auto& shape = json["fields"][0]["shapes"][0];
  const auto steps = unpacked<std::int16_t>(shape["steps"]);
  ASSERT_EQ(steps.size(), 9u);
  for (int k = 0; k < 9; ++k)
    EXPECT_NEAR(steps[static_cast<std::size_t>(k)] * shape["factor"].get<double>(), k - 4.0, 4.0 / 65534.0);
  EXPECT_FLOAT_EQ(json["fields"][0]["peak"].get<float>(), std::sqrt(4.0F + 9.0F + 16.0F));
}

TEST(Scene, EveryMotionIsKeptByItsPrincipalShapes) {
  const MatrixXd shapes = MatrixXd::Random(60, 3), coordinates = MatrixXd::Random(3, 40);
  std::vector<double> times(40);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = 0.1 * static_cast<double>(k);
  const MatrixXd motion = shapes * coordinates;
  const SceneField field = motion_field("m", times, motion, 40);
  EXPECT_EQ(field.shapes.cols(), 3);
  EXPECT_LT((field.shapes * field.coordinates - motion).norm(), 1e-9 * motion.norm());
}

TEST(Scene, AMotionOfManyShapesIsKeptAsWellAsAsked) {
  MatrixXd motion = MatrixXd::Random(90, 50);
  for (Index k = 0; k < 30; ++k) motion.middleRows(3 * k, 3) *= std::pow(0.5, static_cast<double>(k));
  std::vector<double> times(50);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = static_cast<double>(k);
  const auto error = [&](Index most, double tolerance) {
    const SceneField field = motion_field("m", times, motion, most, tolerance);
    EXPECT_LE(field.shapes.cols(), most);
    return (field.shapes * field.coordinates - motion).norm() / motion.norm();
  };
  EXPECT_LT(error(50, 1e-3), 1e-3);
  EXPECT_LT(error(50, 0.1), 0.1);
  EXPECT_GT(error(50, 0.1), 1e-3);  // no more shapes than that takes
  EXPECT_GT(error(2, 1e-3), 1e-3);
}

TEST(Scene, EveryMistakeIsNamed) {
  EXPECT_TRUE(mistakes_of(triangle()).empty());
  EXPECT_TRUE(mistakes_of(sample_scene()).empty());
  const auto mistake = [](auto damage) {
    Scene scene = triangle();
    damage(scene);
    const auto mistakes = mistakes_of(scene);
    return mistakes.size() == 1 ? mistakes.front() : std::to_string(mistakes.size()) + " mistakes";
  };
  const std::string corner = "a face names a corner or region that it has not";
  EXPECT_EQ(mistake([](Scene& s) { s.faces.clear(); }), "it has no faces");
  EXPECT_EQ(mistake([](Scene& s) { s.places(0, 0) = std::nan(""); }), "a place is not finite");
  EXPECT_EQ(mistake([](Scene& s) { s.faces[0].nodes[1] = 3; }), corner);
  EXPECT_EQ(mistake([](Scene& s) { s.faces[0].count = 5; }), corner);
  EXPECT_EQ(mistake([](Scene& s) { s.faces[0].region = 1; }), corner);
  EXPECT_EQ(mistake([](Scene& s) { s.marks = {{SceneMarkKind::mass, 3}}; }), "a mark has no place");
  EXPECT_EQ(mistake([](Scene& s) { s.lines = {{SceneLineKind::link, 0, -1}}; }), "a line has no place");
  const std::string field = "field 'mode 1: 1.00 Hz': ";
  const auto field_mistake = [&](auto damage) { return mistake([&](Scene& s) { damage(s.fields[0]); }); };
  EXPECT_EQ(field_mistake([](SceneField& f) { f.shapes.resize(6, 1); }), field + "its shapes have 6 rows for 3 places");
  EXPECT_EQ(field_mistake([](SceneField& f) { f.shapes.setZero(9, 2); }), field + "it has 2 shapes");
  EXPECT_EQ(field_mistake([](SceneField& f) { f.shapes(3, 0) = INFINITY; }),
            field + "it holds a number that is not finite");
  EXPECT_EQ(field_mistake([](SceneField& f) {
              f.times = {0.0, 1.0};
            }),
            field + "its coordinates are 0 x 0 for 1 shapes at 2 times");
  EXPECT_EQ(field_mistake([](SceneField& f) {
              f.times = {1.0, 1.0};
              f.coordinates.setZero(1, 2);
            }),
            field + "its times do not increase");
}

}  // namespace
}  // namespace kalfem
