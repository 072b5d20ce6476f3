// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<double> deviation(const std::string& unit) { return number(unit, Bounds::nonnegative()); }

Schema<Unknown> unknown() {
  return mapping(
      Fields<Unknown>()
          .required("initial", &Unknown::initial, value(), "initial value: mean of the prior")
          .optional("std", &Unknown::std, value(),
                    "standard deviation of the prior, in the parameter's unit or in per cent of `initial`")
          .optional(
              "transform", &Unknown::transform,
              choice<TransformKind>({{"none", TransformKind::none, "no transform"},
                                     {"log", TransformKind::log, "positive"},
                                     {"logit", TransformKind::logit, "between bounds"}}),
              "transform of the parameter in the filter's state; default: logit if `bounds` is given, otherwise none")
          .optional("bounds", &Unknown::bounds, tuple<2>(quantity()), "lower and upper bound")
          .optional("random_walk", &Unknown::random_walk, value(),
                    "random walk: standard deviation per square root of a second, \"20 N\" or \"20 N/sqrt(s)\"")
          .optional("truth", &Unknown::truth, value(), "true value, if known; default: the simulated one")
          .optional("applies_to", &Unknown::applies_to, list(name()), "several parameters that share this value"));
}

/// `auto`, or a whole number.
Schema<std::optional<int>> substeps() {
  const auto number = integer(1, 128);
  const auto word = one_of_words({"auto"}, {"as many as the estimates need"});
  const auto read = [=](const CaseNode& node, std::optional<int>& value) {
    value.reset();
    std::size_t chosen = 0;
    if (node.yaml().kind == YamlNode::Kind::scalar && node.yaml().text == "auto") return word.read(node, chosen);
    return number.read(node, value.emplace());
  };
  const auto write = [=](const std::optional<int>& value) { return value ? number.write(*value) : word.write(0); };
  return make_schema<std::optional<int>>(read, write, either_schema(word.json_schema(), number.json_schema()));
}

/// `none`, `full` or a number.
Schema<double> second_thoughts() {
  const auto factor = number("-", Bounds::nonnegative());
  const auto word = one_of_words({"none", "full"}, {"the first answer stays as it is", "whatever they take"});
  const auto read = [=](const CaseNode& node, double& value) {
    const auto& yaml = node.yaml();
    if (yaml.kind != YamlNode::Kind::scalar || (yaml.text != "none" && yaml.text != "full"))
      return factor.read(node, value);
    std::size_t chosen = 0;
    const bool known = word.read(node, chosen);
    value = chosen == 0 ? 0.0 : std::numeric_limits<double>::infinity();
    return known;
  };
  const auto write = [=](const double& value) {
    if (std::isfinite(value) && value > 0.0) return factor.write(value);
    return word.write(value > 0.0 ? 1 : 0);
  };
  return make_schema<double>(read, write, either_schema(word.json_schema(), factor.json_schema()));
}

Schema<LocalModelOptions> local_model() {
  const auto acceleration = Fields<InterfaceAcceleration>()
                                .required("sensor", &InterfaceAcceleration::sensor, name(),
                                          "acceleration sensor whose record drives the interface")
                                .optional("displacement_std", &InterfaceAcceleration::displacement_std, deviation("m"),
                                          "prior standard deviation of its initial displacement")
                                .optional("velocity_std", &InterfaceAcceleration::velocity_std, deviation("m/s"),
                                          "prior standard deviation of its initial velocity");
  const auto force =
      Fields<InterfaceForce>()
          .required("std", &InterfaceForce::std, deviation("N"), "stationary standard deviation")
          .optional("correlation_time", &InterfaceForce::correlation_time, number("s", plausible::duration()),
                    "correlation time of the first-order Markov process");
  const auto interface = Fields<Interface>().one_of(
      &Interface::motion, when("acceleration", mapping(acceleration), "a measured acceleration moves the point"),
      when("force", mapping(force), "an unknown force at the point replaces the part that is left out"));
  return mapping(Fields<LocalModelOptions>()
                     .required("substructures", &LocalModelOptions::substructures, one_or_list(name()),
                               "substructures that the filter's model contains")
                     .required("interface", &LocalModelOptions::interface,
                               named(located(mapping(interface)), NameRule::dotted),
                               "interface points to the rest of the structure"));
}

}  // namespace

