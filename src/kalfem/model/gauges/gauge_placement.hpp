#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "kalfem/model/gauges/strain_gauge.hpp"

namespace kalfem {

/// A strain gauge as its user describes it.
struct GaugeDescription {
  std::string name;
  std::variant<Eigen::Vector3d, std::int64_t> place;  ///< in global axes [m], or the centre of an element by its number
  std::optional<Eigen::Vector3d> direction = {};      ///< in global axes, of any length; not needed on a beam
  std::optional<Layer> surface = {};                  ///< of a shell: required there, and refused elsewhere
  std::optional<Eigen::Vector2d> fibre = {};  ///< of a beam: local y and z from the centroid [m]; empty: the centroid
  std::string region = {};                    ///< only elements of this region; empty: of all
};

/// The element under a gauge. A place takes the nearest element; where several meet, the first of the mesh. Throws
/// InvalidInput where the element or region does not exist, the place is farther from the elements than their size or
/// on a fold of shells, and where direction, surface or fibre do not suit the element.
StrainGauge place_gauge(const FiniteElementModel& model, const GaugeDescription& given);

}  // namespace kalfem
