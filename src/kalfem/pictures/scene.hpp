// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kalfem/pictures/drawn_surface.hpp"

namespace kalfem {

/// What a symbol on a structure stands for.
/// `measured`: where a sensor was in a measured shape, only with fields that hold one.
enum class SceneMarkKind { sensor, input, boundary, connector, spring, mass, support, measured };

/// A symbol at a place of a structure; it moves with the structure.
struct SceneMark {
  SceneMarkKind kind = SceneMarkKind::sensor;
  Eigen::Index place = 0;
  std::string label = {};  ///< written beside it
};

enum class SceneLineKind {
  link,       ///< a rigid or weighted link: thin
  connector,  ///< a connector or a spring: dashed
  measured    ///< from a place at rest to where it was measured: thick, only with fields that hold a measured shape
};

/// A line between two places that is no part of the mesh.
struct SceneLine {
  SceneLineKind kind = SceneLineKind::link;
  Eigen::Index from = 0, to = 0;
};

/// Displacements of all places over time, u(t) = sum_i q_i(t) s_i: of a mode the shape alone, which oscillates.
struct SceneField {
  std::string name;                  ///< "mode 3: 24.31 Hz"
  Eigen::MatrixXd shapes;            ///< s, 3 places x shapes: x, y and z of the first place, of the second, ... [m]
  std::vector<double> times = {};    ///< of a motion, increasing [s]; empty: a mode, with one shape
  Eigen::MatrixXd coordinates = {};  ///< q of a motion [-], shapes x times
  bool measured = false;             ///< a measured shape stands beside that of the model
};

/// A structure that the reader of a page turns, and that takes the shapes of its modes and motions.
struct Scene {
  std::string title = {};
  std::string caption = {};
  Eigen::Matrix3Xd places = {};       ///< [m]
  std::vector<DrawnFace> faces = {};  ///< their nodes are columns of `places`, their regions places in `regions`
  std::vector<std::string> regions = {};
  std::vector<SceneMark> marks = {};
  std::vector<SceneLine> lines = {};
  std::vector<SceneField> fields = {};
};

/// A motion in at most `most_shapes` principal shapes (proper orthogonal decomposition): the fewest whose error is
/// below `tolerance` of the motion, both as rms over places and times. `displacement`: 3 places x times [m].
SceneField motion_field(const std::string& name, const std::vector<double>& times, const Eigen::MatrixXd& displacement,
                        Eigen::Index most_shapes, double tolerance = 1e-3);

/// What is wrong with a scene, one sentence each: places, regions and fields that do not fit, numbers that are not
/// finite. Empty: it can be drawn.
std::vector<std::string> mistakes_of(const Scene& scene);

/// A scene as the page's script reads it. Lists of numbers are base64 of their little-endian bytes: places and
/// coordinates as 32-bit floats, faces as 32-bit integers, shapes as 16-bit integers with one factor for each shape.
nlohmann::ordered_json as_json(const Scene& scene);

}  // namespace kalfem
