// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/structure.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "kalfem/api/finite_element_substructure.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/system/signals/integrated_velocity.hpp"
#include "kalfem/system/signals/sampled.hpp"

namespace kalfem {
namespace {

/// The spline through the samples; of a velocity its integral.
SignalPtr signal_of(const std::string& name, const Samples& samples, bool is_velocity = false) try {
  const auto signal = make_sampled(samples.values, {.sample_rate = samples.sample_rate, .start = samples.start});
  if (!is_velocity) return signal;
  return integrated_velocity(signal, {samples.start, samples.sample_rate, samples.values.size()});
} catch (const InvalidInput& error) {
  IssueList issues;
  for (const auto& issue : error.issues()) issues.add({}, "input '" + name + "': " + issue.what, issue.why, issue.fix);
  issues.raise();
  return nullptr;
}

/// Throws InvalidInput where there is an input of that name: samples are given to inputs by their names.
void add_input(StructureDescription& description, const InputDescription& input, SignalPtr signal) {
  if (std::ranges::find(description.parts.inputs, input.name, &InputDescription::name) !=
      description.parts.inputs.end())
    throw InvalidInput("there is an input '" + input.name + "' already", "samples are given to an input by its name",
                       "give every input a name of its own");
  description.parts.inputs.push_back(input);
  description.signals.push_back(std::move(signal));
}

bool is_by_velocity(const StructureDescription& description, const std::string& input) {
  return std::ranges::find(description.by_velocity, input) != description.by_velocity.end();
}

/// Names in `all` that belong to `owner`, without it.
std::vector<std::string> names_of(const std::string& owner, const std::vector<std::string>& all) {
  const std::string prefix = owner + ".";
  std::vector<std::string> names;
  for (const auto& name : all)
    if (name.starts_with(prefix)) names.push_back(name.substr(prefix.size()));
  return names;
}

/// Points at which connectors and forces act.
std::vector<std::string> touched_points(const StructureParts& parts) {
  std::vector<std::string> points;
  for (const auto& connector : parts.connectors) {
    points.push_back(connector.from);
    points.push_back(connector.to);
  }
  for (const auto& input : parts.inputs)
    if (input.kind == InputKind::force) points.push_back(input.target);
  return points;
}

/// Throws InvalidInput where the value is not finite, or belongs to finite elements that a case has assembled; whether
/// it is physical is seen where the structure is used.
void set_parameter(StructureDescription& description, const Parameter& parameter, double value) {
  if (!std::isfinite(value))
    throw InvalidInput("at '" + parameter.name + "': " + shortest(value), "it must be finite",
                       "give it in " + parameter.unit);
  for (const auto& each : description.read.finite_elements)
    if (each.part->name == parameter.owner)
      throw InvalidInput("at '" + parameter.name + "'",
                         "finite elements that were read with a case are assembled already",
                         "read the case with another value of its key");
  if (description.read.origin) description.read.set.emplace_back(parameter.name, value);
  if (set_parameter(description.parts, parameter, value)) return;
  for (auto& part : description.finite_elements)
    if (part.name() == parameter.owner) set_number(part, parameter.name.substr(parameter.owner.size() + 1), value);
}

}  // namespace

Samples channel(const Record& record, const std::string& name) {
  if (const Eigen::Index row = record.find(name); row >= 0)
    return {record.values.row(row).transpose(), record.sample_rate, record.start};
  std::vector<std::string> known;
  for (const auto& each : record.channels) known.push_back(each.name);
  throw InvalidInput("the record has no channel '" + name + "'" + did_you_mean(name, known), "", "name one of its own");
}

LumpedPart& LumpedPart::mass(const std::string& dof, double kilograms) {
  part_.masses.push_back({dof, kilograms});
  return *this;
}

LumpedPart& LumpedPart::spring(const std::string& name, const std::string& from, const std::string& to,
                               double stiffness, double damping) {
  part_.springs.push_back({name, from, to, stiffness, damping});
  return *this;
}

LumpedPart& LumpedPart::ground(const std::string& name) {
  part_.grounds.push_back(name);
  return *this;
}

LumpedPart& LumpedPart::modal_damping(std::vector<double> ratios) {
  part_.modal_damping = std::move(ratios);
  return *this;
}

LumpedPart& LumpedPart::rayleigh_damping(double alpha, double beta) {
  part_.rayleigh = {alpha, beta};
  return *this;
}

LumpedPart lumped(const std::string& name) { return LumpedPart(name); }
LumpedPart lumped(const std::string& name, LumpedMatrices matrices) { return LumpedPart(name, std::move(matrices)); }

LumpedPart chain(const std::string& name, int masses, double mass, double stiffness, double damping) {
  if (masses < 1)
    throw InvalidInput("chain '" + name + "' has " + std::to_string(masses) + " masses", "it needs at least one",
                       "give their number");
  LumpedPart part(name);
  for (int i = 1; i <= masses; ++i) {
    const std::string here = std::to_string(i), before = std::to_string(i - 1);
    part.mass(here, mass);
    if (i > 1) part.spring(before + "-" + here, before, here, stiffness, damping);
  }
  return part;
}

Structure::Structure() : description_(std::make_unique<StructureDescription>()) {}
Structure::Structure(const StructureDescription& description)
    : description_(std::make_unique<StructureDescription>(description)) {}
Structure::Structure(const Structure& other) : Structure(*other.description_) {}
Structure::Structure(Structure&& other) noexcept = default;
Structure& Structure::operator=(Structure other) noexcept {
  std::swap(description_, other.description_);
  return *this;
}
Structure::~Structure() = default;

Structure& Structure::add(const LumpedPart& part) {
  description_->parts.substructures.push_back(part.description());
  return *this;
}

Structure& Structure::add(const FiniteElements& part) {
  description_->finite_elements.push_back(part);
  return *this;
}

Structure& Structure::connect(const std::string& name, const std::string& from, const std::string& to, const Law& law) {
  if (!law.law) throw InvalidInput("connector '" + name + "' has no law", "", "make one by law()");
  description_->parts.connectors.push_back({name, from, to, law.law, law.values});
  return *this;
}

Structure& Structure::modal_damping(std::vector<double> ratios) {
  description_->parts.damping = {.ratios = std::move(ratios)};
  return *this;
}

Structure& Structure::base_displacement(const std::string& name, const std::string& ground, SignalPtr displacement) {
  add_input(*description_, {name, InputKind::base_displacement, ground}, std::move(displacement));
  return *this;
}

Structure& Structure::base_acceleration(const std::string& name, SignalPtr acceleration) {
  add_input(*description_, {name, InputKind::base_acceleration, ""}, std::move(acceleration));
  return *this;
}

Structure& Structure::force(const std::string& name, const std::string& point, SignalPtr force) {
  add_input(*description_, {name, InputKind::force, point}, std::move(force));
  return *this;
}

Structure& Structure::base_displacement(const std::string& name, const std::string& ground,
                                        const Samples& displacement) {
  base_displacement(name, ground, signal_of(name, displacement));
  description_->samples[name] = displacement;
  return *this;
}

Structure& Structure::base_velocity(const std::string& name, const std::string& ground, const Samples& velocity) {
  const SignalPtr displacement = signal_of(name, velocity, true);
  base_velocity(name, ground);
  description_->signals.back() = displacement;
  description_->samples[name] = velocity;
  return *this;
}

Structure& Structure::base_acceleration(const std::string& name, const Samples& acceleration) {
  base_acceleration(name, signal_of(name, acceleration));
  description_->samples[name] = acceleration;
  return *this;
}

Structure& Structure::force(const std::string& name, const std::string& point, const Samples& force) {
  this->force(name, point, signal_of(name, force));
  description_->samples[name] = force;
  return *this;
}

Structure& Structure::drive(const std::string& input, const Samples& samples) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < description_->parts.inputs.size(); ++i) {
    const std::string& name = description_->parts.inputs[i].name;
    known.push_back(name);
    if (name != input) continue;
    description_->signals[i] = signal_of(name, samples, is_by_velocity(*description_, name));
    description_->samples[name] = samples;
    return *this;
  }
  throw InvalidInput("there is no input '" + input + "'" + did_you_mean(input, known), "samples drive an input",
                     "add it by force(), base_displacement(), base_velocity() or base_acceleration()");
}

