// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/report.hpp"

#include <fmt/format.h>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

const std::vector<UnknownParameter>& unknowns_of(const RecordEstimate& estimate) {
  return estimate.augmented_model->options().unknowns;
}

std::string words_of(double factor) {
  if (factor == 1.0) return "as stated";
  return factor < 1.0 ? fmt::format("1/{:.2g}", 1.0 / factor) : fmt::format("x {:.2g}", factor);
}

}  // namespace

Json process_noise_summary(const RecordEstimate& estimate) {
  Json trials = Json::array();
  for (const auto& trial : estimate.process_noise) {
    Json parameters = Json::object();
    for (std::size_t i = 0; i < unknowns_of(estimate).size(); ++i)
      parameters[unknowns_of(estimate)[i].name] = {{"estimate", number(trial.estimates[static_cast<Index>(i)])},
                                                   {"std", number(trial.deviations[static_cast<Index>(i)])}};
    trials.push_back({{"factor", number(trial.factor)},
                      {"log_likelihood", number(trial.log_likelihood)},
                      {"mean_nis", number(trial.mean_nis)},
                      {"parameters", parameters}});
  }
  return trials;
}

Table process_noise_table(const RecordEstimate& estimate) {
  Table table{"Estimates against the process noise", {"process noise", "unit"}, {}, {}};
  std::vector<std::string> likelihood{"log-likelihood", ""}, nis{"NIS", ""};
  for (const auto& trial : estimate.process_noise) {
    table.columns.push_back(words_of(trial.factor));
    likelihood.push_back(fmt::format("{:.1f}", trial.log_likelihood));
    nis.push_back(four_digits(trial.mean_nis));
  }
  for (std::size_t i = 0; i < unknowns_of(estimate).size(); ++i) {
    std::vector<std::string> row{unknowns_of(estimate)[i].name, unknowns_of(estimate)[i].unit};
    for (const auto& trial : estimate.process_noise)
      row.push_back(fmt::format("{} +- {:.2g}", four_digits(trial.estimates[static_cast<Index>(i)]),
                                trial.deviations[static_cast<Index>(i)]));
    table.rows.push_back(std::move(row));
  }
  table.rows.push_back(std::move(nis));
  table.rows.push_back(std::move(likelihood));
  return table;
}

Section process_noise_section(const RecordEstimate& estimate) {
  return {
      "Estimates against the process noise",
      fmt::format("The process noise stands for what the model leaves out. The same record with other densities: what "
                  "changes by more than its standard deviation is decided by this choice. NIS is expected at {}. Of "
                  "parameters that walk, the means after settling.",
                  four_digits(estimate.consistency.expected_nis)),
      {process_noise_table(estimate)}};
}

}  // namespace kalfem
