// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double most_work = 6e10;      ///< operations of all trials, about: decides how much of the record they see
constexpr double telling_part = 0.3;    ///< of the sum of NIS that the trials should see
constexpr Index fewest_samples = 1500;  ///< of the record, where it has as many
constexpr double longest_delay = 0.15;  ///< [s]
constexpr std::size_t refined = 8;      ///< best hypotheses whose number is searched
constexpr double worth_refining = 0.2;  ///< part of the best's rise
constexpr int most_steps = 10;          ///< of such a search
constexpr double significant = 20.0;    ///< rise of the log-likelihood
constexpr double as_good = 0.002;       ///< log-likelihood per measured value by which equal explanations differ

/// How well a run fits its record.
struct Score {
  double log_likelihood = -std::numeric_limits<double>::infinity();
  double mean_nis = 0.0, expected_nis = 0.0, widening = 1.0;
  VectorXd estimates;
  Eigen::VectorXi samples;  ///< present in each channel
};

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

double largest_widening(const FilterRun& run, const EstimationResult& result) {
  const Index settled = result.innovation.cols() / 20;
  double largest = 1.0;
  for (const auto& sensor : sensor_consistency(innovations_of(run.input.measured, result, settled)))
    largest = std::max(largest, sensor.widening());
  return largest;
}

/// `expected`: samples of each channel in the run as it was given; those that a correction takes away count as much as
/// the channel's mean. Empty for that run itself.
Score score_of(const CorrectedRun& corrected, const EstimationOptions& options, const Eigen::VectorXi& expected) {
  Score score;
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
  const auto there = result.nis.array().isFinite();
  const double count = std::max(1.0, static_cast<double>(there.count()));
  score.mean_nis = there.select(result.nis.array(), 0.0).sum() / count;
  score.expected_nis = static_cast<double>(result.measured.sum()) / count;
  score.widening = largest_widening(run, result);
  score.estimates = result.unknowns.mean.rightCols(1);
  return score;
}

/// Operations of one step of the filter, about.
double work_of_step(const FilterRun& run) {
  const auto n = static_cast<double>(run.choice.augmented_model->layout().size());
  const bool partially_linear = run.choice.filter == FilterKind::partially_linear ||
                                run.choice.filter == FilterKind::partially_linear_square_root;
  return partially_linear ? 50.0 * n * n : 10.0 * n * n * n;
}

/// Samples until the sum of NIS has reached a good part of its whole; where the filter stopped before the end, twice as
/// many as it reached.
Index telling_samples(const VectorXd& nis, Index samples) {
  if (nis.size() < samples) return 2 * nis.size();
  const VectorXd known = nis.array().isFinite().select(nis, 0.0);
  const double wanted = telling_part * known.sum();
  double sum = 0.0;
  for (Index k = 0; k < samples; ++k) {
    sum += known[k];
    if (sum >= wanted) return k + 1;
  }
  return samples;
}

/// The first part of the record: long enough to tell what is wrong, and no longer than so many trials can afford.
Record part_for(const DiagnosisInput& input, const FilterRun& run) {
  const auto affordable = static_cast<Index>(most_work / (diagnosis_trials * work_of_step(run)));
  const Index wanted =
      std::max(fewest_samples, std::min(affordable, telling_samples(input.nis, input.record.samples_used())));
  const auto samples =
      static_cast<Index>(std::min(static_cast<double>(std::min(input.record.samples(), wanted)), input.samples));
  Record part = input.record;
  part.values = input.record.values.leftCols(samples).eval();
  if (part.used) part.used = std::min(*part.used, samples);
  return part;
}

class Trials {
public:
  explicit Trials(const DiagnosisInput& input) : input_(input), base_(input_.run_of(input_.problem, input_.parts)) {
    input_.record = part_for(input_, base_);
    base_ = input_.run_of(input_.problem, input_.parts);
    options_ = {.filter = base_.choice.filter,
                .unscented = input_.options.unscented,
                .state_deviations = false,
                .adaptive_noise = input_.options.adaptive_noise};
  }

