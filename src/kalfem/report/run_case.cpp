#include "kalfem/report/run_case.hpp"

#include <limits>

#include "kalfem/report/result_set.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

std::vector<CaseValue> estimated_values(const EstimationOutcome& estimation) {
  std::vector<CaseValue> values;
  const auto& unknowns = estimation.augmented_model->options().unknowns;
  const auto& [mean, deviation] = estimation.result.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Index>(i);
    values.push_back({unknowns[i].name, unknowns[i].unit, mean(row, mean.cols() - 1), deviation(row, mean.cols() - 1),
                      estimation.robust_deviation[row]});
  }
  return values;
}

/// Of an updating that failed there are no deviations.
double deviation_of(const Eigen::VectorXd& deviations, Index parameter) {
  return parameter < deviations.size() ? deviations[parameter] : std::numeric_limits<double>::quiet_NaN();
}

std::vector<CaseValue> updated_values(const UpdatingSetup& setup, const UpdatingOutcome& updating) {
  std::vector<CaseValue> values;
  for (std::size_t i = 0; i < setup.parameters.size(); ++i) {
    const auto row = static_cast<Index>(i);
    values.push_back({setup.parameters[i].name, setup.parameters[i].unit, updating.values[row],
                      deviation_of(updating.statistics.deviations, row),
                      deviation_of(updating.robust.deviations, row)});
  }
  return values;
}

}  // namespace

CaseResult run_case(const std::filesystem::path& case_file, const std::filesystem::path& folder,
                    const Progress& progress) {
  const Stopwatch watch;
  OutputFolder output(folder);
  const Study study = load_study(case_file.string());
  require_result_places(output.path(), study);
  const StudyResults results = run_study(study, Step::update, {.progress = progress, .folder = output.path()});
  CaseResult result;
  result.files = write_result_set(output, study, results, watch).files;
  if (results.estimation) {
    result.estimated = estimated_values(*results.estimation);
    result.mean_nis = results.estimation->consistency.mean_nis;
  }
  if (results.updating) result.updated = updated_values(*study.updating, *results.updating);
  result.warnings = study.warnings;
  result.warnings.insert(result.warnings.end(), results.warnings.begin(), results.warnings.end());
  result.verdict = results.verdict;
  result.failure = results.why_unusable();
  return result;
}

}  // namespace kalfem
