// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/trial.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/diagnosis/judge_estimation.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Log-density of one channel's innovations per sample, each by itself.
double mean_log_density(const EstimationResult& result, Index channel) {
  const auto innovation = result.innovation.row(channel).array(),
             deviation = result.innovation_deviation.row(channel).array();
  double sum = 0.0, count = 0.0;
  for (Index k = 0; k < innovation.size(); ++k)
    if (std::isfinite(innovation[k]) && deviation[k] > 0.0) {
      const double e = innovation[k] / deviation[k];
      sum -= 0.5 * (e * e + std::log(2.0 * M_PI * deviation[k] * deviation[k]));
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 0.0;
}

constexpr int more_passes = 4;

void judge_innovations(const FilterRun& run, const EstimationResult& result, TrialScore& score) {
  const auto there = result.nis.array().isFinite();
  const double count = std::max(1.0, static_cast<double>(there.count()));
  score.mean_nis = there.select(result.nis.array(), 0.0).sum() / count;
  score.expected_nis = static_cast<double>(result.measured.sum()) / count;
  score.estimates = result.unknowns.mean.rightCols(1);
  const Index settled = result.innovation.cols() / 20;
  for (const auto& sensor : sensor_consistency(innovations_of(run.input.measured, result, settled))) {
    score.widening = std::max(score.widening, sensor.widening());
    score.loudest_part = std::max(score.loudest_part, sensor.largest_part);
  }
}

}  // namespace

Record first_samples(Record record, Index samples) {
  if (samples >= record.samples()) return record;
  record.values = record.values.leftCols(samples).eval();
  if (record.used) record.used = std::min(*record.used, samples);
  return record;
}

CorrectedRun first_part(CorrectedRun corrected, Index samples) {
  FilterInput& input = corrected.run.input;
  const Index whole = input.measured.samples();
  if (samples >= whole) return corrected;
  const Index stride = input.input_stride(corrected.run.choice.augmented_model->options().instants());
  if (input.inputs.cols() > 0) input.inputs = input.inputs.leftCols((samples - 1) * stride + 1).eval();
  input.measured = first_samples(std::move(input.measured), samples);
  corrected.log_jacobian *= static_cast<double>(samples) / static_cast<double>(whole);
  return corrected;
}

TrialScore score_of(const CorrectedRun& corrected, const EstimationOptions& options, const Eigen::VectorXi& expected) {
  TrialScore score;
  const auto& run = corrected.run;
  const auto result = estimate(*run.choice.augmented_model, run.input, options);
  const Index l = result.innovation.rows();
  score.samples.resize(l);
  for (Index i = 0; i < l; ++i)
    score.samples[i] = static_cast<int>(result.innovation.row(i).array().isFinite().count());
  if (result.failure || !std::isfinite(result.log_likelihood)) return score;
  score.log_likelihood = result.log_likelihood + corrected.log_jacobian;
  for (Index i = 0; i < l && i < expected.size(); ++i)
    score.log_likelihood += (expected[i] - score.samples[i]) * mean_log_density(result, i);
  judge_innovations(run, result, score);
  return score;
}

TrialScore after_more_passes(TrialScore score, const FilterRun& run, EstimationOptions options) {
  if (score.failed() || score.leaves_nothing()) return score;
  if (!options.adaptive_noise.any()) options.passes = more_passes;
  const auto result = estimate(*run.choice.augmented_model, run.input, options);
  if (result.failure) return score;
  TrialScore again = score;
  again.widening = again.loudest_part = 1.0;
  judge_innovations(run, result, again);
  return again.widening < score.widening ? again : score;
}

}  // namespace kalfem