  Diagnosis run() {
    const Stopwatch watch;
    Score given = score_of({base_, 0.0}, options_, {});
    given.samples = measured_samples();  // also of a run that stopped
    Diagnosis diagnosis{.duration = static_cast<double>(input_.record.samples()) / input_.record.sample_rate,
                        .failed = !std::isfinite(given.log_likelihood),
                        .mean_nis = given.mean_nis,
                        .expected_nis = given.expected_nis,
                        .widening = given.widening};
    hypotheses_ = all_hypotheses();
    scores_.resize(hypotheses_.size());
    values_.resize(hypotheses_.size());
    for_each_index(hypotheses_.size(), processors(), [&](std::size_t h) {
      for (const double start : hypotheses_[h].starts) try_value(h, start, given);
    });
    refine_the_best(given);
    collect(given, diagnosis);
    diagnosis.seconds = watch.seconds();
    return diagnosis;
  }

private:
  /// Keeps the value if it explains the record better than those before. Says whether it does. A correction that the
  /// problem does not admit (a negative mass) explains nothing.
  bool try_value(std::size_t h, double value, const Score& given) {
    Score score;
    try {
      score = score_of(hypotheses_[h].correct(value), options_, given.samples);
    } catch (const InvalidInput&) {
    }
    if (!(score.log_likelihood > scores_[h].log_likelihood)) return false;
    scores_[h] = std::move(score);
    values_[h] = value;
    return true;
  }

  std::vector<Hypothesis> all_hypotheses() const {
    std::vector<Hypothesis> all = sensor_hypotheses(input_, base_, likeness_of_sensors(), likeness_of_all());
    const auto append = [&](std::vector<Hypothesis> further) {
      all.insert(all.end(), std::make_move_iterator(further.begin()), std::make_move_iterator(further.end()));
    };
    append(excitation_hypotheses(base_, sources(), likeness_of_excitations()));
    append(model_hypotheses(input_, motion_of_connectors()));
    return all;
  }

  /// Of each channel, in the part of the record that the filter learns from.
  [[nodiscard]] Eigen::VectorXi measured_samples() const {
    const auto& measured = base_.input.measured;
    return measured.values.leftCols(measured.samples_used()).array().isFinite().rowwise().count().cast<int>();
  }

  [[nodiscard]] Index longest_lag() const {
    const auto& record = input_.record;
    return std::min<Index>(record.samples() / 4, std::llround(longest_delay * record.sample_rate));
  }

  [[nodiscard]] std::vector<Index> all_sensors() const {
    std::vector<Index> all(static_cast<std::size_t>(base_.input.measured.values.rows()));
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    return all;
  }

  [[nodiscard]] std::vector<Likeness> likeness_of_sensors() const {
    const auto& values = base_.input.measured.values;
    std::vector<Likeness> found;
    for (Index i = 0; i < values.rows(); ++i) {
      const MatrixXd predicted = predicted_without(input_, base_, options_, {i});
      found.push_back(predicted.size() == 0 ? Likeness{} : likeness(values.row(i), predicted.row(i), longest_lag()));
    }
    return found;
  }

  [[nodiscard]] Likeness likeness_of_all() const {
    const MatrixXd predicted = predicted_without(input_, base_, options_, all_sensors());
    return predicted.size() == 0 ? Likeness{} : likeness(base_.input.measured.values, predicted, longest_lag());
  }

  [[nodiscard]] std::vector<std::string> sources() const {
    IssueList issues;
    return make_augmented_model_setup(*input_.problem, input_.parts, {}, issues).input_sources;
  }

