// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/identification/known_to.hpp"
#include "kalfem/records/mode_set.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A natural frequency that was measured.
struct MeasuredFrequency {
  double frequency = 0.0;        ///< [Hz]
  double std = 0.0;              ///< its standard deviation [Hz]
  std::optional<int> mode = {};  ///< number of the model's mode at the initial values, from 1; if empty, by order
};

/// A parameter to refine: {"frame.steel.youngs_modulus", {.initial = 200e9}}.
struct RefinedParameter {
  std::string name;
  struct Range {
    std::optional<double> initial = {};  ///< if empty, the structure's own value
    std::optional<double> std = {};      ///< of the prior about `initial`; if empty, there is no prior
    double lower = 0.0;
    double upper = std::numeric_limits<double>::infinity();
  } range = {};
};

/// Natural frequencies of a substructure without connectors, and mode shapes and dampings where they were measured.
struct MeasuredModes {
  std::string substructure;
  std::vector<MeasuredFrequency> frequencies;
  double above = 0.0;                     ///< modes up to this frequency are not elastic ones [Hz]
  std::vector<std::string> points = {};   ///< of the shapes: "frame.tip.z"
  std::vector<std::string> sensors = {};  ///< their names, one a point; empty: those of the points
  Eigen::MatrixXd shapes = {};      ///< points x frequencies, each in any scale and sign; not a number: not measured;
                                    ///< empty: none
  double shape_std = 0.05;          ///< of a shape's entries, relative to its largest
  Eigen::MatrixXd shape_stds = {};  ///< of each entry, in the shapes' unit, instead; empty: none
  std::vector<Eigen::MatrixXd> shape_covariances = {};  ///< one a frequency, points x points, instead; empty: none
  std::vector<double> dampings = {};                    ///< ratios to critical, one a frequency; empty: not compared
  std::vector<double> damping_stds = {};                ///< their standard deviations
};

/// Modes of a file (read_modes()) or of a record (mode_set()) as a comparison with the errors that are known of them.
/// `points`: points of the substructure, "frame.tip.z", each with the set's name of it; none: frequencies alone.
/// Throws InvalidInput with every point that was not measured and every shape that is too complex.
MeasuredModes measured_modes(const ModeSet& set, const std::string& substructure,
                             const std::vector<std::pair<std::string, std::string>>& points,
                             const ModeSetOptions& options = {});

/// Frequency responses of a substructure without connectors to a force at a point, motions exp(+i 2 pi f t).
struct MeasuredResponses {
  std::string input;                       ///< point of the force: "frame.tip.z"
  std::vector<OutputDescription> outputs;  ///< motions of points of the same substructure
  Eigen::VectorXd frequencies;             ///< [Hz], ascending
  Eigen::MatrixXcd values;                 ///< per newton, lines x outputs
  Eigen::MatrixXd std = {};                ///< of real and of imaginary part; empty: `relative_std` alone
  double relative_std = 0.05;              ///< of |H|, for calibration and for what the model cannot do
  /// Largest half width [Hz] to which resonances are widened at first, for a start that is far off: the search follows
  /// with smaller ones and ends without. See FrfResidual.
  double smoothing = 0.0;
};

/// Displacements of a substructure without connectors under static forces.
struct MeasuredDeflections {
  std::vector<std::pair<std::string, double>> forces;         ///< {"frame.tip.z", 100} [N]
  std::vector<std::pair<std::string, double>> displacements;  ///< [m]
  double std = 0.0;                                           ///< of each displacement [m]
};

/// A record of some sensors against the simulation of the whole structure from rest under its inputs.
struct MeasuredRecord {
  Record record;                           ///< with a channel of the name of each sensor
  std::vector<SensorDescription> sensors;  ///< with their noise
  double settle = 0.0;                     ///< time at the start that does not count [s]
  int substeps = 4;                        ///< of a sample interval, for the connectors' forces
};

/// A measurement that the structure shall agree with.
struct UpdateComparison {
  std::string name;
  std::variant<MeasuredModes, MeasuredResponses, MeasuredDeflections, MeasuredRecord> what;
  double weight = 1.0;  ///< factor of its sum of squares
};

