#include "kalfem/casefile/description_form.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/fields.hpp"

namespace kalfem::description {

using namespace form;

namespace {

Form<double> deviation(const std::string& unit) { return number(unit, Bounds::nonnegative()); }

Form<Unknown> unknown() {
  return mapping(
      Fields<Unknown>()
          .required("initial", &Unknown::initial, value(), "first guess: mean of the prior")
          .optional("std", &Unknown::std, value(),
                    "standard deviation of the prior, in its unit or per cent of initial")
          .optional("transform", &Unknown::transform,
                    choice<TransformKind>({{"none", TransformKind::none, "as it is"},
                                           {"log", TransformKind::log, "positive"},
                                           {"logit", TransformKind::logit, "between bounds"}}),
                    "how it is carried in the state; default: logit with bounds, else none")
          .optional("bounds", &Unknown::bounds, tuple<2>(quantity()), "lower and upper bound")
          .optional("random_walk", &Unknown::random_walk, value(), "drift per square root of a second")
          .optional("truth", &Unknown::truth, value(), "true value where known; default: the simulated one")
          .optional("applies_to", &Unknown::applies_to, list(name()), "several parameters that share this value"));
}

Form<LocalModelOptions> local_model() {
  const auto acceleration =
      Fields<InterfaceAcceleration>()
          .required("sensor", &InterfaceAcceleration::sensor, name(), "sensor whose record drives the interface")
          .optional("displacement_std", &InterfaceAcceleration::displacement_std, deviation("m"), "of its start")
          .optional("velocity_std", &InterfaceAcceleration::velocity_std, deviation("m/s"), "of its start");
  const auto force = Fields<InterfaceForce>()
                         .required("std", &InterfaceForce::std, deviation("N"), "stationary standard deviation")
                         .optional("correlation_time", &InterfaceForce::correlation_time,
                                   number("s", plausible::duration()), "of the first-order Markov process");
  const auto interface = Fields<Interface>().one_of(
      &Interface::motion, when("acceleration", mapping(acceleration), "a measured acceleration moves the point"),
      when("force", mapping(force), "an unknown force acts at the point in place of what is cut off"));
  return mapping(Fields<LocalModelOptions>()
                     .required("substructures", &LocalModelOptions::substructures, one_or_list(name()),
                               "what the filter's model holds")
                     .required("interface", &LocalModelOptions::interface,
                               named(located(mapping(interface)), NameRule::dotted),
                               "points where the rest of the structure was"));
}

}  // namespace

Form<Estimation> estimation() {
  const auto prior =
      Fields<PointPrior>()
          .optional("displacement", &PointPrior::displacement, number("m", plausible::position()), "mean")
          .optional("velocity", &PointPrior::velocity, number("m/s"), "mean")
          .optional("displacement_std", &PointPrior::displacement_std, deviation("m"), "deviation")
          .optional("velocity_std", &PointPrior::velocity_std, deviation("m/s"), "deviation");
  const auto connector_state =
      Fields<ConnectorStatePrior>()
          .optional("value", &ConnectorStatePrior::value, number("-"), "mean, in the state's SI unit")
          .optional("std", &ConnectorStatePrior::std, deviation("-"), "deviation, in the state's SI unit");
  const auto noise = Fields<AccelerationNoise>()
                         .optional("acceleration", &AccelerationNoise::acceleration, deviation("m/s^2/sqrt(Hz)"),
                                   "white acceleration on every degree of freedom")
                         .optional("accelerations", &AccelerationNoise::accelerations,
                                   named(located(deviation("m/s^2/sqrt(Hz)")), NameRule::dotted), "on single ones");
  const auto unscented =
      Fields<UnscentedOptions>()
          .optional("alpha", &UnscentedOptions::alpha, number("-", Bounds::positive()), "spread")
          .optional("beta", &UnscentedOptions::beta, number("-"), "2 for a normal distribution")
          .optional("kappa", &UnscentedOptions::kappa, number("-"),
                    "second spread; default: 0, of partially linear filters 3 less the number of channels");
  return mapping(
      Fields<Estimation>()
          .optional("filter", &Estimation::filter,
                    choice<std::optional<FilterKind>>(
                        {{"auto", std::nullopt,
                          "partially_linear_ukf, its covariance in blocks where these can be separated"},
                         {"partially_linear_ukf", FilterKind::partially_linear,
                          "unscented Kalman filter with sigma points of connectors and unknowns only"},
                         {"partially_linear_ukf_square_root", FilterKind::partially_linear_square_root,
                          "the same in square-root form"},
                         {"ukf", FilterKind::unscented, "unscented Kalman filter with sigma points of all states"},
                         {"ukf_square_root", FilterKind::unscented_square_root, "the same in square-root form"},
                         {"ekf", FilterKind::extended, "first-order linearisation"}}),
                    "the estimator")
          .inlined(&Estimation::unscented, unscented)
          .optional("unknown", &Estimation::unknown, named(unknown(), NameRule::dotted),
                    "unknown parameters: connector.parameter, substructure.spring.stiffness, ....damping, "
                    "substructure.mass.mass, any number of a linear substructure that `update` could refine, or a name "
                    "with applies_to")
          .optional("initial_state", &Estimation::initial_state, named(located(mapping(prior)), NameRule::dotted),
                    "degrees of freedom that do not surely start at rest at zero; `all` for every one")
          .optional("initial_state_from_record", &Estimation::initial_state_from_record, boolean(),
                    "means of displacements and velocities from the displacement sensors around the first sample")
          .optional("initial_connector_states", &Estimation::initial_connector_states,
                    named(located(mapping(connector_state)), NameRule::dotted), "internal states, connector.state")
          .optional("process_noise", &Estimation::process_noise, mapping(noise), "what the model leaves out")
          .optional("settle", &Estimation::settle, number("s", plausible::time()),
                    "errors and NIS are summed up from here on")
          .optional("local", &Estimation::local, local_model(),
                    "hold only a part of the structure in the filter's model")
          .optional("estimate_initial_state", &Estimation::estimate_initial_state, boolean(),
                    "carry the initial state as constants: a fixed-point smoother")
          .optional("substeps", &Estimation::substeps, integer(1, 64),
                    "parts of a sample interval over which connector forces and inputs are taken as linear")
          .optional("passes", &Estimation::passes, integer(1, 100), "runs over the record")
          .optional(
              "threads", &Estimation::threads, integer(0, 64),
              "that share the filter's work on large covariances, 0 for one a processor; results do not depend on it"));
}

}  // namespace kalfem::description