  /// What each excitation gives, against the record less what the others give.
  [[nodiscard]] std::vector<Likeness> likeness_of_excitations() const {
    const Index n_u = base_.input.inputs.rows() / 3;
    const auto& values = base_.input.measured.values;
    std::vector<MatrixXd> response;
    for (Index i = 0; i < n_u; ++i) {
      FilterRun alone = base_;
      for (Index j = 0; j < n_u; ++j)
        if (j != i)
          for (Index derivative = 0; derivative < 3; ++derivative)
            alone.input.inputs.row(derivative * n_u + j).setZero();
      response.push_back(predicted_without(input_, alone, options_, all_sensors()));
      if (response.back().size() == 0) return std::vector<Likeness>(static_cast<std::size_t>(n_u));
    }
    std::vector<Likeness> found;
    for (Index i = 0; i < n_u; ++i) {
      MatrixXd rest = values;
      for (Index j = 0; j < n_u; ++j)
        if (j != i) rest -= response[static_cast<std::size_t>(j)];
      found.push_back(likeness(rest, response[static_cast<std::size_t>(i)], longest_lag()));
    }
    return found;
  }

  [[nodiscard]] std::vector<ConnectorMotion> motion_of_connectors() const {
    IssueList issues;
    const auto setup = make_augmented_model_setup(*input_.problem, input_.parts, {}, issues);
    std::vector<OutputDescription> outputs;
    for (const auto& connector : input_.parts.connectors)
      for (const auto quantity : {ObservedQuantity::connector_deformation, ObservedQuantity::connector_rate,
                                  ObservedQuantity::connector_force})
        outputs.push_back({connector.name, quantity, {{connector.name, 1.0}}, false});
    EstimationOptions options = options_;
    try {
      options.monitored = make_outputs(*setup.model, outputs);
    } catch (const InvalidInput&) {
      return {};  // a part of the structure only: its connectors are not all in the model
    }
    options.deviation_stride = static_cast<int>(std::min<Index>(input_.record.samples(), 1'000'000));
    const auto result = estimate(*base_.choice.augmented_model, base_.input, options);
    std::vector<ConnectorMotion> motion;
    for (std::size_t j = 0; j < input_.parts.connectors.size(); ++j) {
      const auto row = static_cast<Index>(3 * j);
      const auto size = [&](Index r) { return rms_of_present(result.monitored.mean.row(r).transpose()); };
      motion.push_back({size(row), size(row + 1), size(row + 2)});
    }
    return motion;
  }

  [[nodiscard]] double gain(std::size_t h, const Score& given) const {
    const double n = std::max(2.0, static_cast<double>(given.samples.sum()));
    const double before = std::isfinite(given.log_likelihood) ? given.log_likelihood : lowest();
    return scores_[h].log_likelihood - before - 0.5 * hypotheses_[h].fitted * std::log(n);
  }

  /// Where the filter failed as it was given, every hypothesis under which it does not is measured from the worst.
  [[nodiscard]] double lowest() const {
    double lowest = 0.0;
    for (const auto& score : scores_)
      if (std::isfinite(score.log_likelihood)) lowest = std::min(lowest, score.log_likelihood);
    return lowest;
  }

