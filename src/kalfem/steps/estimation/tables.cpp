// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/identification/walked_range.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/steps/frequency_response/report.hpp"
#include "kalfem/steps/inference/report.hpp"
#include "kalfem/steps/placement/report.hpp"
#include "kalfem/steps/statics/report.hpp"

namespace kalfem {
namespace {

void add_likelihood_unknowns(const Study& study, const LikelihoodEstimate& likelihood, Table& table) {
  for (std::size_t i = 0; i < likelihood.unknowns.size(); ++i) {
    const auto& [name, kind, sensors, unit, initial, deviation, truth, since] = likelihood.unknowns[i];
    const auto row = static_cast<Eigen::Index>(i);
    const double estimate = likelihood.values[row];
    const auto interval = likelihood.interval(row);
    const double std = likelihood.deviation[row], robust = likelihood.robust_deviation[row];
    const DisplayUnit shown(unit, {estimate, initial, std}, study.written_unit(name));
    table.rows.push_back({name, shown.unit(), shown.value(initial), shown.value(estimate, std),
                          shown.value(interval.lower, std) + " to " + shown.value(interval.upper, std),
                          interval.robust ? "robust std" : "std", shown.deviation(std), shown.deviation(robust), "-",
                          truth ? shown.value(*truth) : "-",
                          truth && *truth != 0.0 ? per_cent(estimate / *truth - 1.0) : "-"});
  }
}

}  // namespace

Table parameter_table(const Study& study, const EstimationOutcome& outcome) {
  Table table{"Parameters",
              {"parameter", "unit", "initial", "estimate", "95 % interval", "from", "std", "robust std",
               "considered std", "truth", "error"},
              {},
              {}};
  const auto last = outcome.result.unknowns.mean.cols() - 1;
  for (std::size_t i = 0; i < outcome.augmented_model->options().unknowns.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const auto& unknown = outcome.augmented_model->options().unknowns[i];
    const auto& truth = study.augmented_model->true_parameters[i];
    const double estimate = outcome.result.unknowns.mean(row, last);
    const auto interval = stated_interval(outcome, row);
    const auto range = walked_range(outcome, row);
    const double std = outcome.result.unknowns.deviation(row, last);
    const DisplayUnit shown(unknown.unit, {estimate, unknown.initial, std}, study.written_unit(unknown.name));
    const auto between = [&](double least, double greatest) {
      return shown.value(least, std) + " to " + shown.value(greatest, std);
    };
    table.rows.push_back(
        {unknown.name, shown.unit(), shown.value(unknown.initial),
         range ? between(range->least, range->greatest) : shown.value(estimate, std),
         range ? between(range->lower, range->upper) : between(interval.lower, interval.upper),
         range                 ? "all of the record"
         : interval.considered ? "known_to"
         : interval.robust     ? "robust std"
                               : "std",
         shown.deviation(std), shown.deviation(outcome.robust_deviation[row]),
         outcome.considered_deviation.size() > 0 ? shown.deviation(considered_deviation(outcome, row)) : "-",
         truth ? shown.value(*truth) : "-", truth && *truth != 0.0 ? per_cent(estimate / *truth - 1.0) : "-"});
  }
  if (outcome.likelihood) add_likelihood_unknowns(study, *outcome.likelihood, table);
  return without_empty_columns(std::move(table));
}

Table input_table(const EstimationOutcome& outcome) {
  Table table{"Unknown excitations",
              {"excitation", "unit", "rms", "std", "std without sensors", "error", "truth in the 95 % band"},
              {},
              {}};
  const auto first = outcome.settled;
  for (const auto& input : outcome.inputs) {
    const auto rms_after = [&](const Eigen::VectorXd& values) {
      const auto after = values.tail(std::max<Eigen::Index>(1, values.size() - first));
      return four_digits(after.norm() / std::sqrt(static_cast<double>(after.size())));
    };
    table.rows.push_back({input.input.name, input.input.unit, rms_after(input.mean), rms_after(input.deviation),
                          input.input.is_random_walk() ? "-" : four_digits(input.input.deviation),
                          input.nrmse ? per_cent(*input.nrmse) : "-",
                          input.coverage ? per_cent(*input.coverage) : "-"});
  }
  return table;
}

std::string hardly_known_words(const EstimationOutcome& outcome) {
  std::string names;
  for (const auto& name : outcome.hardly_known) names += (names.empty() ? "" : ", ") + name;
  return names.empty() ? "" : "The sensors hardly show (standard deviation above half of the size): " + names + ".";
}

Table open_loop_table(const EstimationOutcome& outcome) {
  Table table{"Open loop against the record", {"sensor", "NRMSE about rest", "rest error"}, {}, {}};
  for (std::size_t i = 0; i < outcome.open_loop_nrmse.size(); ++i)
    table.rows.push_back({outcome.measurements.channels[i].name,
                          outcome.open_loop_nrmse[i] < 1e3 ? fmt::format("{:.3f}", outcome.open_loop_nrmse[i])
                                                           : four_digits(outcome.open_loop_nrmse[i]),
                          four_digits(outcome.open_loop_rest_error[i]) + " " + outcome.measurements.channels[i].unit});
  return table;
}

std::string substep_words(const EstimationOutcome& outcome) {
  const auto& choice = outcome.substeps;
  const bool fourth = outcome.augmented_model && outcome.augmented_model->options().step_order == 4;
  const std::string number = fmt::format("{} substep{} per sample{}", choice.substeps, choice.substeps == 1 ? "" : "s",
                                         fourth ? ", each of fourth order" : "");
  if (!choice.chosen) return number + ", as stated; their bias was not measured";
  const Eigen::Index largest = choice.largest();
  if (largest < 0) return number + ": " + choice.words;
  const auto& unknown = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(largest)];
  return fmt::format("{}, chosen {}: they bias the estimates by at most {:.2g} standard deviations ('{}'){}", number,
                     choice.words, choice.bias[largest], unknown.name,
                     choice.stopped   ? "; more substeps are needed than second_thoughts allow"
                     : choice.limited ? "; more substeps would be needed, but the limit is reached"
                                      : "");
}

}  // namespace kalfem
