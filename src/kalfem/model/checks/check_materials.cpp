// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem::report {
namespace {

using Eigen::Index;
using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr double least_size = 5e-3, most_size = 500.0;  ///< of a structure that is tested for vibration [m]
constexpr double much_stiffer = 1e6;

struct KindName {
  std::string operator()(const ShellProperty&) const { return "shell"; }
  std::string operator()(const LaminateProperty&) const { return "laminate"; }
  std::string operator()(const BeamProperty&) const { return "beam"; }
  std::string operator()(const SolidProperty&) const { return "solid"; }
};

/// Mass of a region of the given length, area or volume.
struct MassOfRegion {
  double density, measure;
  double operator()(const ShellProperty& shell) const {
    return (density * shell.thickness + shell.nonstructural_mass) * measure;
  }
  double operator()(const LaminateProperty& laminate) const { return laminate.mass * measure; }
  double operator()(const BeamProperty& beam) const {
    return (density * beam.section.area + beam.nonstructural_mass) * measure;
  }
  double operator()(const SolidProperty&) const { return density * measure; }
};

// Measures a region by its cells of the highest dimension: a region of solids may list faces and sides of its mesh.
// The mass follows from the property and the measure, so it includes nodes that supports hold.
RegionCheck region_check(const FiniteElementModel& model, const std::string& name, const std::vector<Index>& cells) {
  RegionCheck region{.name = name, .kind = {}, .material = {}, .cells = static_cast<Index>(cells.size())};
  int highest = 0;
  for (const auto index : cells)
    highest = std::max(highest, dimension(model.mesh.cells[static_cast<std::size_t>(index)].shape));
  for (const auto index : cells) {
    const Cell& cell = model.mesh.cells[static_cast<std::size_t>(index)];
    if (dimension(cell.shape) == highest && highest > 0) region.measure += cell_measure(model.mesh, cell);
  }
  const auto property = model.properties.find(name);
  if (property == model.properties.end()) return region;
  region.kind = std::visit(KindName{}, property->second);
  region.material = material_of(property->second);
  if (const auto* shell = std::get_if<ShellProperty>(&property->second)) region.thickness = shell->thickness;
  if (const auto* beam = std::get_if<BeamProperty>(&property->second)) region.area = beam->section.area;
  const auto material = model.materials.find(region.material);
  const double density = material == model.materials.end() ? 0.0 : material->second.density;
  region.mass = std::visit(MassOfRegion{density, region.measure}, property->second);
  return region;
}

void tell_regions(const ModelCheckReport& report, std::vector<ModelFinding>& findings) {
  const double size = (report.highest - report.lowest).norm();
  for (const auto& region : report.regions) {
    if (region.kind.empty() && region.cells > 0 && region.measure > 0.0)
      findings.push_back(
          {Severity::note, Topic::mesh,
           "the region '" + region.name + "' of " + std::to_string(region.cells) + " elements has no property",
           "it is not part of the model", "give it a property to include it"});
    const double width = region.thickness > 0.0 ? region.thickness : std::sqrt(region.area);
    if (width > 0.25 * size && size > 0.0)
      findings.push_back({Severity::warning, Topic::units,
                          "the " + std::string(region.thickness > 0.0 ? "thickness" : "width") + " of region '" +
                              region.name + "', " + to_string(width) + " m, is " + to_string(width / size) +
                              " times the size of the whole structure",
                          "shells and beams are thin; its unit may differ from that of the coordinates",
                          "check the units of sections and coordinates"});
  }
}

std::string title_of(const MaterialCheck& material) {
  const auto& values = material.values;
  return "the material '" + material.name + "' (E = " + to_string(values.youngs_modulus) + " Pa, density " +
         to_string(values.density) + " kg/m^3, wave speed " + to_string(material.wave_speed) + " m/s)";
}

/// Of a material whose values are usual in other units than SI.
std::optional<ModelFinding> other_units(const MaterialCheck& material) {
  const auto fitting = units_that_fit(material.values);
  if (fitting.empty()) return std::nullopt;
  const auto& guess = fitting.front();
  std::string others;
  for (std::size_t i = 1; i < fitting.size(); ++i)
    others += std::string(i == 1 ? ", or " : ", ") + fitting[i].units.name;
  return ModelFinding{Severity::warning, Topic::units,
                      title_of(material) + " is not a common material in SI; in " + guess.units.name + others +
                          " it would be " + guess.material.name,
                      "the model seems not to be in SI units, so masses and frequencies would be wrong",
                      std::string("declare the units: length ") + guess.units.length + ", mass " + guess.units.mass +
                          ", time " + guess.units.time};
}

/// Whether a material that is used is a usual one in SI: an odd one beside it is a stand-in, a dummy, a smeared core.
bool is_in_si(const std::vector<MaterialCheck>& materials) {
  return std::ranges::any_of(materials, [](const MaterialCheck& material) {
    return !material.resembles.empty() && !material.used_by.empty();
  });
}

void tell_material(const MaterialCheck& material, bool in_si, std::vector<ModelFinding>& findings) {
  if (material.used_by.empty()) {
    findings.push_back({Severity::note, Topic::materials, "the material '" + material.name + "' is not used", "", ""});
    return;
  }
  const auto& values = material.values;
  if (!material.resembles.empty() || !(values.youngs_modulus > 0.0)) return;
  const std::string title = title_of(material);
  if (!(values.density > 0.0)) {
    findings.push_back({Severity::note, Topic::materials, title + " has no density", "its elements have no mass", ""});
    return;
  }
  if (auto units = in_si ? std::nullopt : other_units(material))
    findings.push_back(std::move(*units));
  else
    findings.push_back({Severity::note, Topic::materials, title + " is not a common structural material",
                        "typical wave speeds: about 5000 m/s in metals, 2000 to 10000 in composites, 4000 in wood, 30 "
                        "to 400 in rubber",
                        "check its values and units"});
}

void tell_size(const ModelCheckReport& report, std::vector<ModelFinding>& findings) {
  const double size = (report.highest - report.lowest).norm();
  if (report.nodes < 2 || size == 0.0 || (size >= least_size && size <= most_size)) return;
  findings.push_back(
      {Severity::warning, Topic::units, "the model is " + to_string(size) + " m large",
       size > most_size ? "its coordinates may be in millimetres" : "its coordinates may not be in metres",
       "declare the unit of length, unless the structure has this size"});
}

std::vector<MaterialCheck> material_checks(const FiniteElementModel& model) {
  std::map<std::string, std::vector<std::string>> users;
  for (const auto& [region, property] : model.properties)
    if (const auto material = material_of(property); !material.empty()) users[material].push_back(region);
  std::vector<MaterialCheck> materials;
  for (const auto& [name, values] : model.materials) {
    const auto usual = usual_material(values.youngs_modulus, values.density);
    materials.push_back({.name = name,
                         .values = values,
                         .wave_speed = wave_speed(values),
                         .resembles = usual ? usual->name : "",
                         .used_by = users[name]});
  }
  return materials;
}

}  // namespace

