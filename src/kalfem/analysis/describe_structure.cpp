// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <typeinfo>

#include "kalfem/analysis/case_origin.hpp"
#include "kalfem/analysis/case_sections.hpp"
#include "kalfem/study/identified_case.hpp"
#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {
namespace {

namespace d = description;
using Eigen::Index;

template <class Entries>
auto find(Entries& entries, const std::string& name) {
  return std::ranges::find(entries, name, [](const auto& entry) -> const std::string& { return entry.first; });
}

template <class T>
bool has(const std::vector<T>& parts, const std::string& name) {
  return std::ranges::find(parts, name, &T::name) != parts.end();
}

d::Points points_of(const DofCombination& weights) { return {{weights.begin(), weights.end()}, {}, {}}; }

/// A mass of a lumped substructure stands with the others of its node: "arm.x" and "arm.rz" as arm: {x: ..., rz: ...}.
void add_mass(const LumpedMass& mass, d::Substructure& part) {
  const auto dot = mass.dof.rfind('.');
  const std::string node = mass.dof.substr(0, dot),
                    direction = dot == std::string::npos ? "" : mass.dof.substr(dot + 1);
  if (part.masses.empty() || part.masses.back().first != node || direction.empty()) part.masses.push_back({node, {}});
  part.masses.back().second.push_back({direction, mass.mass});
}

d::Substructure described(const LumpedSubstructure& lumped, CaseInMaking& making) {
  if (!lumped.matrices.dofs.empty())
    making.refuse("substructure '" + lumped.name + "' is given by matrices",
                  "a case has masses and springs, or finite elements with matrices in a file", "build it from springs");
  d::Substructure part;
  for (const auto& mass : lumped.masses) add_mass(mass, part);
  for (const auto& spring : lumped.springs)
    part.springs.push_back({spring.name, {spring.from, {}, {}}, {spring.to, {}, {}}, spring.stiffness, spring.damping});
  std::ranges::remove_copy(lumped.grounds, std::back_inserter(part.grounds), "ground");
  for (const auto& [point, weights] : lumped.points) part.points.push_back({point, {weights.begin(), weights.end()}});
  part.damping.modal = lumped.modal_damping;
  part.damping.mass_factor = lumped.rayleigh.mass_factor;
  part.damping.stiffness_factor = lumped.rayleigh.stiffness_factor;
  return part;
}

/// The arguments from which the library makes the law again.
LawArguments arguments_of(const ConnectorLaw& law) {
  if (const auto* words = expression_of(law))
    return {.parameters = words->parameters,
            .force = words->force,
            .states = words->states,
            .signals = words->signals,
            .lets = words->lets};
  return {.parameters = law.parameters()};
}

/// Whether make_law() makes this law: one of a program may have any name.
bool is_of_library(const ConnectorLaw& law, const LawArguments& arguments) {
  const auto known = law_library();
  if (std::ranges::find(known, law.name(), &LawDescription::name) == known.end()) return false;
  const ConnectorLawPtr same = make_law(law.name(), arguments);
  const ConnectorLaw& made = *same;
  return typeid(made) == typeid(law);
}

d::Connector described(const ConnectorDescription& connector, CaseInMaking& making) {
  const ConnectorLaw& law = *connector.law;
  const LawArguments arguments = arguments_of(law);
  d::Connector made{.from = {connector.from, {}, {}}, .to = {connector.to, {}, {}}, .law = {law.name(), {}, {}}};
  if (!is_of_library(law, arguments) || !arguments.signals.empty()) {
    making.refuse("connector '" + connector.name + "' has the law '" + law.name() + "' of a program",
                  "a case has laws of the library and formulas", "write it as a formula");
    return made;
  }
  made.force = arguments.force;
  for (const auto& [quantity, rate] : arguments.states) made.states.push_back({quantity.name, {rate, quantity.unit}});
  for (const auto& [name, value] : arguments.lets) made.let.push_back({name, value});
  for (std::size_t i = 0; i < law.parameters().size(); ++i) {
    const auto& quantity = law.parameters()[i];
    const double value = connector.parameters[static_cast<Index>(i)];
    if (std::isfinite(value)) made.parameters.push_back({quantity.name, value_in(value, quantity.unit)});
  }
  return made;
}

/// Writes the sections that tell what a structure is.
class StructureSections {
public:
  StructureSections(const StructureDescription& structure, CaseInMaking& making)
      : structure_(structure),
        origin_(dynamic_cast<const CaseOrigin*>(structure.read.origin.get())),
        making_(making),
        given_(making.given) {}

  void write() {
    if (origin_) take_origin();
    write_substructures();
    write_connectors();
    for (std::size_t i = 0; i < structure_.parts.inputs.size(); ++i) write_input(i);
    if (const auto& damping = structure_.parts.damping) {
      const double up_to = damping->up_to.value_or(d::GlobalModalDamping{}.up_to);
      given_.damping = {{damping->ratios, up_to}, {}, {}};
    }
  }

private:
  [[nodiscard]] bool was_read(const auto& name, auto StructureParts::*list) const {
    return origin_ && has(origin_->structure->parts.*list, name);
  }

  /// The case as it was read, at the values that were set since.
  void take_origin() {
    const d::Case& read = *origin_->given;
    given_.substructures = read.substructures;
    given_.connectors = read.connectors;
    given_.joints = read.joints;
    given_.component = read.component;
    given_.excitation = read.excitation;
    stand_alone();
    const ParameterSet parameters(*origin_->structure);
    for (const auto& [name, value] : structure_.read.set) {
      const auto parameter = parameters.find(name);
      if (parameter && !put_value(given_, *origin_->structure, *parameter, value))
        making_.refuse("'" + name + "' has another value than the case that it was read with", "it has no key there");
    }
  }

