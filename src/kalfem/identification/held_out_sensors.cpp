// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/held_out_sensors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/identification/record_estimation.hpp"
#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/statistics/motion_errors.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double band = 1.96;
constexpr double level = 0.01;  ///< of both figures of all sensors together
constexpr Index fewest_samples = 50;
constexpr std::array parts_of_motion{0.01, 0.03, 0.1};  ///< accelerations that process noise starts from
constexpr double far_likelier = 3.0;                    ///< ln L

/// Samples of a channel, and the filter's predictions of them without it.
struct HeldOutSamplesOf {
  VectorXd error, deviation, prediction;
};

HeldOutSamplesOf samples_of(Index channel, const FilteredRecord& filtered, Index settled) {
  const auto& values = filtered.run.input.measured.values;
  std::vector<double> error, deviation, prediction;
  for (const auto& each : filtered.result.set_aside) {
    if (each.channel != channel || each.sample < settled || !std::isfinite(each.innovation)) continue;
    error.push_back(each.innovation);
    deviation.push_back(each.deviation);
    prediction.push_back(values(channel, each.sample) - each.innovation);
  }
  const auto vector = [](const std::vector<double>& all) {
    return VectorXd::Map(all.data(), static_cast<Index>(all.size())).eval();
  };
  return {vector(error), vector(deviation), vector(prediction)};
}

/// 2 Phi(r) - 1.
double within(double r) { return std::erf(r / std::sqrt(2.0)); }

/// The figures of one sensor among so many.
HeldOutSensor judged(const Channel& channel, const HeldOutSamplesOf& of, std::size_t sensors) {
  const VectorXd errors = of.error.cwiseQuotient(of.deviation);
  const auto n = static_cast<double>(errors.size());
  const double variance = channel.noise * channel.noise;
  const double share = (1.0 - variance * of.deviation.cwiseAbs2().cwiseInverse().array()).max(0.0).mean();
  const MotionErrors found = motion_errors(errors, of.prediction.cwiseQuotient(of.deviation));
  const double chance = level / (2.0 * static_cast<double>(sensors));
  const double allowed = n * share * chi_squared_quantile(1.0 - chance, 1.0);
  const auto relative = [&](double figure, double freedom) {
    return freedom > 0.0 ? figure / (chi_squared_quantile(1.0 - chance, freedom) + allowed) : 0.0;
  };
  HeldOutSensor sensor{.name = channel.name,
                       .unit = channel.unit,
                       .samples = errors.size(),
                       .inside = (errors.array().abs() <= band).cast<double>().mean(),
                       .motion_deviation = std::sqrt((of.deviation.cwiseAbs2().array() - variance).max(0.0).mean()),
                       .noise = channel.noise,
                       .followed = relative(found.followed, found.followed_freedom),
                       .in_band = relative(found.in_band, found.in_band_freedom)};
  if (sensor.holds()) return sensor;
  const double above = std::max(found.followed - found.followed_freedom, found.in_band - found.in_band_freedom) / n;
  sensor.motion_inside = std::min(0.95, within(band * std::sqrt(share / above)));
  return sensor;
}

/// Passes about the estimates without one sensor each.
class Passes {
public:
  Passes(EstimationProblemPtr problem, const AugmentedModelSetup& setup, const Record& record,
         const RecordEstimate& estimate)
      : problem_(std::move(problem)), record_(record), estimate_(estimate) {
    IssueList issues;
    setup_ = make_augmented_model_setup(*problem_, *setup.parts, {}, issues);
    issues.raise();
    setup_.starts_at_rest = !estimate.start.moving;
  }

  [[nodiscard]] FilteredRecord run(std::optional<Index> without) const {
    const auto& settings = problem_->settings;
    EstimationOptions options = rerun_options({}, settings, estimate_);
    options.threads = 1;
    if (without) options.held_out.push_back({*without, 0, record_.samples()});
    return run_filter(problem_, setup_, record_, options);
  }

  /// Side by side; nothing for one without which the filter stops or that has hardly any samples.
  [[nodiscard]] std::vector<std::optional<HeldOutSensor>> without(const std::vector<Index>& channels) const {
    std::vector<std::optional<HeldOutSensor>> found(channels.size());
    const auto sensors = estimate_.measurements.channels.size();
    for_each_index(channels.size(), filter_threads(problem_->settings), [&](std::size_t i) {
      const FilteredRecord filtered = run(channels[i]);
      if (filtered.result.failure) return;
      const auto samples = samples_of(channels[i], filtered, first_counted());
      const auto& channel = filtered.run.input.measured.channels[static_cast<std::size_t>(channels[i])];
      if (samples.error.size() >= fewest_samples) found[i] = judged(channel, samples, sensors);
    });
    return found;
  }

private:
  /// What a wide first guess of the motion bends in a nonlinear model dies out more slowly without a sensor.
  [[nodiscard]] Index first_counted() const {
    const bool guessed = estimate_.start.moving || !problem_->settings.initial_state.empty();
    return guessed ? std::max(estimate_.settled, record_.samples() / 2) : estimate_.settled;
  }