Structure& Structure::base_displacement(const std::string& name, const std::string& ground) {
  return base_displacement(name, ground, SignalPtr());
}

Structure& Structure::base_velocity(const std::string& name, const std::string& ground) {
  base_displacement(name, ground);
  description_->by_velocity.push_back(name);
  return *this;
}

Structure& Structure::base_acceleration(const std::string& name) { return base_acceleration(name, SignalPtr()); }

Structure& Structure::force(const std::string& name, const std::string& point) {
  return force(name, point, SignalPtr());
}

std::vector<std::string> Structure::parameters() const {
  return ParameterSet(*make_structure_model(*description_)).names();
}

double Structure::value(const std::string& parameter) const {
  const auto model = make_structure_model(*description_, {.parameters = {parameter}});
  return find_parameter(ParameterSet(*model), parameter, "value").value;
}

std::string Structure::unit(const std::string& parameter) const {
  const auto model = make_structure_model(*description_, {.parameters = {parameter}});
  return find_parameter(ParameterSet(*model), parameter, "unit").unit;
}

Structure Structure::at(const NamedValues& values) const {
  Structure moved = *this;
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.push_back(name);
  const ParameterSet all(*make_structure_model(*description_, {.parameters = names}));
  IssueList issues;
  for (const auto& [name, value] : values) try {
      set_parameter(*moved.description_, find_parameter(all, name, "at"), value);
    } catch (const InvalidInput& error) {
      issues.add(error, {});
    }
  issues.raise();
  return moved;
}

std::vector<std::string> Structure::points() const {
  const auto model = make_structure_model(*description_);
  StructureParts parts = model->parts;
  parts.finite_elements = model->reduced_parts();
  return couple(parts).point_names();
}

StructurePtr make_structure_model(const StructureDescription& description, const ModelUse& use) {
  auto model = std::make_shared<StructureModel>();
  model->parts = description.parts;
  const auto touched = touched_points(description.parts);
  for (const auto& given : description.finite_elements)
    model->finite_elements.push_back(make_substructure(given, {.attached = names_of(given.name(), touched),
                                                               .parameters = names_of(given.name(), use.parameters),
                                                               .sensor_bandwidth = use.sensor_bandwidth}));
  std::ranges::copy(description.read.finite_elements, std::back_inserter(model->finite_elements));
  model->parts.finite_elements = model->reduced_parts();
  model->signals = description.signals;
  couple(model->parts);  // throws if names or units do not fit
  return model;
}

void require_signals(const StructureDescription& description) {
  IssueList issues;
  for (std::size_t i = 0; i < description.signals.size(); ++i)
    if (!description.signals[i])
      issues.add({}, "input '" + description.parts.inputs[i].name + "' has no signal",
                 "only an OnlineFilter is told it sample by sample", "give its samples with their rate");
  issues.raise();
}

Parameter find_parameter(const ParameterSet& all, const std::string& name, const std::string& what) {
  if (auto parameter = all.find(name)) return *parameter;
  throw InvalidInput(what + " '" + name + "': there is no parameter of that name" + did_you_mean(name, all.names()),
                     "a parameter is a number of a connector or of a substructure", "");
}

}  // namespace kalfem
