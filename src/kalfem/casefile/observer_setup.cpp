#include "kalfem/casefile/observer_setup.hpp"

#include <algorithm>
#include <set>

#include "kalfem/casefile/unknown_targets.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
namespace d = description;

/// Prior standard deviation or walk: in the parameter's unit, or per cent of the initial value.
double absolute(const d::Value& given, const std::string& unit, double initial) {
  const bool percentage = !given.value.bare && given.value.dimension == Dimension{};

  return percentage ? given.value.value * std::abs(initial) : checked_number(given, unit, Bounds::nonnegative());
}

std::string unit_of(const Parts& parts, const std::string& name) {
  const auto reference = find_parameter(parts, name);
  return reference ? reference->unit : "-";
}

ParameterTransform transform_of(const d::Unknown& given, const std::string& unit) {
  ParameterTransform transform;
  transform.kind = given.transform.value_or(given.bounds ? TransformKind::logit : TransformKind::none);
  if (transform.kind == TransformKind::logit) {
    if (!given.bounds)
      throw InvalidInput(given.initial.issue("transform: logit without bounds", "it keeps the parameter between them",
                                             "give bounds: [lower, upper]"));
    transform.lower = to_si((*given.bounds)[0], unit);
    transform.upper = to_si((*given.bounds)[1], unit);
  }
  return transform;
}

/// Builds the unknowns and releases the linear elements among them from the observer's parts.
class UnknownBuilder {
public:
  /// `simulated`: the values of the case are the truth.
  UnknownBuilder(const Parts& truth, bool simulated, const PresentValues& present, Parts& parts, IssueList& issues)
      : truth_(truth), simulated_(simulated), present_(present), parts_(parts), issues_(issues) {}

  void add(const std::string& name, const d::Unknown& given, ObserverSetup& setup) {
    std::vector<d::Name> names = given.applies_to;
    if (names.empty()) names.push_back({name, given.initial.location, "estimate.unknown." + name});
    if (!all_known(names)) return;
    try {
      const std::string unit = unit_of(truth_, names.front().value);

      UnknownParameter unknown{name, unit, {}, transform_of(given, unit), checked_number(given.initial, unit),
                               0.0,  0.0};
      unknown.deviation = given.std ? absolute(*given.std, unit, unknown.initial) : 0.5 * std::abs(unknown.initial);
      unknown.random_walk = given.random_walk ? absolute(*given.random_walk, unit, unknown.initial) : 0.0;
      std::optional<double> truth;
      if (const auto value = present_.find(name); value != present_.end()) unknown.initial = value->second;
      for (const auto& target : names) {
        add_target(target, unknown);
        if (simulated_) truth = find_parameter(truth_, target.value)->value;
      }

      if (given.truth) truth = checked_number(*given.truth, unit);
      setup.options.unknowns.push_back(unknown);
      setup.true_parameters.push_back(truth);
    } catch (const InvalidInput& error) {
      issues_.add(error, given.initial.location);
    }
  }

private:
  bool all_known(const std::vector<d::Name>& names) {
    bool known = true;
    for (const auto& name : names) {
      if (find_parameter(parts_, name.value)) continue;
      known = false;
      issues_.add(name.location,
                  name.path + ": there is no parameter '" + name.value + "'" +
                      did_you_mean(name.value, parameter_names(truth_)),
                  "an unknown is a parameter of a connector or of a lumped substructure", "");
    }
    return known;
  }

  void add_target(const d::Name& name, UnknownParameter& unknown) {
    const auto reference = find_parameter(parts_, name.value);
    const auto target = release_linear_element(parts_, *reference, unknown.initial);
    unknown.targets.push_back({static_cast<Index>(target.part), static_cast<Index>(target.element)});
    parts_.connectors[target.part].parameters[static_cast<Index>(target.element)] = unknown.initial;
  }

  const Parts& truth_;
  bool simulated_;
  const PresentValues& present_;
  Parts& parts_;
  IssueList& issues_;
};

bool belongs(const std::string& point, const std::set<std::string>& substructures) {
  return substructures.contains(point.substr(0, point.find('.')));
}

/// Leaves only the local substructures, the connectors that touch them, and the interface in place of the rest.
class LocalCut {
public:
  LocalCut(const d::LocalObserver& local, Parts& parts, IssueList& issues)
      : local_(local), parts_(parts), issues_(issues) {
    for (const auto& name : local.substructures) kept_.insert(name.value);
  }

  void apply(ObserverSetup& setup) {
    check_names();
    std::erase_if(parts_.substructures, [&](const auto& part) { return !kept_.contains(part.name); });
    std::erase_if(parts_.finite_elements, [&](const auto& part) { return !kept_.contains(part.name); });
    std::erase_if(parts_.inputs, [&](const auto& input) {
      return input.kind != InputKind::base_acceleration && !belongs(input.target, kept_);
    });
    for (const auto& input : parts_.inputs) {
      setup.input_sources.push_back(input.name);
      setup.options.inputs.push_back({});
    }
    for (const auto& [point, interface] : local_.interface) add_interface(point, interface.value, setup);
    std::erase_if(parts_.connectors, [&](const auto& c) { return !reachable(c.from) || !reachable(c.to); });
  }