  EstimationProblemPtr problem_;
  AugmentedModelSetup setup_;
  const Record& record_;
  const RecordEstimate& estimate_;
};

/// Root mean square of the monitored accelerations; 0 where none is monitored.
double acceleration_of(const RecordEstimate& estimate, const std::vector<OutputDescription>& monitored) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < monitored.size(); ++i) {
    if (monitored[i].quantity != ObservedQuantity::acceleration) continue;
    const auto row = estimate.result.monitored.mean.row(static_cast<Index>(i)).array();
    sum += row.isFinite().select(row, 0.0).square().mean();
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

EstimationProblemPtr with_adapted_process(const EstimationProblem& problem, double density) {
  auto with = std::make_shared<EstimationProblem>(problem);
  with->settings.process_noise.acceleration = density;
  with->settings.adaptive_noise.process = true;
  return with;
}

/// The likeliest start, tried on the sensors whose bands do not hold.
std::optional<AdaptedProcessTrial> try_adapted_process(const EstimationProblem& about, const AugmentedModelSetup& setup,
                                                       const Record& record, const RecordEstimate& estimate,
                                                       double acceleration, const std::vector<Index>& failing) {
  const double log_likelihood =
      Passes(std::make_shared<EstimationProblem>(about), setup, record, estimate).run({}).result.log_likelihood;
  std::optional<AdaptedProcessTrial> best;
  for (const double part : parts_of_motion) {
    // White noise of density q held over half the sampling rate has the size q sqrt(f / 2).
    const double density = part * acceleration / std::sqrt(0.5 * record.sample_rate);
    const auto result = Passes(with_adapted_process(about, density), setup, record, estimate).run({}).result;
    if (result.failure) continue;
    const double gain = result.log_likelihood - log_likelihood;
    if (!best || gain > best->gain) best = {.density = density, .gain = gain};
  }
  if (!best) return best;
  const auto sensors = Passes(with_adapted_process(about, best->density), setup, record, estimate).without(failing);
  for (const auto& each : sensors)
    if (each) best->sensors.push_back(*each);
  best->mends = best->gain > far_likelier && best->sensors.size() == failing.size() &&
                std::ranges::all_of(best->sensors, &HeldOutSensor::holds);
  return best;
}

}  // namespace

const HeldOutSensor* HeldOutStudy::worst() const {
  const HeldOutSensor* worst = nullptr;
  for (const auto& each : sensors)
    if (!each.holds() && (!worst || each.motion_inside < worst->motion_inside)) worst = &each;
  return worst;
}

HeldOutStudy study_held_out_sensors(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                    const Record& record, const RecordEstimate& estimate,
                                    const RecordEstimateOptions& options, bool trial, StepBudget& budget) try {
  HeldOutStudy study;
  const auto& channels = estimate.measurements.channels;
  if (estimate.result.failure || channels.size() < 2 || problem->settings.initial_state_from_record) return study;
  const auto about = about_estimates(*problem, estimate, 1.0);
  const double pass = steps_of_run(*about, record, *about->settings.substeps);
  std::vector<Index> tried;
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (budget.take(pass))
      tried.push_back(static_cast<Index>(i));
    else
      study.not_tried.push_back(channels[i].name);
  study.stopped = !study.not_tried.empty();
  if (tried.empty()) return study;
  const auto found = Passes(about, setup, record, estimate).without(tried);
  std::vector<Index> failing;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    if (!found[i]) {
      study.not_tried.push_back(channels[static_cast<std::size_t>(tried[i])].name);
      continue;
    }
    study.sensors.push_back(*found[i]);
    if (!found[i]->holds()) failing.push_back(tried[i]);
  }
  const double acceleration = acceleration_of(estimate, options.monitored);
  if (failing.empty() || !trial || !(acceleration > 0.0) || problem->settings.adaptive_noise.process) return study;
  if (budget.take(pass * static_cast<double>(1 + parts_of_motion.size() + failing.size())))
    study.adapted = try_adapted_process(*about, setup, record, estimate, acceleration, failing);
  return study;
} catch (const InvalidInput&) {
  return {};  // at the estimates there is no structure
}

/// What is stated of fixed numbers stands in the bands of what is monitored, and not in those of a sensor held out.
void RecordEstimation::hold_out_sensors(StepBudget& budget) {
  const auto& settings = problem_->settings;
  if (!settings.diagnose || !settings.known_to.empty() || options_.monitored.empty()) return;
  if (estimate_.result.failure || estimate_.substeps.limited || innovations_contradict(estimate_, estimate_.settled))
    return;
  const bool explained = estimate_.freed && estimate_.freed->problem;
  auto study = study_held_out_sensors(problem_, screening_->setup(), screening_->record(), estimate_, options_,
                                      !explained, budget);
  if (study.stopped) {
    std::string names;
    for (const auto& name : study.not_tried) names += (names.empty() ? "" : ", ") + name;
    estimate_.leave_out("sensors as virtual ones: " + names);
  }
  if (!study.sensors.empty()) estimate_.held_out_sensors = std::make_shared<const HeldOutStudy>(std::move(study));
}

}  // namespace kalfem
