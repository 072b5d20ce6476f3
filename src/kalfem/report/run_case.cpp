// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/run_case.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/table.hpp"
#include "kalfem/steps/updating/outcome.hpp"

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

CaseResult values_of(const Study& study, const StudyResults& results) {
  CaseResult result;
  if (const auto* estimation = results.find<EstimationOutcome>()) {
    result.estimated = estimated_values(*estimation);
    result.mean_nis = estimation->consistency.mean_nis;
  }
  if (const auto* updating = results.find<UpdatingOutcome>())
    result.updated = updated_values(*study.updating, *updating);
  result.warnings = study.warnings;
  result.warnings.insert(result.warnings.end(), results.warnings.begin(), results.warnings.end());
  result.verdict = results.verdict;
  result.failure = results.why_unusable();
  return result;
}

/// Throws InvalidInput where no step has that name.
void require_step(const std::string& name) {
  std::vector<std::string> names;
  for (const auto* step : verbs()) names.emplace_back(step->name);
  const std::string all = fmt::format("{}", fmt::join(names, ", "));
  names.emplace_back(every_step);
  if (std::ranges::find(names, name) == names.end())
    throw InvalidInput("last_step: there is no step '" + name + "'" + did_you_mean(name, names), "",
                       fmt::format("give {} or {}", all, every_step));
}

Study load(const std::filesystem::path& case_file, const RunCaseOptions& options) {
  std::vector<CaseChange> changes;
  for (const auto& [key, value] : options.set) changes.push_back({key, value});
  return load_study(case_file.string(), changes);
}

}  // namespace

struct CaseRun::Contents {
  Study study;
  StudyResults results;
  CaseResult result;
  std::string summary;
};

/// The output folder is taken before anything is computed.
CaseRun::CaseRun(const std::filesystem::path& case_file, const RunCaseOptions& options) {
  const Stopwatch watch;
  require_step(options.last_step);
  std::optional<OutputFolder> output;
  if (!options.folder.empty()) output.emplace(options.folder);
  auto contents = std::make_shared<Contents>();
  contents->study = load(case_file, options);
  const Study& study = contents->study;
  if (output) require_result_places(output->path(), study);
  contents->results =
      run_study(contents->study, options.last_step, {.progress = options.progress, .folder = options.folder});
  contents->result = values_of(study, contents->results);
  if (output) {
    auto [files, removed, summary] = write_result_set(*output, study, contents->results, watch);
    contents->result.files = std::move(files);
    contents->summary = std::move(summary);
  } else {
    contents->summary = summary_text(summarise(study, contents->results), {}, watch.seconds());
  }
  contents_ = std::move(contents);
}

const CaseResult& CaseRun::result() const { return contents_->result; }
const std::string& CaseRun::summary() const { return contents_->summary; }

void CaseRun::visit(const std::function<void(const CaseSeries&)>& visitor) const {
  visit_results(contents_->study, contents_->results, [&](const ResultSeries& series) {
    visitor({series.path, series.values, series.unit, series.sample_rate, series.chains});
  });
}

CaseRun::InnovationCovariance CaseRun::innovation_covariance() const {
  const auto* estimation = contents_->results.find<EstimationOutcome>();
  if (!estimation) return {};
  return {estimation->result.innovation_covariance, estimation->result.innovation.rows()};
}

std::vector<UnknownScore> CaseRun::scores() const {
  const auto* estimation = contents_->results.find<EstimationOutcome>();
  return estimation ? scores_of_unknowns(*estimation) : std::vector<UnknownScore>{};
}

std::string CaseRun::report() const {
  Page page = make_page(contents_->study, contents_->results);
  page.run = nlohmann::json::parse(contents_->summary).at("run");
  return render_html(page);
}

CaseResult run_case(const std::filesystem::path& case_file, const std::filesystem::path& folder,
                    const Progress& progress) {
  return CaseRun(case_file, {.folder = folder, .progress = progress}).result();
}

}  // namespace kalfem
