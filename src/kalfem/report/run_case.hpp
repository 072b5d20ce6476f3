// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/identification/unknown_scores.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A number that a case estimated or updated.
struct CaseValue {
  std::string name, unit;
  double mean = 0.0, std = 0.0;
  double std_robust = 0.0;  ///< holds where the model is not exact; not a number if there is none
};

/// What a run of a case file gives, beside the files that it writes.
struct CaseResult {
  std::vector<CaseValue> estimated;   ///< the filter's unknowns at the record's end
  std::vector<CaseValue> updated;     ///< the refined parameters
  double mean_nis = 0.0;              ///< after settling, 0 where nothing was estimated
  std::vector<std::string> files;     ///< in the folder: summary.json, results.h5, report.html, ...
  std::vector<std::string> warnings;  ///< of the case and of the results
  Verdict verdict;                    ///< whether the numbers agree with each other and with what was stated about them
  std::string failure;                ///< in words, where the numbers are not usable

  [[nodiscard]] bool usable() const { return failure.empty(); }
};

/// How a case is run.
struct RunCaseOptions {
  std::filesystem::path folder = {};  ///< for the files of the results; empty: nothing is written
  /// Keys of the case with the values, in YAML, that they get instead of their own: {"simulate.duration", "4 s"}.
  /// Without a value the key is removed. Keys may hold dots: the longest one that the case has counts; an item of a
  /// list is its number from 0, or its `name`.
  std::vector<std::pair<std::string, std::optional<std::string>>> set = {};
  std::string last_step = "everything";  ///< or modes, simulate, estimate, predict, update, infer, place, static, frf
  Progress progress = {};
};

/// One series of a run's results, as results.h5 holds it.
struct CaseSeries {
  std::string path;  ///< "/estimate/body.3/displacement"
  Eigen::VectorXd values;
  std::string unit;
  std::optional<double> sample_rate = {};   ///< [Hz]; empty: the values are not at even times
  std::optional<Eigen::Index> chains = {};  ///< of values that are draws: so many chains, one after the other
};

/// A run of a case with everything that it found, whether or not files were written. A value that is cheap to copy.
class CaseRun {
public:
  /// Runs every step that the case file declares, as `kalfem run` does, or those up to `last_step`. Throws InvalidInput
  /// with every problem of the case, by file and line, and of a changed key as "set['key']", and WriteFailure (a
  /// std::runtime_error) where the results cannot be written.
  explicit CaseRun(const std::filesystem::path& case_file, const RunCaseOptions& options = {});

  [[nodiscard]] const CaseResult& result() const;
  /// The text of summary.json.
  [[nodiscard]] const std::string& summary() const;
  /// Visits what results.h5 holds.
  void visit(const std::function<void(const CaseSeries&)>& visitor) const;
  /// Covariances of the innovations, which results.h5 does not hold: lower triangles row by row, s (s + 1) / 2 x
  /// samples for s sensors; empty for more than 16 of them, and where nothing was estimated.
  struct InnovationCovariance {
    Eigen::MatrixXd triangles;
    Eigen::Index sensors = 0;
  };
  [[nodiscard]] InnovationCovariance innovation_covariance() const;
  /// What every sample tells of each constant unknown, which results.h5 does not hold; see scores_of_unknowns().
  [[nodiscard]] std::vector<UnknownScore> scores() const;
  /// The text of report.html.
  [[nodiscard]] std::string report() const;

private:
  struct Contents;
  std::shared_ptr<const Contents> contents_;
};

/// Runs every step that a case file declares and writes the results into a folder, as `kalfem run` does. Throws as
/// CaseRun does.
CaseResult run_case(const std::filesystem::path& case_file, const std::filesystem::path& folder,
                    const Progress& progress = {});

}  // namespace kalfem