  /// Signals of the case no longer take their length from `simulate`, nor their file from `record`.
  void stand_alone() {
    for (auto& [name, excitation] : given_.excitation) {
      if (excitation.signal) stand_alone("excitation." + name, *excitation.signal);
      if (excitation.velocity) name_file(*excitation.velocity);
    }
    for (auto& [name, connector] : given_.connectors) stand_alone("connectors." + name, connector);
    if (!given_.component) return;
    auto& component = given_.component->value;
    stand_alone("component", component.connector);
    for (auto* motion : {&component.motion, component.base_motion ? &*component.base_motion : nullptr}) {
      if (!motion) continue;
      stand_alone("component.motion", motion->value.signal);
      if (motion->value.velocity) name_file(*motion->value.velocity);
    }
  }

  void stand_alone(const std::string& owner, d::Connector& connector) {
    for (auto& [name, feed] : connector.signals) stand_alone(owner + ".signals." + name, feed.value.signal);
  }

  void stand_alone(const std::string& path, d::Signal& signal) {
    const auto& simulate = origin_->given->simulate;
    std::visit(
        [&](auto& each) {
          if constexpr (requires { each.duration.emplace(0.0); })
            if (!each.duration && simulate) each.duration = simulate->duration;
        },
        signal);
    if (auto* channel = std::get_if<d::ChannelSignal>(&signal)) name_file(*channel);
    if (const auto* file = std::get_if<d::FileSignal>(&signal); file && file->align)
      making_.refuse(path + ".align", "it is aligned with the record as it was measured",
                     "state the delay that was found: `delay`");
  }

  void name_file(d::ChannelSignal& channel) {
    const auto& record = origin_->given->record;
    if (channel.file || !record) return;
    if (!record->group.empty())
      making_.refuse("channel '" + channel.channel.value + "' of the dataset '" + record->group + "'",
                     "a signal names its file, but no dataset", "export it as a table");
    channel.file = record->file.value;
    if (!channel.sample_rate) channel.sample_rate = record->sample_rate;
  }

  void write_substructures() {
    for (const auto& part : structure_.parts.substructures)
      if (!was_read(part.name, &StructureParts::substructures))
        given_.substructures.emplace_back(part.name, described(part, making_));
    for (const auto& elements : structure_.finite_elements)
      making_.refuse("finite elements '" + elements.name() + "' are in memory",
                     "a case names the file that they come from", "describe them in a case file, and read that");
  }

  void write_connectors() {
    for (const auto& connector : structure_.parts.connectors)
      if (!was_read(connector.name, &StructureParts::connectors))
        given_.connectors.emplace_back(connector.name, described(connector, making_));
  }

  void write_input(std::size_t index) {
    const InputDescription& input = structure_.parts.inputs[index];
    const auto samples = structure_.samples.find(input.name);
    const bool driven = samples != structure_.samples.end();
    if (was_read(input.name, &StructureParts::inputs) && !driven) return;
    if (!driven) {
      making_.refuse(
          "input '" + input.name + "' " + (structure_.signals[index] ? "has a signal of a program" : "has no signal"),
          "a case names the samples of its inputs", "give its samples with their rate");
      return;
    }
    auto excitation = find(given_.excitation, input.name);
    if (excitation == given_.excitation.end() && was_read(input.name, &StructureParts::inputs)) {
      making_.refuse("input '" + input.name + "' has other samples than the case that it was read with",
                     "it has no key of its own under `excitation`");
      return;
    }
    if (excitation == given_.excitation.end())
      excitation = given_.excitation.insert(excitation, {input.name, d::Excitation{}});
    excitation->second =
        d::Excitation{.target = target_of(input), .signal = file_of(input, samples->second), .drift = {}};
  }

  decltype(d::Excitation::target) target_of(const InputDescription& input) {
    if (input.kind == InputKind::force) return d::Force{{input.target, {}, {}}};
    if (input.kind == InputKind::base_acceleration)
      return d::BaseAcceleration{points_of(input.direction.empty() ? DofCombination{{"all", 1.0}} : input.direction)};
    if (input.direction.size() > 1 || (input.direction.size() == 1 && input.direction.begin()->second != 1.0))
      making_.refuse("input '" + input.name + "' displaces several grounds by samples in memory",
                     "a case displaces one ground by an input", "give each ground its own input");
    if (std::ranges::find(structure_.by_velocity, input.name) != structure_.by_velocity.end())
      return d::BaseVelocity{{input.target, {}, {}}};
    return d::BaseDisplacement{{input.target, {}, {}}};
  }

  d::FileSignal file_of(const InputDescription& input, const Samples& samples) {
    const bool of_velocity = std::ranges::find(structure_.by_velocity, input.name) != structure_.by_velocity.end();
    Record record = make_record(samples.sample_rate, {{input.name, samples.values}}, samples.start);
    record.channels.front().unit = of_velocity ? "m/s" : unit_of(input.kind);
    return {.file = making_.add_file("." + input.name, record),
            .channel = {input.name, {}, {}},
            .sample_rate = samples.sample_rate,
            .unit = {},
            .align = {},
            .prepare = {}};
  }

  const StructureDescription& structure_;
  const CaseOrigin* origin_;
  CaseInMaking& making_;
  d::Case& given_;
};

}  // namespace

void describe_structure(const Structure& structure, CaseInMaking& making) {
  StructureSections(structure.description(), making).write();
}

}  // namespace kalfem