// Regions and materials are listed with their values and what they resemble. One usual material in SI is enough to
// believe the units; otherwise values that are usual in other units are told with them.
void check_materials(const FiniteElementModel& model, ModelCheckReport& report) {
  for (const auto& [region, cells] : model.mesh.regions) report.regions.push_back(region_check(model, region, cells));
  report.materials = material_checks(model);
  for (const auto& material : report.materials) tell_material(material, is_in_si(report.materials), report.findings);
  tell_regions(report, report.findings);
  tell_size(report, report.findings);
}

// A spring is compared with what everything but springs gives to the same entry of the diagonal: a ratio of a million
// costs six digits in every solution.
void check_springs(const FiniteElementModel& model, const AssembledModel& assembled, const SparseMatrix& stiffness,
                   ModelCheckReport& report) {
  const Eigen::VectorXd diagonal = stiffness.diagonal();
  std::map<Index, double> of_springs;  // what all springs give to a diagonal entry
  const auto add = [&](const NodalDof& dof, double value) {
    if (const Index place = assembled.find(dof); place >= 0) of_springs[place] += value;
  };
  for (const auto& spring : model.springs) {
    add(spring.from, spring.stiffness);
    if (spring.to) add(*spring.to, spring.stiffness);
  }
  ModelFinding finding{Severity::warning, Topic::stiffness, "",
                       "such a ratio costs six digits of accuracy in every solution",
                       "use a rigid link, or a stiffness closer to that of the structure"};
  std::vector<std::string> names;
  Index count = 0;
  for (const auto& spring : model.springs) {
    const Index place = assembled.find(spring.from);
    if (place < 0) continue;
    const double others = diagonal[place] - of_springs[place];
    if (!(others > 1e-12 * diagonal[place]) || spring.stiffness <= much_stiffer * others) continue;
    if (names.size() < most_named)
      names.push_back("'" + spring.name + "' (" + to_string(spring.stiffness / others) + " times)");
    if (finding.nodes.size() < 1000) finding.nodes.push_back(spring.from.node);
    ++count;
  }
  finding.what = std::to_string(count) +
                 " springs are more than a million times stiffer than their surroundings: " + listed(names, count);
  if (count > 0) report.findings.push_back(std::move(finding));
}

}  // namespace kalfem::report

namespace kalfem {

std::optional<ModelFinding> units_finding(const FiniteElementModel& model) {
  const auto materials = report::material_checks(model);
  if (report::is_in_si(materials)) return std::nullopt;
  for (const auto& material : materials)
    if (!material.used_by.empty())
      if (auto units = report::other_units(material)) return units;
  return std::nullopt;
}

}  // namespace kalfem
