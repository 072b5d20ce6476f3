// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/latent_process.hpp"
#include "kalfem/estimation/adaptive_noise.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/parameter_transform.hpp"
#include "kalfem/identification/known_to.hpp"
#include "kalfem/identification/parameter_set.hpp"
#include "kalfem/identification/point_prior.hpp"
#include "kalfem/identification/step_budget.hpp"
#include "kalfem/system/sensors/measurement_chain.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

/// A sensor of the structure behind its measurement chain.
struct Sensor {
  std::string name;
  OutputDescription output;
  MeasurementChain chain = {};
  bool relative_noise = false;  ///< noise is relative to the channel's rms
  double noise = 0.0;           ///< standard deviation, in the sensor's unit or relative
  std::string unit = {};
  SourceLocation location = {};  ///< where the user describes it, for messages

  /// Standard deviation of the noise on a channel of that rms.
  [[nodiscard]] double deviation(double channel_rms) const { return relative_noise ? noise * channel_rms : noise; }
};

/// A parameter that the filter estimates, in the parameter's unit.
struct Unknown {
  std::string name;
  std::vector<Parameter> targets;  ///< they share its value: of connectors and lumped elements, or of linear parts
  ParameterTransform transform = {};
  double initial = 0.0;      ///< prior mean (median under log and logit)
  double deviation = 0.0;    ///< prior standard deviation
  double random_walk = 0.0;  ///< allowed drift [unit/sqrt(s)]
  std::optional<double> truth = {};
  SourceLocation location = {};

  [[nodiscard]] const std::string& unit() const { return targets.front().unit; }
};

/// White acceleration [m/s^2/sqrt(Hz)] on every degree of freedom, with other values for single ones.
struct AccelerationNoise {
  double acceleration = 0.0;
  Named<Located<double>> accelerations;
};

/// Drive of a point between the modelled part and the rest: a measured acceleration, or an unknown force.
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

/// An excitation that was not measured: the filter's state holds it as a latent process.
struct UnknownInput {
  std::string name;           ///< of the excitation
  bool acceleration = false;  ///< the process is the acceleration of a ground, otherwise the input's value
  LatentProcess process = {};
  double deviation = 0.0;  ///< stationary standard deviation; of a random walk at its start [unit]
  double density = 0.0;    ///< of the white noise that drives it, see ProcessNoise::input
  std::string unit = {};   ///< of the process
  bool has_truth = false;  ///< the excitation's signal is known beside it, to compare with
  SourceLocation location = {};

  [[nodiscard]] bool is_random_walk() const { return process.rate() == 0.0; }
};

/// A constant, or slowly drifting, offset of a sensor that the filter estimates: a zero that is not known, or the rest
/// position, which a record that ends too early does not show.
struct SensorOffset {
  std::string name;  ///< of the unknown
  std::string sensor;
  double deviation = 0.0;  ///< prior standard deviation
  double initial = 0.0;
  double random_walk = 0.0;  ///< drift [unit/sqrt(s)]
  std::optional<double> truth = {};
};

/// The unknown "rest.SENSOR".
inline SensorOffset rest_position(const std::string& sensor, double deviation) {
  return {"rest." + sensor, sensor, deviation};
}

/// Whether the offset belongs to one record, whose sensor does not show its rest.
inline bool is_rest_position(const SensorOffset& offset) { return offset.name == "rest." + offset.sensor; }

enum class LikelihoodUnknownKind { sensor_delay, sensor_drift, sensor_gain, sensor_noise, process_noise };

/// An unknown of the measurement or of the noise, for which the filter has no state. It is found by maximum likelihood.
struct LikelihoodUnknown {
  std::string name;
  LikelihoodUnknownKind kind = LikelihoodUnknownKind::sensor_delay;
  std::vector<std::string> sensors = {};  ///< that share it; none for process noise
  std::string unit = {};
  double initial = 0.0;    ///< prior mean (median of gains and noise)
  double deviation = 0.0;  ///< prior standard deviation
  std::optional<double> truth = {};
  std::optional<double> since = {};  ///< of a clock, ClockLag::since; empty: the record's first sample

  [[nodiscard]] bool is_of_clock() const {
    return kind == LikelihoodUnknownKind::sensor_delay || kind == LikelihoodUnknownKind::sensor_drift;
  }
  [[nodiscard]] bool is_of(const std::string& sensor) const {
    return std::ranges::find(sensors, sensor) != sensors.end();
  }
};

/// Settings of the filter.
struct EstimationSettings {
  std::optional<FilterKind> filter = {};  ///< if empty, the system decides
  UnscentedOptions unscented = {};
  std::vector<Unknown> unknowns = {};
  std::vector<LikelihoodUnknown> likelihood_unknowns = {};
  std::optional<double> clocks_since = {};  ///< ClockLag::since of drifts; empty: the record's first sample
  std::vector<UnknownInput> unknown_inputs = {};
  Named<Located<PointPrior>> initial_state = {};  ///< by degree of freedom; "all" for those without an entry
  bool initial_state_from_record = false;         ///< displacements and velocities from the displacement sensors
  Named<Located<ConnectorStatePrior>> initial_connector_states = {};
  AccelerationNoise process_noise = {};
  AdaptiveNoiseOptions adaptive_noise = {};  ///< noise that the filter finds along the record
  std::optional<LocalModelOptions> local = {};
  std::optional<double> settle = {};    ///< time before errors and consistency count [s]; empty: see settling_time()
  bool estimate_initial_state = false;  ///< keep the initial state in the state vector and update it with every sample
  int passes = 1;                       ///< over the record, each from the estimate of the one before
  /// Of a sample interval, for the connectors' forces; empty: as many as the estimates need, see choose_substeps().
  std::optional<int> substeps = {};
  int step_order = 4;  ///< of the step over each, 2 or 4: AugmentedModelOptions::step_order
  int threads = 0;     ///< 0: one per processor
  /// What the updates do with outliers, and, unless they keep them, a search for dead, stuck and saturated sensors;
  /// nothing: robust where a run shows outliers, see run_screened_filter().
  std::optional<OutlierTreatment> outliers = {};
  bool diagnose = true;  ///< look for the mistake that explains a run which contradicts itself
  /// Filter steps of all that follows the first answer (more substeps, other process noise, changes of unknowns, the
  /// mistake behind a contradiction), in those of the first answer. 0: nothing follows; see RecordEstimate.
  double second_thoughts = StepBudget::unlimited;
  bool smooth = false;                  ///< estimate every sample from the whole record too
  std::vector<KnownTo> known_to = {};   ///< numbers that are held fixed, and not known exactly
  FreeNumbers free = FreeNumbers::ask;  ///< numbers that are held fixed where the record asks for others
};

/// A structure, its sensors, and the unknowns to estimate from its record. Immutable; models made from it share it.
struct EstimationProblem {
  StructurePtr structure;
  std::vector<Sensor> sensors = {};
  std::vector<SensorOffset> offsets = {};
  double sample_rate = 0.0;  ///< of the record [Hz]
  EstimationSettings settings = {};
};
using EstimationProblemPtr = std::shared_ptr<const EstimationProblem>;

}  // namespace kalfem
