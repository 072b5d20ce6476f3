// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/point_errors.hpp"

namespace kalfem {
namespace {

constexpr std::size_t most_fixed_numbers = 5;

bool depends_on_process_noise(const Verdict& verdict) {
  return std::ranges::any_of(verdict.reasons(),
                             [](const Reason& reason) { return reason.code == "process_noise_decides"; });
}

/// How the unknowns of the linear part were followed; nothing where there are none.
std::string linearisation_words(const EstimationOutcome& outcome) {
  if (outcome.reductions == 0 && outcome.result.linearisations == 0) return "";
  return fmt::format("Linear part: relinearised {} times{}\n", outcome.result.linearisations,
                     outcome.reductions > 1
                         ? fmt::format(", reduced {} times, the last time at the estimates", outcome.reductions)
                         : "");
}

std::string parameters_told(const Study& study, const EstimationOutcome& outcome) {
  if (!outcome.has_samples()) return "";
  std::string text = (outcome.result.failure ? fmt::format("Parameters at {} s, before the filter stopped\n",
                                                           four_digits(outcome.measurements.end()))
                                             : std::string("Estimated parameters\n")) +
                     to_text(parameter_table(study, outcome)) + "\n";
  if (!outcome.alternatives.empty())
    text += "Laws, by the evidence of the record\n" + to_text(alternatives_table(study, outcome)) + "\n";
  if (outcome.fixed_numbers)
    text += considered_words(outcome) + "Numbers that are held fixed, those that matter most\n" +
            to_text(sensitivity_table(outcome, most_fixed_numbers)) + "\n";
  if (outcome.freed) text += freed_words(*outcome.freed);
  if (outcome.inputs.empty()) return text;
  text += "Unknown excitations\n" + to_text(input_table(outcome)) + "\n";
  if (const auto words = hardly_known_words(outcome); !words.empty()) text += words + "\n\n";
  return text;
}

/// Where the case does not state what is left out.
std::string judged_part_told(const Study& study, const EstimationOutcome& outcome) {
  if (study.problem->settings.settle || outcome.settled == 0) return "";
  const auto samples = outcome.measurements.samples();
  return fmt::format("Judged on {} of {} samples, after {} s\n", samples - outcome.settled, samples,
                     four_digits(outcome.judged_from()));
}

std::string consistency_told(const Study& study, const EstimationOutcome& outcome, const Verdict& verdict) {
  std::string text;
  if (std::isfinite(outcome.consistency.mean_nis))
    text += fmt::format("NIS {:.2f} (expected {:.2f}); {} of samples in the 95 % band\n", outcome.consistency.mean_nis,
                        outcome.consistency.expected_nis, per_cent(outcome.consistency.fraction_in_95));
  text += judged_part_told(study, outcome);
  if (outcome.held_out_sensors) text += held_out_words(*outcome.held_out_sensors);
  if (outcome.result.noise) text += adaptive_noise_words(outcome);
  if (outcome.frequencies)
    text += "\nNatural frequencies over the record [Hz]\n" + to_text(frequencies_table(*outcome.frequencies)) + "\n";
  if (depends_on_process_noise(verdict))
    text += "\nEstimates against the process noise\n" + to_text(process_noise_table(outcome)) + "\n";
  for (const auto& event : outcome.events) text += sentence(event.text);
  return text + (outcome.events.empty() ? "" : "\n");
}

std::string filter_told(const EstimationOutcome& outcome) {
  if (!outcome.has_samples())
    return fmt::format("Filter {}: it stopped before it computed a sample\n\n", to_string(outcome.filter));
  const auto& time = outcome.result.time;
  const auto samples = static_cast<double>(outcome.measurements.samples());
  return fmt::format("{} states, {} steps, {:.2g} us per step: {}\nFilter {}: {}\n{}\n",
                     outcome.augmented_model->layout().size(), outcome.measurements.samples(),
                     1e6 * time.filter() / samples,
                     speed_in_words(samples / outcome.measurements.sample_rate / time.filter()),
                     to_string(outcome.filter), outcome.filter_reason,
                     sentence(substep_words(outcome)) + (outcome.start.moving ? sentence(explain(outcome.start)) : "") +
                         linearisation_words(outcome));
}

std::string errors_told(const Study& study, const EstimationOutcome& outcome) {
  std::string text;
  const auto add = [&](const std::string& motion, const std::vector<PointQuantity>& points) {
    if (const auto table = error_table("", study, points, outcome.settled); !table.rows.empty())
      text += fmt::format("{}, NRMSE after {} s{}\n", motion, four_digits(outcome.judged_from()),
                          band_words(outcome.band)) +
              to_text(table) + "\n";
  };
  add("Estimated motion", outcome.points);
  add("Motion smoothed over the whole record", outcome.smoothed_points);
  if (!outcome.open_loop_failure.empty()) text += "No open-loop comparison: " + outcome.open_loop_failure + "\n\n";
  if (outcome.open_loop)
    text += "Open-loop simulation from the estimated parameters and initial state\n" +
            to_text(open_loop_table(outcome)) + "\n";
  return text;
}

}  // namespace

std::string console_first_answer(const Study& study, const EstimationOutcome& outcome) {
  return fmt::format("First answer, after {:.1f} s: second thoughts follow\n{}\n", outcome.first_answer_seconds,
                     to_text(parameter_table(study, outcome)));
}

std::string console_estimation(const Study& study, const EstimationOutcome& outcome, const Verdict& verdict) {
  return parameters_told(study, outcome) + consistency_told(study, outcome, verdict) + filter_told(outcome) +
         errors_told(study, outcome);
}

}  // namespace kalfem
