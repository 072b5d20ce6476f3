// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/diagnosis/diagnosis.hpp"
#include "kalfem/estimation/filter_kind.hpp"
#include "kalfem/estimation/parameter_transform.hpp"
#include "kalfem/identification/held_out_sensor.hpp"
#include "kalfem/identification/known_to.hpp"
#include "kalfem/identification/point_prior.hpp"
#include "kalfem/identification/unknown_scores.hpp"
#include "kalfem/live/live_state.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The prior of an unknown parameter, in its SI unit.
struct Prior {
  std::optional<double> initial = {};  ///< mean (median with log and logit); if empty, the structure's own value
  double std = 0.0;                    ///< standard deviation; 0: half of |initial|
  double random_walk = 0.0;            ///< allowed drift [unit/sqrt(s)]
  /// If empty: log for stiffnesses and masses, which stay positive, and none for all others.
  std::optional<ParameterTransform> transform = {};
  std::vector<std::string> applies_to =
      {};  ///< parameters that share the value; if empty, the one that the unknown names
};

/// An unknown: {"suspension.mu_k1", {.initial = 10, .std = 5}}; a parameter of the structure, or a number of the
/// measurement: "sensors.a3.offset", a state of the filter, and "sensors.a3.gain", ".delay",
/// ".drift", ".noise" and "process_noise", which are found by maximum likelihood as one number for the record.
struct UnknownDescription {
  std::string name;
  Prior prior = {};
};

/// Noise that the filter finds along the record.
struct AdaptiveNoise {
  bool sensors = false;  ///< of each sensor, from the stated one on
  bool process = false;  ///< a factor on EstimateOptions::process_noise
  double memory = 2.0;   ///< [s] > 0: a sample of that age counts e times less than the present one
};

/// Settings of an estimation. Everything left out is zero: rest at the start, no process noise.
struct EstimateOptions {
  std::vector<SensorDescription> sensors;
  std::vector<UnknownDescription> unknowns = {};
  std::vector<OutputRequest> outputs = {};  ///< virtual sensors
  /// Prior of the initial motion, by degree of freedom; "all" for those without an entry.
  std::vector<std::pair<std::string, PointPrior>> initial_state = {};
  /// Prior of the internal states of connectors at the start, by "connector.state".
  std::vector<std::pair<std::string, ConnectorStatePrior>> initial_connector_states = {};
  double process_noise = 0.0;             ///< white acceleration on every degree of freedom [m/s^2/sqrt(Hz)]
  std::optional<FilterKind> filter = {};  ///< if empty, the structure decides
  /// Of a sample interval, for the connectors' forces. Empty: estimate() takes as many as the estimates need, which
  /// costs a second run over the record where two are not clearly enough; an OnlineFilter, which has no record, takes
  /// 4. EstimateResult::substeps of a recorded piece is the number for it.
  std::optional<int> substeps = {};
  /// Of the filter's step over each substep, 2 or 4. With 2 the connectors' forces are linear over it; with 4
  /// quadratic, at twice the cost and with an error that falls with the fourth power of the substeps where the laws are
  /// smooth.
  int step_order = 4;
  int threads = 0;  ///< 0: one per processor; results do not depend on it

  // Of a whole record; an OnlineFilter refuses them.
  bool initial_state_from_record = false;  ///< displacements and velocities from the displacement sensors
  bool estimate_initial_state = false;  ///< keep the initial state in the state vector and update it with every sample
  int passes = 1;  ///< over the record, each from the parameters of the last (and from its initial state, where kept)
  /// Time from which on innovations count in the verdict [s]. Empty: at once where the motion at the start is known,
  /// otherwise by the decay of the structure's slowest mode, at the latest after a tenth of the record.
  std::optional<double> settle = {};
  /// Samples from one computation of the standard deviations of states and outputs to the next; they stand in between.
  int deviation_stride = 1;
  Progress progress = {};
  /// Look for the mistake that explains numbers which contradict themselves. It costs about a hundred runs over a part
  /// of the record, and only where something is wrong. An OnlineFilter never looks.
  bool diagnose = true;
  /// Filter steps of all that follows the first answer (more substeps, other process noise, changes of parameters
  /// within the record, the diagnosis), in those of the first answer. 0: nothing follows; infinity: all. Empty:
  /// all, or nothing without `diagnose`.
  std::optional<double> second_thoughts = {};
  /// How well numbers are known that the structure holds fixed. Intervals and bands hold what follows from it.
  std::vector<KnownTo> known_to = {};
  /// Fixed numbers that the record asks to change: say nothing of estimating them, try them as unknowns and propose
  /// those that predict the last third of the record better, or take these as unknowns.
  FreeNumbers free = FreeNumbers::ask;
  AdaptiveNoise adaptive_noise = {};
};

