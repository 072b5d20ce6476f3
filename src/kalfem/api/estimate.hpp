#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/estimation/filter_kind.hpp"
#include "kalfem/estimation/parameter_transform.hpp"
#include "kalfem/identification/point_prior.hpp"

namespace kalfem {

/// What is known of an unknown parameter before the record, in its SI unit.
struct Prior {
  std::optional<double> initial = {};  ///< mean (median under log and logit); nothing: the structure's own value
  double std = 0.0;                    ///< standard deviation; 0: half of |initial|
  double random_walk = 0.0;            ///< drift that is allowed [unit/sqrt(s)]
  /// Nothing: log for stiffnesses and masses, which stay positive, none for all else.
  std::optional<ParameterTransform> transform = {};
  std::vector<std::string> applies_to = {};  ///< parameters that share the value; none: the one that the unknown names
};

/// An unknown: {"suspension.mu_k1", {.initial = 10, .std = 5}}.
struct UnknownDescription {
  std::string name;
  Prior prior = {};
};

/// What a filter is to estimate, and from what. All that is left out is zero: rest at the start, no process noise.
struct EstimateOptions {
  std::vector<SensorDescription> sensors;
  std::vector<UnknownDescription> unknowns = {};
  std::vector<OutputRequest> outputs = {};  ///< virtual sensors
  /// Start of degrees of freedom, by name; "all" for those that are not named.
  std::vector<std::pair<std::string, PointPrior>> initial_state = {};
  double process_noise = 0.0;             ///< white acceleration on every degree of freedom [m/s^2/sqrt(Hz)]
  std::optional<FilterKind> filter = {};  ///< nothing: what suits the structure
  int substeps = 4;                       ///< of a sample interval, for the connectors' forces
  int threads = 0;                        ///< 0: one a processor; results do not depend on it

  // Of a whole record; an OnlineFilter refuses them.
  bool initial_state_from_record = false;  ///< displacements and velocities from the displacement sensors
  bool estimate_initial_state = false;     ///< keep the start in the state and refine it with every sample
  int passes = 1;                          ///< over the record; more than one needs estimate_initial_state
  Progress progress = {};
};

/// A parameter as it is estimated at the record's end.
struct ParameterEstimate {
  std::string name, unit;
  double mean = 0.0, std = 0.0;
  Eigen::VectorXd mean_history = {}, std_history = {};  ///< one a sample
};

/// A quantity at every sample.
struct EstimatedQuantity {
  std::string name, unit;
  Eigen::VectorXd mean, std;
};

/// Why and when a filter stopped.
struct FilterStop {
  double time = 0.0;   ///< [s]
  std::string reason;  ///< in words
};

/// What a filter makes of a record. After a stop the samples from there on are not a number.
struct EstimateResult {
  std::vector<ParameterEstimate> parameters;  ///< in the order of the unknowns
  std::vector<EstimatedQuantity> states;      ///< "body.2.displacement", "body.2.velocity", "mount.z"
  std::vector<EstimatedQuantity> outputs;     ///< in the order in which they were asked for
  Eigen::MatrixXd innovation;                 ///< sensors x samples; not a number where nothing was measured
  Eigen::VectorXd nis;                        ///< normalised innovation squared, one a sample
  double log_likelihood = 0.0;
  std::string filter;                 ///< which one, and why
  std::optional<FilterStop> failure;  ///< nothing: it ran to the end

  [[nodiscard]] bool usable() const { return !failure; }
  /// Mean of the NIS from a time after the record's start [s]: about the number of sensors where model and noise are
  /// right.
  [[nodiscard]] double mean_nis(double settle = 0.0) const;
  /// By name; throw InvalidInput where there is none.
  [[nodiscard]] const ParameterEstimate& parameter(const std::string& name) const;
  [[nodiscard]] const EstimatedQuantity& state(const std::string& name) const;
  [[nodiscard]] const EstimatedQuantity& output(const std::string& name) const;

  double sample_rate = 0.0;  ///< [Hz]
};

/// Estimates states and unknown parameters of a structure from a record, whose channels have the sensors' names, in SI
/// units. Missing samples are not a number. Throws InvalidInput with every argument that is wrong, by its place:
/// "unknowns[0] 'suspension.mu_k9': there is no parameter of that name". What the numbers do is in the result.
EstimateResult estimate(const Structure& structure, const Record& record, const EstimateOptions& options);

}  // namespace kalfem
