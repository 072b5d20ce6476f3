// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/compute.hpp"
#include "kalfem/steps/inference/likelihood_checkpoint.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/report.hpp"
#include "kalfem/steps/run_step.hpp"

namespace kalfem {
namespace {

/// Equally weighted draws and their densities, in the groups and under the names of ArviZ's InferenceData.
void write_posterior(SeriesWriter& file, const InferenceOutcome& outcome) {
  const bool weighted = outcome.samples.weights.size() > 0;
  const SampleSet draws = weighted ? resample(outcome.samples, outcome.samples.values.cols()) : outcome.samples;
  for (std::size_t i = 0; i < draws.names.size(); ++i)
    file.write_chains("/posterior/" + draws.names[i], draws.values.row(static_cast<Eigen::Index>(i)).transpose(),
                      i < outcome.units.size() ? outcome.units[i] : "-", draws.chains);
  file.write_chains("/sample_stats/lp", draws.log_likelihood + draws.log_prior, "-", draws.chains);
  file.write_chains("/sample_stats/log_likelihood", draws.log_likelihood, "-", draws.chains);
}

/// Over the time of the record's part that was simulated.
void write_bands(SeriesWriter& file, const std::vector<PredictiveBand>& bands) {
  if (bands.empty()) return;
  const auto& first = bands.front();
  Eigen::VectorXd time(first.mean.size());
  for (Eigen::Index k = 0; k < time.size(); ++k) time[k] = first.start + static_cast<double>(k) / first.sample_rate;
  file.write_column("/predictive/time", time, "s");
  for (const auto& band : bands) {
    const std::string name = "/predictive/" + band.sensor;
    file.write_column(name + "/measured", band.measured, band.unit);
    file.write_column(name + "/lower", band.lower, band.unit);
    file.write_column(name + "/mean", band.mean, band.unit);
    file.write_column(name + "/upper", band.upper, band.unit);
  }
}

void write_inference(SeriesWriter& file, const InferenceOutcome& outcome) {
  if (outcome.samples.values.cols() > 0) write_posterior(file, outcome);
  write_bands(file, outcome.bands);
  for (const auto& profile : outcome.profiles) {
    file.write_column("/profile/" + profile.name + "/value", profile.values, profile.unit);
    file.write_column("/profile/" + profile.name + "/log_likelihood", profile.log_likelihood, "-");
  }
}

}  // namespace

RunStep inference_step() {
  return {.name = "infer",
          .meaning = "what the data tell of the unknowns: posterior, evidence, which law",
          .asked_for = [](const Study& study) { return study.inference.has_value(); },
          .with = {"estimate"},
          .phases =
              [](const Study&) {
                return std::vector<PlannedStep>{{"infer", 10.0}};
              },
          .run =
              [](RunContext& context) {
                context.results.put(run_inference(context.study, context.results, context.options_of("infer")));
              },
          .checkpoint = {.file = likelihoods_name},
          .ran = &has_outcome<InferenceOutcome>,
          .seconds = &seconds_of<InferenceOutcome>,
          .summarise =
              [](const Study&, const StudyResults& results, nlohmann::ordered_json& summary) {
                summary["inference"] = inference_summary(results.get<InferenceOutcome>());
              },
          .tell = [](const Study&,
                     const StudyResults& results) { return console_inference(results.get<InferenceOutcome>()); },
          .answer = [](const Study&,
                       const StudyResults& results) { return inference_answer(results.get<InferenceOutcome>()); },
          .sections = [](const Study&, const StudyResults& results) -> std::vector<PlacedSection> {
            return {{PagePlace::inference, inference_section(results.get<InferenceOutcome>())}};
          },
          .visit = [](const Study&, const StudyResults& results,
                      SeriesWriter& file) { write_inference(file, results.get<InferenceOutcome>()); }};
}

}  // namespace kalfem
