// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/mesh/properties.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

constexpr double pi = std::numbers::pi;

void require_lengths(const std::string& shape, std::initializer_list<double> lengths) {
  for (const double length : lengths)
    if (!(length > 0.0) || !std::isfinite(length))
      throw InvalidInput("a length of the " + shape + " section is " + std::to_string(length),
                         "lengths of a section must be positive and finite", "give them in m");
}

void require_hole(const std::string& shape, double wall, double smallest) {
  if (2.0 * wall >= smallest)
    throw InvalidInput("the wall " + std::to_string(wall) + " m of the " + shape + " section leaves no hole in " +
                           std::to_string(smallest) + " m",
                       "a tube must be hollow", "use the solid section or a thinner wall");
}

/// J = a c^3 (1/3 - 64/pi^5 c/a sum_{n odd} tanh(n pi a / 2c) / n^5), a the long side [TG70].
double rectangle_torsion(double one, double other) {
  const double a = std::max(one, other), c = std::min(one, other);
  double sum = 0.0;
  // The terms fall as n^-5: those beyond 399 are below 1e-12 of the sum.
  for (int n = 399; n >= 1; n -= 2) sum += std::tanh(n * pi * a / (2.0 * c)) / std::pow(n, 5);
  return a * c * c * c * (1.0 / 3.0 - 64.0 / std::pow(pi, 5) * c / a * sum);
}

/// Thin-walled box bent by a force along `depth` [Cow66]; both sides between the middles of the walls, of one
/// thickness.
double box_shear_factor(double depth, double breadth, double nu) {
  const double m = breadth / depth, n = m;
  const double bending = 12.0 + 72.0 * m + 150.0 * m * m + 90.0 * m * m * m;
  const double lateral = 11.0 + 66.0 * m + 135.0 * m * m + 90.0 * m * m * m;
  return 10.0 * (1.0 + nu) * std::pow(1.0 + 3.0 * m, 2) /
         (bending + nu * lateral + 10.0 * n * n * ((3.0 + nu) * m + 3.0 * m * m));
}

SectionOutline rectangle_outline(double width_y, double height_z) {
  const double y = 0.5 * width_y, z = 0.5 * height_z;
  return {.corners = {{-y, -z}, {y, -z}, {y, z}, {-y, z}}};
}

}  // namespace

BeamSection rectangular_section(double width_y, double height_z, double poissons_ratio) {
  require_lengths("rectangular", {width_y, height_z});
  const double area = width_y * height_z;
  const double shear = 10.0 * (1.0 + poissons_ratio) / (12.0 + 11.0 * poissons_ratio);
  return {.area = area,
          .inertia_y = area * height_z * height_z / 12.0,
          .inertia_z = area * width_y * width_y / 12.0,
          .torsion = rectangle_torsion(width_y, height_z),
          .shear_factor_y = shear,
          .shear_factor_z = shear,
          .outline = rectangle_outline(width_y, height_z)};
}

BeamSection circular_section(double diameter, double poissons_ratio) {
  require_lengths("circular", {diameter});
  const double inertia = pi * std::pow(diameter, 4) / 64.0;
  const double shear = 6.0 * (1.0 + poissons_ratio) / (7.0 + 6.0 * poissons_ratio);
  return {.area = pi * diameter * diameter / 4.0,
          .inertia_y = inertia,
          .inertia_z = inertia,
          .torsion = 2.0 * inertia,
          .shear_factor_y = shear,
          .shear_factor_z = shear,
          .outline = {.radius = 0.5 * diameter}};
}

BeamSection circular_tube_section(double outer_diameter, double wall, double poissons_ratio) {
  require_lengths("circular tube", {outer_diameter, wall});
  require_hole("circular tube", wall, outer_diameter);
  const double inner = outer_diameter - 2.0 * wall, ratio = std::pow(inner / outer_diameter, 2);
  const double inertia = pi * (std::pow(outer_diameter, 4) - std::pow(inner, 4)) / 64.0;
  const double full = std::pow(1.0 + ratio, 2);
  const double shear = 6.0 * (1.0 + poissons_ratio) * full /
                       ((7.0 + 6.0 * poissons_ratio) * full + (20.0 + 12.0 * poissons_ratio) * ratio);
  return {.area = pi * wall * (outer_diameter - wall),
          .inertia_y = inertia,
          .inertia_z = inertia,
          .torsion = 2.0 * inertia,
          .shear_factor_y = shear,
          .shear_factor_z = shear,
          .outline = {.radius = 0.5 * outer_diameter}};
}

BeamSection rectangular_tube_section(double width_y, double height_z, double wall, double poissons_ratio) {
  require_lengths("rectangular tube", {width_y, height_z, wall});
  require_hole("rectangular tube", wall, std::min(width_y, height_z));
  const double inner_y = width_y - 2.0 * wall, inner_z = height_z - 2.0 * wall;
  const double middle_y = width_y - wall, middle_z = height_z - wall;
  return {.area = width_y * height_z - inner_y * inner_z,
          .inertia_y = (width_y * std::pow(height_z, 3) - inner_y * std::pow(inner_z, 3)) / 12.0,
          .inertia_z = (height_z * std::pow(width_y, 3) - inner_z * std::pow(inner_y, 3)) / 12.0,
          .torsion = box_torsion(middle_y, middle_z, {wall, wall}, {wall, wall}),
          .shear_factor_y = box_shear_factor(middle_y, middle_z, poissons_ratio),
          .shear_factor_z = box_shear_factor(middle_z, middle_y, poissons_ratio),
          .outline = rectangle_outline(width_y, height_z)};
}

double box_torsion(double width, double height, const std::array<double, 2>& along_width,
                   const std::array<double, 2>& along_height) {
  double flexibility = 0.0, open = 0.0;
  for (const auto& [length, walls] : {std::pair{width, along_width}, {height, along_height}})
    for (const double wall : walls) {
      flexibility += length / wall;
      open += length * wall * wall * wall / 3.0;
    }
  return 4.0 * std::pow(width * height, 2) / flexibility + open;
}

std::string material_of(const RegionProperty& property) {
  return std::visit(
      [](const auto& kind) -> std::string {
        if constexpr (requires { kind.material; })
          return kind.material;
        else
          return {};
      },
      property);
}

int motions_per_node(const RegionProperty& property) { return std::holds_alternative<SolidProperty>(property) ? 3 : 6; }

Matrix6 in_global_axes(const Matrix6& elasticity, const Eigen::Matrix3d& axes) {
  constexpr std::array<std::pair<int, int>, 6> pairs = {{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}}};
  Matrix6 rotation;
  for (int local = 0; local < 6; ++local)
    for (int global = 0; global < 6; ++global) {
      const auto [i, j] = pairs[static_cast<std::size_t>(local)];
      const auto [k, l] = pairs[static_cast<std::size_t>(global)];
      // e_ij = sum_kl a_ki a_lj e_kl; engineering shear strains are twice the components.
      double value = axes(k, i) * axes(l, j);
      if (k != l) value = 0.5 * (value + axes(l, i) * axes(k, j));
      rotation(local, global) = i == j ? value : 2.0 * value;
    }
  const Matrix6 turned = rotation.transpose() * elasticity * rotation;
  return 0.5 * (turned + turned.transpose());
}

}  // namespace kalfem
