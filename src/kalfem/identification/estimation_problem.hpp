#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/parameter_transform.hpp"
#include "kalfem/identification/parameter_set.hpp"
#include "kalfem/identification/point_prior.hpp"
#include "kalfem/system/sensors/measurement_chain.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

/// A sensor of the structure behind its measurement chain.
struct Sensor {
  std::string name;
  OutputDescription output;
  MeasurementChain chain = {};
  bool relative_noise = false;  ///< noise is a part of the channel's rms
  double noise = 0.0;           ///< standard deviation, in the sensor's unit or as that part
  std::string unit = {};
  SourceLocation location = {};  ///< where the user describes it, for messages

  /// Standard deviation of the noise on a channel of that rms.
  [[nodiscard]] double deviation(double channel_rms) const { return relative_noise ? noise * channel_rms : noise; }
};

/// A parameter that the filter estimates, in the parameter's unit.
struct Unknown {
  std::string name;
  std::vector<Parameter> targets;  ///< that share its value: of connectors and lumped elements, or of linear parts
  ParameterTransform transform = {};
  double initial = 0.0;      ///< prior mean (median under log and logit)
  double deviation = 0.0;    ///< prior standard deviation
  double random_walk = 0.0;  ///< drift that is allowed [unit/sqrt(s)]
  std::optional<double> truth = {};
  SourceLocation location = {};

  [[nodiscard]] const std::string& unit() const { return targets.front().unit; }
};

/// White acceleration [m/s^2/sqrt(Hz)] on every degree of freedom, and on single ones in its place.
struct AccelerationNoise {
  double acceleration = 0.0;
  Named<Located<double>> accelerations;
};

/// How a point between the modelled part and the rest moves: as a sensor's channel says, or as an unknown force pushes.
struct InterfaceAcceleration {
  Name sensor;
  double displacement_std = 0.0, velocity_std = 0.0;  ///< of the motion's start [m], [m/s]
};
struct InterfaceForce {
  double std = 0.0, correlation_time = 0.1;  ///< of a first-order Gauss-Markov process [N], [s]
};
struct Interface {
  std::variant<InterfaceAcceleration, InterfaceForce> motion;
};
/// A filter's model of a part of the structure only.
struct LocalModelOptions {
  std::vector<Name> substructures;  ///< that it holds
  Named<Located<Interface>> interface;
};

/// The rest position of a sensor, which its record does not show.
struct RestPosition {
  std::string sensor;
  double deviation = 0.0;  ///< prior standard deviation about the record's zero
};

/// What the filter is to estimate, and how.
struct EstimationSettings {
  std::optional<FilterKind> filter = {};  ///< none: chosen by what the system allows
  UnscentedOptions unscented = {};
  std::vector<Unknown> unknowns = {};
  Named<Located<PointPrior>> initial_state = {};  ///< by degree of freedom, "all" for those that are not named
  bool initial_state_from_record = false;         ///< displacements and velocities from the displacement sensors
  Named<Located<ConnectorStatePrior>> initial_connector_states = {};
  AccelerationNoise process_noise = {};
  std::optional<LocalModelOptions> local = {};
  double settle = 0.0;                  ///< time that errors and consistency leave out [s]
  bool estimate_initial_state = false;  ///< keep the start in the state and refine it with every sample
  int passes = 1;                       ///< over the record, each from the estimate of the one before
  int substeps = 4;                     ///< of a sample interval, for the connectors' forces
  int threads = 0;                      ///< 0: one a processor
};

/// A structure, what measures it, and what is to be estimated from its record. Immutable; models that are made from it
/// share it.
struct EstimationProblem {
  StructurePtr structure;
  std::vector<Sensor> sensors = {};
  std::vector<RestPosition> rest_positions = {};
  double sample_rate = 0.0;  ///< of the record [Hz]
  EstimationSettings settings = {};
};
using EstimationProblemPtr = std::shared_ptr<const EstimationProblem>;

}  // namespace kalfem
