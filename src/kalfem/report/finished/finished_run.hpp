// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// One parameter that a finished run identified, in its unit.
struct FoundParameter {
  std::string name, unit;
  std::optional<double> truth, initial, estimate, std, std_robust;
  std::optional<std::array<double, 2>> interval;  ///< 95 %
  std::string interval_from;                      ///< "std", "std_robust" or "std_considered"

  /// The larger of the two standard deviations, on which the 95 % interval rests; nothing if neither is known.
  [[nodiscard]] std::optional<double> deviation() const;
};

/// A step that identifies parameters, with what it found.
struct FoundParameters {
  std::string by;  ///< "filter", "updating" or "posterior"
  std::vector<FoundParameter> parameters;
};

/// NRMSEs by name: {"displacement", 0.003}. Nothing for a point that is at rest.
using NamedErrors = Named<std::optional<double>>;

struct FoundConsistency {
  std::optional<double> mean_nis, expected_nis, fraction_in_95;
};

struct FoundFilter {
  std::string filter, reason;
  long long steps = 0, states = 0;
  int substeps = 1;
  FoundConsistency consistency;
  std::optional<double> microseconds_per_step, real_time_factor;
};

/// The innovations of one sensor after settling.
struct FoundSensor {
  std::optional<double> ratio;        ///< of their rms to the expected one
  std::optional<double> correlation;  ///< of successive ones
};

/// A measured mode beside the model's, as a correlation paired them.
struct FoundPair {
  double measured_hz = 0.0;
  std::optional<int> model_mode;  ///< nothing where none agrees
  std::optional<double> model_hz, error, mac;
};

/// A run as its folder tells it: summary.json, and results.h5 beside it. SI units.
struct FinishedRun {
  std::filesystem::path folder;
  std::string summary;           ///< the text of summary.json
  std::string identity;          ///< the same for every file of the run
  std::string case_file, title;  ///< name of the case file; title of the case, may be empty
  bool usable = false;
  std::string message;   ///< why the numbers are not usable
  bool compared = true;  ///< with measurements; otherwise there is no verdict
  VerdictState verdict = VerdictState::consistent;
  std::vector<Reason> reasons;  ///< worst first
  std::vector<std::string> warnings, files;
  std::vector<FoundParameters> found;  ///< by each step that identified something, in the order of the steps
  std::optional<FoundFilter> filter;
  Named<FoundSensor> sensors;
  Named<NamedErrors> states;                  ///< point -> quantity -> NRMSE
  Named<NamedErrors> smoothed;                ///< the same of the smoother
  Named<NamedErrors> prediction;              ///< the same of the driven substructure
  Named<NamedErrors> validation;              ///< sensor -> kind of comparison -> NRMSE
  Named<std::vector<FoundPair>> correlation;  ///< comparison -> its measured modes
  NamedErrors timing;                         ///< "simulate" -> seconds; "total" stands first

  /// Folder's name without the ending .kalfem-out: a short name of the run.
  [[nodiscard]] std::string label() const;
  /// What the last step that identified something says of each parameter: the posterior before the updating before the
  /// filter.
  [[nodiscard]] std::vector<FoundParameter> parameters() const;
};

/// What a summary.json says; without a folder. Throws InvalidInput, as of the file `place`, where it is damaged or was
/// written by another version of kalfem.
FinishedRun finished_run_of(const std::string& summary, const std::filesystem::path& place);

/// Reads the results of a run. Throws InvalidInput if `folder` is none, holds no summary.json, or one that is damaged
/// or was written by another version of kalfem.
FinishedRun read_finished_run(const std::filesystem::path& folder);

}  // namespace kalfem