  /// Prior and noise of the interface inputs, once the number of inputs is known.
  void set_priors(ObserverSetup& setup) const {
    auto& prior = setup.options.prior;
    auto& noise = setup.options.process_noise.input;
    for (std::size_t i = 0; i < parts_.inputs.size(); ++i) {
      const auto index = static_cast<Index>(i);
      const auto found =
          std::ranges::find_if(local_.interface, [&](const auto& each) { return each.first == parts_.inputs[i].name; });
      if (found == local_.interface.end()) continue;
      if (const auto* measured = std::get_if<d::InterfaceAcceleration>(&found->second.value.motion)) {
        prior.input_deviation[index] = measured->displacement_std;
        prior.input_rate_deviation[index] = measured->velocity_std;
        noise[index] = 0.0;  // from the sensor's noise, once the record is known
      } else {
        const auto& force = std::get<d::InterfaceForce>(found->second.value.motion);
        prior.input_deviation[index] = force.std;
        noise[index] = force.std * std::sqrt(2.0 / force.correlation_time);
      }
    }
  }

private:
  void check_names() {
    std::vector<std::string> known;
    for (const auto& part : parts_.substructures) known.push_back(part.name);
    for (const auto& part : parts_.finite_elements) known.push_back(part.name);
    for (const auto& name : local_.substructures)
      if (std::ranges::find(known, name.value) == known.end())
        issues_.add(name.location,
                    name.path + ": there is no substructure '" + name.value + "'" + did_you_mean(name.value, known));
  }

  bool reachable(const std::string& point) const {
    return belongs(point, kept_) || std::ranges::find(moving_, point) != moving_.end();
  }

  void add_interface(const std::string& point, const d::Interface& interface, ObserverSetup& setup) {
    const bool inside = belongs(point, kept_);
    if (const auto* measured = std::get_if<d::InterfaceAcceleration>(&interface.motion)) {
      const auto dot = point.find('.');
      if (inside || dot == std::string::npos) {
        issues_.add(measured->sensor.location,
                    "estimate.local.interface." + point +
                        ": an interface that moves as measured "
                        "lies outside the local substructures",
                    "", "name a point of the part that is left out");
        return;
      }
      add_moving_point(point.substr(0, dot), point.substr(dot + 1));
      moving_.push_back(point);
      parts_.inputs.push_back({point, InputKind::base_displacement, point, {}});
      setup.input_sources.push_back("@" + measured->sensor.value);
      setup.options.inputs.push_back({InputModel::integrated, 1.0});
    } else {
      parts_.inputs.push_back({point, InputKind::force, point, {}});
      setup.input_sources.emplace_back("");
      setup.options.inputs.push_back(
          {InputModel::first_order_markov, std::get<d::InterfaceForce>(interface.motion).correlation_time});
    }
  }

  /// A substructure without degrees of freedom whose only point is a ground that moves.
  void add_moving_point(const std::string& substructure, const std::string& point) {
    for (auto& part : parts_.substructures)
      if (part.name == substructure) {
        part.grounds.push_back(point);
        return;
      }
    LumpedSubstructure frame;
    frame.name = substructure;
    frame.grounds = {point};
    parts_.substructures.push_back(frame);
  }

  const d::LocalObserver& local_;
  Parts& parts_;
  IssueList& issues_;
  std::set<std::string> kept_;
  std::vector<std::string> moving_;
};

/// Index of "connector.state" among all internal states, -1 where there is none.
Index connector_state_index(const LocallyNonlinearSystem& system, const std::string& name) {
  Index index = 0;
  for (const auto& connector : system.connectors)
    for (const auto& state : connector.law->states()) {
      if (connector.name + "." + state.name == name) return index;
      ++index;
    }
  return -1;
}

void set_state_prior(const d::Estimation& given, const CoupledModel& model, StatePrior& prior, IssueList& issues) {
  for (const auto& [point, start] : given.initial_state) {
    const auto apply = [&](Index i) {
      prior.mean.displacement[i] = start.value.displacement;
      prior.mean.velocity[i] = start.value.velocity;
      prior.displacement_deviation[i] = model.coordinate_scale()[i] * start.value.displacement_std;
      prior.velocity_deviation[i] = model.coordinate_scale()[i] * start.value.velocity_std;
    };
    if (point == "all") {
      for (Index i = 0; i < model.system().size(); ++i) apply(i);
    } else if (const Index index = model.dof_index(point); index >= 0) {
      apply(index);
    } else {
      issues.add(start.location, start.path + ": '" + point + "' is no degree of freedom of the observer" +
                                     did_you_mean(point, model.system().dofs));
    }
  }
  for (const auto& [name, start] : given.initial_connector_states) {
    const Index index = connector_state_index(model.system(), name);
    if (index < 0) {
      issues.add(start.location, start.path + ": there is no internal state '" + name + "'", "",
                 "write connector.state");
      continue;
    }
    prior.mean.connector_states[index] = start.value.value;
    prior.connector_state_deviation[index] = start.value.std;
  }
}