  [[nodiscard]] std::vector<std::size_t> best_first(const Score& given) const {
    std::vector<std::size_t> order(hypotheses_.size());
    for (std::size_t h = 0; h < order.size(); ++h) order[h] = h;
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return gain(a, given) > gain(b, given); });
    return order;
  }

  void refine_the_best(const Score& given) {
    std::vector<std::size_t> chosen;
    const auto order = best_first(given);
    const double least = std::max(0.0, worth_refining * gain(order.front(), given));
    for (const std::size_t h : order)
      if (hypotheses_[h].search != Search::none && chosen.size() < refined && gain(h, given) >= least)
        chosen.push_back(h);
    for_each_index(chosen.size(), processors(), [&](std::size_t c) { refine(chosen[c], given); });
  }

  static double moved(const Hypothesis& hypothesis, double value, double steps) {
    return hypothesis.search == Search::factor ? value * std::exp(steps * hypothesis.step)
                                               : value + steps * hypothesis.step;
  }

  /// Walks uphill, twice as far after each success, and half as far, the other way, after each failure.
  void refine(std::size_t h, const Score& given) {
    const Hypothesis& hypothesis = hypotheses_[h];
    double steps = 1.0;
    for (int i = 0; i < most_steps; ++i) {
      if (hypothesis.search == Search::samples && std::abs(steps) < 1.0) break;
      const bool better = try_value(h, moved(hypothesis, values_[h], steps), given);
      const bool first_failure = !better && i == 0;
      steps = better ? 2.0 * steps : first_failure ? -steps : -0.5 * steps;
    }
  }

  void collect(const Score& given, Diagnosis& diagnosis) const {
    const auto order = best_first(given);
    for (const std::size_t h : order) {
      const auto& hypothesis = hypotheses_[h];
      const auto& score = scores_[h];
      const bool failed = !std::isfinite(score.log_likelihood);
      diagnosis.tested.push_back({.code = hypothesis.code,
                                  .subject = hypothesis.subject,
                                  .words = failed ? "" : hypothesis.words(values_[h], score.estimates),
                                  .remedy = hypothesis.remedy,
                                  .value = values_[h],
                                  .fitted = hypothesis.fitted,
                                  .failed = failed,
                                  .gain = failed ? 0.0 : gain(h, given),
                                  .mean_nis = score.mean_nis,
                                  .expected_nis = score.expected_nis,
                                  .widening = score.widening});
    }
    prefer_the_simplest(std::max(significant, as_good * static_cast<double>(given.samples.sum())), diagnosis);
  }

  /// Of those that explain as much as the best, the one that takes the fewest numbers from the record stands first.
  static void prefer_the_simplest(double tolerance, Diagnosis& diagnosis) {
    auto& tested = diagnosis.tested;
    if (tested.empty() || tested.front().failed) return;
    const double least = tested.front().gain - tolerance;
    const auto end = std::ranges::find_if(tested, [&](const auto& each) { return each.failed || each.gain < least; });
    std::stable_sort(tested.begin(), end, [](const auto& a, const auto& b) { return a.fitted < b.fitted; });
    for (auto other = tested.begin() + 1; other < end; ++other)
      if (other->fitted == tested.front().fitted) diagnosis.also.push_back(other->words);
  }

  DiagnosisInput input_;
  FilterRun base_;
  EstimationOptions options_;
  std::vector<Hypothesis> hypotheses_;
  std::vector<Score> scores_;
  std::vector<double> values_;  ///< at which the score stands
};

}  // namespace

std::optional<TestedHypothesis> Diagnosis::cause() const {
  if (tested.empty() || tested.front().failed || !(tested.front().gain > significant)) return std::nullopt;
  const auto& best = tested.front();
  const double excess = std::abs(mean_nis - expected_nis), left = std::abs(best.mean_nis - best.expected_nis);
  const bool explains = (failed && best.widening < unusable_widening) ||
                        (!failed && (left < 0.7 * excess || best.widening < 0.8 * widening));
  return explains ? std::optional(best) : std::nullopt;
}

Diagnosis diagnose(const DiagnosisInput& input) { return Trials(input).run(); }

std::vector<Reason> reasons_of(const Diagnosis& diagnosis, VerdictState state) {
  const auto cause = diagnosis.cause();
  if (!cause) return {};
  std::string others;
  for (const auto& words : diagnosis.also) others += (others.empty() ? "; as likely: " : ", or ") + words;
  const std::string before = diagnosis.failed ? "the filter stopped" : fmt::format("it is {:.3g}", diagnosis.mean_nis);
  const std::string remainder =
      state_of(cause->widening) == VerdictState::consistent ? "" : ", which does not explain all";
  return {{.code = cause->code,
           .subject = cause->subject,
           .text = fmt::format("{}: with this undone the mean NIS is {:.3g} (expected {:.3g}), as given {}{}{}",
                               cause->words, cause->mean_nis, cause->expected_nis, before, remainder, others),
           .remedy = cause->remedy,
           .state = state,
           .weight = std::numeric_limits<double>::infinity()}};
}

}  // namespace kalfem
