// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/rewriting/region_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kalfem::rewriting {
namespace {

template <class Matrix>
void append(std::vector<double>& numbers, const Matrix& matrix) {
  const Eigen::MatrixXd values = matrix;
  numbers.insert(numbers.end(), values.data(), values.data() + values.size());
}

void append(std::vector<double>& numbers, const BeamSection& section) {
  for (const double value : {section.area, section.inertia_y, section.inertia_z, section.torsion,
                             section.shear_factor_y, section.shear_factor_z, section.product_yz})
    numbers.push_back(value);
  append(numbers, section.centroid);
}

/// What a property states beside its material.
struct Appended {
  std::vector<double>& numbers;

  void operator()(const ShellProperty& shell) const {
    for (const double value : {shell.thickness, shell.offset, shell.nonstructural_mass}) numbers.push_back(value);
  }
  void operator()(const LaminateProperty& laminate) const {
    for (const auto* matrix : {&laminate.stiffness.membrane, &laminate.stiffness.coupling, &laminate.stiffness.bending})
      append(numbers, *matrix);
    append(numbers, laminate.stiffness.shear);
    for (const double value : {laminate.mass, laminate.rotary_inertia, laminate.offset}) numbers.push_back(value);
  }
  void operator()(const BeamProperty& beam) const {
    append(numbers, beam.section);
    numbers.push_back(beam.nonstructural_mass);
    for (const auto& station : beam.stations) append(numbers, station.section);
  }
  void operator()(const SolidProperty& solid) const {
    if (solid.elasticity) append(numbers, *solid.elasticity);
  }
};

/// The next to no stiffness of shells about their normal (K6ROT) follows their material: nobody states it.
bool is_of_shells(const std::string& name) { return name.starts_with("drilling"); }

bool near(double one, double other, double tolerance) {
  return std::abs(one - other) <= tolerance * std::max(std::abs(one), std::abs(other));
}

}  // namespace

ModelNumbers numbers_of(const FiniteElementModel& model) {
  ModelNumbers numbers;
  for (const auto& [region, property] : model.properties) {
    auto& values = numbers.regions[region];
    values = {0.0, 0.0, 0.0};
    if (const auto material = model.materials.find(material_of(property)); material != model.materials.end())
      values = {material->second.youngs_modulus, material->second.density, material->second.poissons_ratio};
    std::visit(Appended{values}, property);
  }
  for (const auto& spring : model.springs) numbers.others[spring.name + ".stiffness"] = spring.stiffness;
  for (const auto& joint : model.joints)
    if (!is_of_shells(joint.name)) numbers.others[joint.name + ".stiffness"] = joint.stiffness;
  for (const auto& mass : model.masses) numbers.others[mass.name + ".mass"] = mass.mass;
  for (const auto& matrices : model.matrices) {
    if (is_of_shells(matrices.name)) continue;
    for (const auto& [what, matrix] :
         {std::pair{"stiffness", &matrices.stiffness}, {"mass", &matrices.mass}, {"damping", &matrices.damping}})
      numbers.others["matrices " + matrices.name + "." + what] = matrix->nonZeros() > 0 ? matrix->norm() : 0.0;
  }
  numbers.nodes = static_cast<std::size_t>(model.mesh.node_count());
  numbers.cells = model.mesh.cells.size();
  numbers.equations = model.constraints.size() + model.links.size() + model.weighted_links.size() + model.fixed.size();
  return numbers;
}

std::string difference(const ModelNumbers& expected, const ModelNumbers& found) {
  constexpr double rounding = 2e-5, of_ratio = 1e-4;
  constexpr std::size_t poissons_ratio = 2;
  if (expected.nodes != found.nodes || expected.cells != found.cells || expected.equations != found.equations)
    return "it has other nodes, elements or constraints";
  for (const auto& [region, values] : expected.regions) {
    const auto other = found.regions.find(region);
    if (other == found.regions.end() || other->second.size() != values.size())
      return "there is no region '" + region + "' of this kind";
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool is_near = i == poissons_ratio ? std::abs(values[i] - other->second[i]) <= of_ratio
                                               : near(values[i], other->second[i], rounding);
      if (!is_near)
        return fmt::format("region '{}' would have {} in the place of {}", region, other->second[i], values[i]);
    }
  }
  for (const auto& [parameter, value] : expected.others) {
    const auto other = found.others.find(parameter);
    if (other == found.others.end() || !near(value, other->second, rounding))
      return fmt::format("'{}' would be {} in the place of {}", parameter,
                         other == found.others.end() ? 0.0 : other->second, value);
  }
  return found.others.size() == expected.others.size() ? "" : "it has other springs or masses";
}

}  // namespace kalfem::rewriting