void set_noise(const d::Noise& given, const CoupledModel& model, ProcessNoise& noise, IssueList& issues) {
  noise.acceleration = given.acceleration * model.coordinate_scale();
  for (const auto& [point, density] : given.accelerations) {
    const Index index = model.dof_index(point);
    if (index < 0)
      issues.add(density.location, density.path + ": '" + point + "' is no degree of freedom of the observer" +
                                       did_you_mean(point, model.system().dofs));
    else
      noise.acceleration[index] = density.value;
  }
}

/// Sensors that the observer can see: on its own points, and not those that drive it.
std::vector<StudySensor> observer_sensors(const Study& study, const ObserverSetup& setup, IssueList& issues) {
  std::vector<StudySensor> sensors;
  for (const auto& sensor : study.sensors) {
    const bool drives = std::ranges::find(setup.input_sources, "@" + sensor.name) != setup.input_sources.end();
    if (drives) continue;
    try {
      make_outputs(*setup.model, {sensor.output});
      sensors.push_back(sensor);
    } catch (const InvalidInput& error) {
      if (!study.given.estimate->local) issues.add(error, {study.file, 0});
    }
  }
  if (sensors.empty())
    issues.add({study.file, 0}, "no sensor measures anything that the observer holds", "it would learn nothing",
               "place a sensor on the observer's part of the structure");
  return sensors;
}

void check_driving_sensors(const Study& study, const ObserverSetup& setup, IssueList& issues) {
  std::vector<std::string> names;
  for (const auto& sensor : study.sensors) names.push_back(sensor.name);
  for (const auto& source : setup.input_sources) {
    if (source.empty() || source.front() != '@') continue;
    const auto found = std::ranges::find(study.sensors, source.substr(1), &StudySensor::name);
    if (found == study.sensors.end())
      issues.add({study.file, 0}, "estimate.local.interface: there is no sensor '" + source.substr(1) + "'" +
                                      did_you_mean(source.substr(1), names));
    else if (found->output.quantity != ObservedQuantity::acceleration)
      issues.add({study.file, 0},
                 "estimate.local.interface: sensor '" + found->name + "' does not measure acceleration",
                 "the interface is driven by an acceleration");
  }
}

}  // namespace

PresentValues present_values(const UpdatingSetup& updating, const Eigen::VectorXd& values) {
  PresentValues present;
  for (std::size_t i = 0; i < updating.parameters.size(); ++i)
    present[updating.parameters[i].name] = values[static_cast<Index>(i)];
  for (const auto& [index, target] : updating.bindings) present[target.name] = values[index];
  return present;
}

ObserverSetup make_observer_setup(const Study& study, Parts parts, const PresentValues& present, IssueList& issues) {
  const auto& given = *study.given.estimate;
  ObserverSetup setup;
  UnknownBuilder unknowns(study.parts, study.given.simulate.has_value(), present, parts, issues);
  std::optional<LocalCut> cut;
  if (given.local) {
    cut.emplace(*given.local, parts, issues);
    cut->apply(setup);
  } else {
    for (const auto& input : parts.inputs) {
      setup.input_sources.push_back(input.name);
      setup.options.inputs.push_back({});
    }
  }
  for (const auto& [name, unknown] : given.unknown) unknowns.add(name, unknown, setup);
  issues.raise();

  setup.model = std::make_shared<const CoupledModel>(couple(parts));
  const auto& system = setup.model->system();
  auto& options = setup.options;
  const VectorXd dofs = VectorXd::Zero(system.size()), inputs = VectorXd::Zero(system.input_count()),
                 states = VectorXd::Zero(system.connector_states());
  options.prior = {at_rest(system.size(), system.connector_states()), dofs, dofs, states, inputs, inputs, 0.0};
  options.process_noise = {dofs, inputs, states};
  set_state_prior(given, *setup.model, options.prior, issues);
  set_noise(given.process_noise, *setup.model, options.process_noise, issues);
  if (cut) cut->set_priors(setup);
  options.keep_initial_state = given.estimate_initial_state;
  options.step = 1.0 / study.sample_rate();
  options.substeps = given.substeps;
  check_driving_sensors(study, setup, issues);
  setup.sensors = observer_sensors(study, setup, issues);
  return setup;
}

}  // namespace kalfem
