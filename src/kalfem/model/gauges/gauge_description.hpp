// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

namespace kalfem {

/// Surface of a shell, by the normal of its element: the right-hand rule of its nodes.
enum class Layer { solid, top, middle, bottom };
/// "top"; "" of a solid.
const char* to_string(Layer layer);

/// A strain gauge as its user describes it: bonded to an element, it measures the normal strain along its direction.
struct GaugeDescription {
  std::string name;
  std::variant<Eigen::Vector3d, std::int64_t> place;  ///< in global axes [m], or the centre of an element by its number
  std::optional<Eigen::Vector3d> direction = {};      ///< in global axes, of any length; not needed on a beam
  std::optional<Layer> surface = {};                  ///< of a shell: required there, and refused elsewhere
  std::optional<Eigen::Vector2d> fibre = {};  ///< of a beam: local y and z from the centroid [m]; empty: the centroid
  std::string region = {};                    ///< only elements of this region; empty: of all
};

}  // namespace kalfem