/// A parameter, estimated at the end of the record.
struct ParameterEstimate {
  struct Interval {
    double lower = 0.0, upper = 0.0;
  };

  std::string name, unit;
  double mean = 0.0, std = 0.0;
  /// Holds where the model is not exact and innovations are correlated; with a right model it is about `std`. Not a
  /// number for a parameter with a random walk, after a stop, and from an OnlineFilter.
  double std_robust = std::numeric_limits<double>::quiet_NaN();
  Interval interval_95 = {};  ///< from the larger of both deviations, with std_considered
  /// One per sample; empty for what the likelihood of the whole record told.
  Eigen::VectorXd mean_history = {}, std_history = {};
  /// The deviation with what `known_to` adds; not a number where nothing is stated.
  double std_considered = std::numeric_limits<double>::quiet_NaN();
};

/// A number that the structure or a sensor holds fixed ("frame.3.mass", "a1.gain"), and what it does to the estimates.
/// Changes of it are counted in its `scale`.
struct FixedNumberEffect {
  std::string name, unit;
  std::string group;  ///< "masses" and so on, as KnownTo names them
  double value = 0.0;
  double scale = 1.0;      ///< |value|; of a delay 1 s, of a drift 1; of a number that is 0 its stated deviation
  double known_to = 0.0;   ///< stated standard deviation [scale]; 0: taken as exact
  double stands_at = 0.0;  ///< the change at which the estimates stand; 0 unless a stated number was moved
  double asked = 0.0;      ///< the change that makes the record most likely, the parameters estimated along
  double asked_std = 0.0;  ///< infinite where the record does not tell
  double log_likelihood_gain = 0.0;     ///< by that change
  std::vector<double> shift = {};       ///< of every parameter's estimate by a change of one scale [its unit]
  std::vector<double> considered = {};  ///< standard deviation that `known_to` adds to every parameter [its unit]
};

/// A number that was held fixed, tried as an unknown.
struct NumberTrial {
  std::string name, unit;         ///< of the unknown: "s.2.mass", "sensors.a3.gain"
  double held = 0.0;              ///< the value at which it was held fixed
  double prior_std = 0.0;         ///< of the unknown
  double value = 0.0, std = 0.0;  ///< found
  double predicted_gain = 0.0;    ///< rise of the log-likelihood of the last third of the record, from what is before
  bool kept = false;              ///< it predicts that third better by far
};

/// An estimate before and after numbers were freed.
struct EstimateMove {
  std::string parameter, unit;
  double before = 0.0, after = 0.0;
  double deviations = 0.0;  ///< of the move, in those of the interval before
};

/// A sensor's innovations after settling, each over the deviation that the filter expects of it: with the right model
/// and noise they are white and of size one.
struct NormalisedInnovations {
  std::string sensor;
  double rms = 0.0;
  double largest_part = 0.0;      ///< rms in the loudest twentieth of the record
  double correlation = 0.0;       ///< of successive ones
  double beyond_half_gate = 0.0;  ///< part of them with a square above 12.5, expected 0.0004
};

/// A quantity at every sample.
struct EstimatedQuantity {
  std::string name, unit;
  Eigen::VectorXd mean, std;
};