struct UpdateOptions {
  std::string substructure = {};  ///< whose modes were measured
  std::vector<MeasuredFrequency> frequencies = {};
  std::vector<RefinedParameter> parameters;
  double above = 0.0;                              ///< modes up to this frequency are not elastic ones [Hz]
  std::vector<UpdateComparison> comparisons = {};  ///< further ones, or instead of `frequencies`
  int max_evaluations = 100;
  /// How well numbers are known that are not refined: of the structure; gains of what is compared: "tip.z.gain" of a
  /// response, "input.tip.z.gain" of its force, "a1.gain" of a record's sensor, "road.gain" of its excitation.
  /// Intervals hold what follows from it, and the fit is judged with the numbers as the data ask for within it.
  std::vector<KnownTo> known_to = {};
  double tolerance = 1e-6;  ///< the search ends once a step changes every parameter by less than this, relative
};

/// A measured frequency beside the model's.
struct FrequencyComparison {
  double measured = 0.0, before = 0.0, after = 0.0;  ///< [Hz]
};

/// How a comparison fits before and after.
struct ComparisonFit {
  std::string name;
  Eigen::Index size = 0;                     ///< values that are compared
  double rms_before = 0.0, rms_after = 0.0;  ///< of (model - measured) / std: about 1 where model and std are right
};

/// A number that an updating holds fixed and of which something is stated.
struct StatedNumber {
  std::string name, unit;
  std::string group;  ///< "masses" and so on, as KnownTo names them
  double value = 0.0;
  double known_to = 0.0;                ///< stated standard deviation [unit]
  double allowed = 0.0;                 ///< the change within it that the data ask for, with all others [unit]
  std::vector<double> shift = {};       ///< d(value)/d(number) of every parameter
  std::vector<double> considered = {};  ///< standard deviation that it adds to every parameter [its unit]
};

/// Result of an updating.
struct UpdateResult {
  struct Parameter {
    std::string name, unit;
    double initial = 0.0, value = 0.0;
    double std = 0.0;  ///< infinite if neither frequencies nor prior determine it, not a number at a bound
    /// From the scatter of the frequencies' residuals; not a number if none is left or `std` is none. With a right
    /// model it is about `std`.
    double std_robust = std::numeric_limits<double>::quiet_NaN();
    /// The deviation with what `known_to` adds; not a number where nothing is stated, or `std` is none.
    double std_considered = std::numeric_limits<double>::quiet_NaN();
    /// From the deviation whose interval is the wider one, with what `known_to` adds, cut at the bounds; not a number
    /// if `std` is none.
    struct Interval {
      double lower = std::numeric_limits<double>::quiet_NaN(), upper = lower;
    } interval_95 = {};
  };
  /// What the comparisons tell at the initial values.
  struct Before {
    /// d ln f / d ln parameter, a row for each of `frequencies`, a column for each parameter; of a parameter that is 0
    /// per width of its bounds.
    Eigen::MatrixXd sensitivities = {};
    std::vector<std::string> undetermined = {};         ///< combinations of parameters, one sentence each
    std::vector<std::vector<std::string>> groups = {};  ///< whose members one change would move, and then all would be
                                                        ///< determined; of one member: it stays as it is
    std::vector<std::string> hold = {};                 ///< parameters to leave out
  };
  std::vector<Parameter> parameters;
  Before before = {};
  std::vector<FrequencyComparison> frequencies;   ///< of all comparisons of modes, in their order
  std::vector<ComparisonFit> comparisons;         ///< "frequencies", if given, then those of the options
  std::vector<StatedNumber> stated_numbers = {};  ///< of which UpdateOptions::known_to says something
  bool converged = false;
  std::string reason;  ///< why it ended, in words
  Verdict verdict;     ///< whether the numbers agree with each other and with what was stated about them

  /// Whether nothing in the numbers makes them worthless.
  [[nodiscard]] bool usable() const { return verdict.state() != VerdictState::unusable; }
};

/// Refines parameters of linear substructures by what was measured: modes, frequency responses, static deflections,
/// records. Minimises
///     sum weight ((model - measured) / std)^2 + sum ((theta - initial) / std)^2
/// by a bounded Gauss-Newton method; derivatives are exact, those of simulated records central differences. It is what
/// `update` of a case gives. Throws InvalidInput with every argument that is wrong, by its place, and where a parameter
/// has no effect on any comparison; how the search ended is in the result.
UpdateResult update(const Structure& structure, const UpdateOptions& options);

}  // namespace kalfem
