// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "kalfem/pictures/scene.hpp"

namespace kalfem {

/// A shape measured at some places, over that of a mode.
inline void add_measured_shape(Scene& scene, const std::vector<Eigen::Index>& at, const Eigen::VectorXd& shape) {
  const Eigen::Index before = scene.places.cols(), count = std::ssize(at);
  scene.places.conservativeResize(3, before + 2 * count);
  for (auto& field : scene.fields)
    field.shapes.conservativeResizeLike(Eigen::MatrixXd::Zero(3 * scene.places.cols(), field.shapes.cols()));
  Eigen::VectorXd measured = Eigen::VectorXd::Zero(3 * scene.places.cols());
  measured.head(3 * before) = scene.fields.front().shapes.col(0).head(3 * before);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index node = at[static_cast<std::size_t>(i)], rest = before + i, moving = rest + count;
    scene.places.col(rest) = scene.places.col(moving) = scene.places.col(node);
    measured.segment(3 * moving, 3) = shape.segment(3 * node, 3);
    scene.lines.push_back({SceneLineKind::measured, rest, moving});
    scene.marks.push_back({SceneMarkKind::measured, moving, ""});
  }
  scene.fields.push_back({.name = "measured 12.4 Hz over mode 1", .shapes = measured, .measured = true});
}

/// A plate of 2 m x 1 m on two legs, with every kind of mark and line, two modes and a motion of both.
inline Scene sample_scene() {
  using Eigen::Index;
  constexpr Index nx = 24, ny = 12;
  const auto node = [](Index i, Index j) { return j * (nx + 1) + i; };
  constexpr Index corners = (nx + 1) * (ny + 1);
  Scene scene{
      .title = "Structure of 'plate'", .caption = "A plate on two legs.", .regions = {"left <&>", "right", "legs"}};
  scene.places.resize(3, corners + 2);
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(3 * (corners + 2), 2);
  for (Index j = 0; j <= ny; ++j)
    for (Index i = 0; i <= nx; ++i) {
      const double x = double(i) / nx, y = double(j) / ny;
      scene.places.col(node(i, j)) << 2.0 * x, y, 0.0;
      shapes(3 * node(i, j) + 2, 0) = std::sin(std::numbers::pi * x) * std::sin(std::numbers::pi * y);
      shapes(3 * node(i, j) + 2, 1) = std::sin(2.0 * std::numbers::pi * x) * std::sin(std::numbers::pi * y);
    }
  for (Index j = 0; j < ny; ++j)
    for (Index i = 0; i < nx; ++i)
      scene.faces.push_back({{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)}, 4, 2 * i < nx ? 0 : 1});
  scene.places.col(corners) << 0.0, 0.0, -0.5;
  scene.places.col(corners + 1) << 2.0, 1.0, -0.5;
  scene.faces.push_back({{node(0, 0), corners}, 2, 2});
  scene.faces.push_back({{node(nx, ny), corners + 1}, 2, 2});
  scene.marks = {{SceneMarkKind::sensor, node(6, 6), "a1 <&>"}, {SceneMarkKind::boundary, node(6, 6), "p1"},
                 {SceneMarkKind::input, node(18, 6), "hammer"}, {SceneMarkKind::connector, node(nx, 0), "damper"},
                 {SceneMarkKind::spring, node(0, ny), ""},      {SceneMarkKind::mass, node(12, 6), "motor"},
                 {SceneMarkKind::support, corners, ""},         {SceneMarkKind::support, corners + 1, ""}};
  scene.lines = {{SceneLineKind::connector, node(nx, 0), corners + 1}, {SceneLineKind::link, node(12, 6), node(0, ny)}};
  std::vector<double> times;
  Eigen::MatrixXd motion(shapes.rows(), 101);
  for (Index k = 0; k < motion.cols(); ++k) {
    times.push_back(0.02 * double(k));
    motion.col(k) =
        1e-3 * (std::sin(6.0 * times.back()) * shapes.col(0) + std::cos(15.0 * times.back()) * shapes.col(1));
  }
  scene.fields = {{"mode 1: 12.50 Hz", shapes.col(0)},
                  {"mode 2: 31.25 Hz", shapes.col(1)},
                  motion_field("estimated motion", times, motion, 12)};
  add_measured_shape(scene, {node(6, 6), node(12, 6), node(18, 6)}, 1.1 * shapes.col(0));
  return scene;
}

}  // namespace kalfem