/// Result of a filter over a record. After a stop, the remaining samples are NaN.
struct EstimateResult {
  /// In the order of the unknowns: those of the structure, offsets of sensors, then what the likelihood told.
  std::vector<ParameterEstimate> parameters;
  std::vector<EstimatedQuantity> states;   ///< "body.2.displacement", "body.2.velocity", "mount.z"
  std::vector<EstimatedQuantity> outputs;  ///< in the order in which they were asked for
  Eigen::MatrixXd innovation;              ///< sensors x samples; not a number where nothing was measured
  Eigen::MatrixXd innovation_deviation;    ///< expected of it, sensors x samples
  /// Its covariance's lower triangle row by row, s (s + 1) / 2 x samples for s sensors; empty for more than 16.
  Eigen::MatrixXd innovation_covariance;
  /// Whether the filter learned from a sample as from any other: 0 where it is missing, an outlier or left out.
  Eigen::MatrixXi used;
  Eigen::VectorXd nis;  ///< normalised innovation squared, one a sample
  /// What every sample tells of each constant unknown; empty after a stop and for very long records.
  std::vector<UnknownScore> scores;
  double log_likelihood = 0.0;
  std::string filter;                 ///< its name, and the reason for its choice
  std::optional<FilterStop> failure;  ///< empty if the filter ran to the end
  int substeps = 0;                   ///< of a sample interval
  /// |bias| that the substeps leave in each parameter, in its standard deviations; empty: not measured, as they were
  /// given.
  Eigen::VectorXd substep_bias;
  std::string start;                           ///< what was assumed of the motion at the first sample, in words
  std::vector<NormalisedInnovations> sensors;  ///< in the order of the sensors
  /// Whether the numbers agree with each other and with what was stated about them. A filter that stopped is unusable.
  Verdict verdict;
  /// Searches for which EstimateOptions::second_thoughts left no filter steps, in words.
  std::vector<std::string> left_out = {};
  std::optional<Diagnosis> diagnosis;  ///< every mistake that was tested; empty: there was no reason to look for one
  /// Numbers that were held fixed, and how much they matter; empty: not looked at (no parameters, or `diagnose` off and
  /// nothing stated).
  std::vector<FixedNumberEffect> fixed_numbers = {};
  /// Numbers that were tried as unknowns, and what those that were kept move. With FreeNumbers::automatic the result is
  /// the one with them, and `parameters` hold them behind the given ones.
  std::vector<NumberTrial> number_trials = {};
  std::vector<EstimateMove> moved_by_freed = {};
  /// Each sensor predicted from all others, as a virtual one; empty: not tried (one sensor, `diagnose` off, innovations
  /// that contradict the model, or known_to).
  std::vector<HeldOutSensor> held_out_sensors = {};
  /// Where a band does not hold: adaptive process noise, tried to mend it.
  std::optional<AdaptedProcessTrial> adapted_process = {};

  /// Whether the filter ran to the end and nothing in its numbers makes them worthless.
  [[nodiscard]] bool usable() const { return verdict.state() != VerdictState::unusable; }
  /// Mean of the NIS from a time after the record's start [s]: about the number of sensors if model and noise are
  /// right.
  [[nodiscard]] double mean_nis(double settle = 0.0) const;
  /// Look-up by name; throw InvalidInput if there is none.
  [[nodiscard]] const ParameterEstimate& parameter(const std::string& name) const;
  [[nodiscard]] const EstimatedQuantity& state(const std::string& name) const;
  [[nodiscard]] const EstimatedQuantity& output(const std::string& name) const;

  double sample_rate = 0.0;  ///< [Hz]
  Eigen::Index settled = 0;  ///< first sample that the verdict rests on
};

/// Estimates states and unknown parameters of a structure from a record, whose channels have the sensors' names, in SI
/// units. Missing samples are not a number. Throws InvalidInput with every argument that is wrong, by its place:
/// "unknowns[0] 'suspension.mu_k9': there is no parameter of that name". What the numbers do is in the result. It is
/// what a case file of the same structure gives: filters that lose fewer digits are tried where one stops, finite
/// elements are reduced again at estimates that moved far, and the verdict follows the same rules.
EstimateResult estimate(const Structure& structure, const Record& record, const EstimateOptions& options);

}  // namespace kalfem