Schema<Estimation> estimation() {
  const auto prior =
      Fields<PointPrior>()
          .optional("displacement", &PointPrior::displacement, number("m", plausible::position()), "mean displacement")
          .optional("velocity", &PointPrior::velocity, number("m/s"), "mean velocity")
          .optional("displacement_std", &PointPrior::displacement_std, deviation("m"),
                    "standard deviation of the displacement")
          .optional("velocity_std", &PointPrior::velocity_std, deviation("m/s"), "standard deviation of the velocity");
  const auto connector_state =
      Fields<ConnectorStatePrior>()
          .optional("value", &ConnectorStatePrior::value, number("-"), "mean, in the SI unit of the state")
          .optional("std", &ConnectorStatePrior::std, deviation("-"),
                    "standard deviation, in the SI unit of the state");
  const auto noise = Fields<AccelerationNoise>()
                         .optional("acceleration", &AccelerationNoise::acceleration, deviation("m/s^2/sqrt(Hz)"),
                                   "density of white acceleration noise on every degree of freedom; two-sided: a "
                                   "velocity's variance grows by its square each second")
                         .optional("accelerations", &AccelerationNoise::accelerations,
                                   named(located(deviation("m/s^2/sqrt(Hz)")), NameRule::dotted),
                                   "the same for single degrees of freedom");
  const auto unscented =
      Fields<UnscentedOptions>()
          .optional("alpha", &UnscentedOptions::alpha, number("-", Bounds::positive()), "spread")
          .optional("beta", &UnscentedOptions::beta, number("-"),
                    "sigma-point parameter; 2 is best for a normal distribution")
          .optional("kappa", &UnscentedOptions::kappa, number("-"),
                    "sigma-point parameter; default: 0, or 3 minus the number of nonlinear "
                    "arguments for partially linear filters")
          .optional("update_iterations", &UnscentedOptions::update_iterations, integer(1, 50),
                    "most passes of each update; from the second on the sensors are linearised about "
                    "the posterior of the pass before");
  const auto adaptive = Fields<AdaptiveNoiseOptions>()
                            .optional("sensors", &AdaptiveNoiseOptions::sensors, boolean(),
                                      "the noise of each sensor, from the stated one on")
                            .optional("process", &AdaptiveNoiseOptions::process, boolean(),
                                      "one factor on the densities of process_noise")
                            .optional("memory", &AdaptiveNoiseOptions::memory, number("s", plausible::duration()),
                                      "time after which a sample counts e times less");
  return mapping(
      Fields<Estimation>()
          .optional("filter", &Estimation::filter,
                    choice<std::optional<FilterKind>>(
                        {{"auto", std::nullopt, "partially_linear_ukf, in modal coordinates if these can be separated"},
                         {"partially_linear_ukf", FilterKind::partially_linear,
                          "unscented Kalman filter with sigma points for connectors and unknowns only"},
                         {"partially_linear_ukf_square_root", FilterKind::partially_linear_square_root,
                          "the same in square-root form"},
                         {"ukf", FilterKind::unscented, "unscented Kalman filter with sigma points for all states"},
                         {"ukf_square_root", FilterKind::unscented_square_root, "the same in square-root form"},
                         {"ekf", FilterKind::extended, "first-order linearisation"}}),
                    "the estimator")
          .inlined(&Estimation::unscented, unscented)
          .optional(
              "unknown", &Estimation::unknown, named(unknown(), NameRule::dotted),
              "unknown parameters: connector.parameter, substructure.spring.stiffness, ....damping, "
              "substructure.mass.mass, any other parameter of a linear substructure that `update` accepts, or a "
              "name of your own with applies_to; of the measurement: sensors.NAME.offset, which may drift, and "
              "sensors.NAME.gain, .delay, .drift or .noise and process_noise, which are found by maximum likelihood; "
              "with applies_to several sensors share a gain, delay or drift")
          .optional("initial_state", &Estimation::initial_state, named(located(mapping(prior)), NameRule::dotted),
                    "prior of degrees of freedom that may not start at rest at zero; `all` for every one")
          .optional("initial_state_from_record", &Estimation::initial_state_from_record, boolean(),
                    "take initial displacements and velocities from the displacement sensors around the first sample")
          .optional("initial_connector_states", &Estimation::initial_connector_states,
                    named(located(mapping(connector_state)), NameRule::dotted),
                    "prior of internal states, connector.state")
          .optional("process_noise", &Estimation::process_noise, mapping(noise),
                    "process noise: what the model leaves out")
          .optional("adaptive_noise", &Estimation::adaptive_noise, mapping(adaptive),
                    "noise that the filter finds along the record from its innovations")
          .optional("settle", &Estimation::settle, number("s", plausible::time()),
                    "exclude the time before this from errors and NIS")
          .optional("local", &Estimation::local, local_model(),
                    "estimate with a local model: only a part of the structure")
          .optional("estimate_initial_state", &Estimation::estimate_initial_state, boolean(),
                    "also estimate the initial state (fixed-point smoother)")
          .optional(
              "substeps", &Estimation::substeps, substeps(),
              "number of parts of a sample interval within which connector forces and inputs are polynomials; auto: "
              "from 2 on, doubled until their bias is below 0.2 standard deviations of every unknown")
          .optional(
              "step_order", &Estimation::step_order, located(integer(2, 4)),
              "order of the step over each of these parts, 4 or 2; with 4, the default, connector forces and inputs "
              "vary quadratically, with 2 linearly at half the cost; substeps: auto then starts at 4 parts")
          .optional("passes", &Estimation::passes, integer(1, 100),
                    "number of runs over the record, each from the parameters of the last, and from its initial "
                    "state with estimate_initial_state")
          .optional("threads", &Estimation::threads, integer(0, 64),
                    "number of threads for large covariances, 0 for one per processor; results do not depend on it")
          .optional(
              "outliers", &Estimation::outliers,
              choice<std::optional<OutlierTreatment>>(
                  {{"auto", std::nullopt, "robust where a run over the record shows outliers, otherwise keep"},
                   {"gate", OutlierTreatment::gate, "leave samples beyond 6 expected deviations out"},
                   {"robust", OutlierTreatment::robust, "the further from its prediction, the less a sample counts"},
                   {"keep", OutlierTreatment::keep,
                    "every sample counts in full, and dead, stuck or saturated sensors are not searched for"}}),
              "what the filter does with samples far from their prediction; except with keep, it leaves dead, stuck "
              "and saturated sensors out")
          .optional("diagnose", &Estimation::diagnose, boolean(),
                    "repeat the run with other process noise; where the results contradict themselves, with changes of "
                    "single "
                    "unknowns within the record, and with single mistakes undone, to name the one that explains it")
          .optional("second_thoughts", &Estimation::second_thoughts, second_thoughts(),
                    "what may follow the first answer (more substeps, changes of unknowns within the record, other "
                    "process noise, the mistake behind a contradiction, predictions of a validation one sample ahead): "
                    "so many times its filter steps, none, or full")
          .optional("smooth", &Estimation::smooth, boolean(),
                    "also estimate every sample from the whole record (fixed-interval smoother)")
          .optional("known_to", &Estimation::known_to, named(value(), NameRule::dotted),
                    "standard deviations of numbers that are held fixed, which intervals and bands then hold: a "
                    "percentage, or in the number's unit. By group (masses, stiffnesses, damping, positions, laws, "
                    "gains, excitations, delays, drifts) or by name (frame.3.mass, a1.gain, a1.delay, road.gain, or "
                    "frame for all of it); the longest name counts")
          .optional("free", &Estimation::free,
                    choice<FreeNumbers>(
                        {{"none", FreeNumbers::none, "nothing is said of estimating them"},
                         {"ask", FreeNumbers::ask,
                          "they are tried as unknowns, and case.proposed.yaml has one that predicts the last third of "
                          "the record better"},
                         {"auto", FreeNumbers::automatic, "such numbers become unknowns of the run"}}),
                    "what to do with fixed numbers where the record asks for others")
          .optional("alternatives", &Estimation::alternatives, located(law_comparison()),
                    "other laws that a connector may follow: each is estimated too, and virtual sensors are the "
                    "mixture of all, by the evidence of each law"));
}

}  // namespace kalfem::description
