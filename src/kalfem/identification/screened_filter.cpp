#include "kalfem/identification/screened_filter.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;

namespace {

constexpr int most_runs = 5;

/// Searches for events and runs the filter again until it finds no more.
class Screening {
public:
  Screening(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
            EstimationOptions options)
      : problem_(problem), setup_(setup), record_(record), options_(std::move(options)) {
    options_.outliers.treatment = problem->settings.outliers.value_or(OutlierTreatment::keep);
    std::vector<std::string> names;
    for (const auto& sensor : setup.sensors) names.push_back(sensor.name);
    measured_ = select_channels(record, names);
  }

  ScreenedFilter run() {
    const bool searches = problem_->settings.outliers != OutlierTreatment::keep;
    if (searches) options_.held_out = constant_stretches(measured_);
    auto refined = run_refined_filter(problem_, setup_, record_, options_);
    for (int runs = 1; searches && runs < most_runs && changes(refined.filtered.result); ++runs) {
      state_noise(refined.filtered.result);
      refined = run_refined_filter(problem_, setup_, record_, options_);
    }
    auto events = missing_samples(measured_);
    for (auto& event : faults(refined.filtered.result)) events.push_back(std::move(event));
    return {std::move(refined), std::move(events), options_.outliers.treatment, options_.held_out};
  }

private:
  /// Whether the result asks for another run, which the options then describe.
  bool changes(const EstimationResult& result) {
    const bool restored =
        std::erase_if(options_.held_out, [&](const HeldOutSamples& stretch) {
          return stretch.end - stretch.begin >= 1 && !is_confirmed(stretch) && !contradicted(result, stretch);
        }) > 0;
    confirmed_ = options_.held_out;
    bool found = false;
    if (!result.failure) {
      found = hold_out(silent_stretches(measured_, result));
      found = hold_out(saturated_samples(measured_, result)) || found;
    }
    const bool spoilt = !problem_->settings.outliers && options_.outliers.treatment == OutlierTreatment::keep &&
                        shows_outliers(result, settled(result));
    if (spoilt) options_.outliers.treatment = OutlierTreatment::robust;
    return restored || found || spoilt;
  }

  [[nodiscard]] bool is_confirmed(const HeldOutSamples& stretch) const {
    return std::ranges::any_of(confirmed_, [&](const auto& each) {
      return each.channel == stretch.channel && each.begin == stretch.begin && each.end == stretch.end;
    });
  }

  /// Those that no other stretch holds already.
  bool hold_out(const std::vector<HeldOutSamples>& found) {
    bool any = false;
    for (const auto& stretch : found) {
      const bool held = std::ranges::any_of(confirmed_, [&](const auto& each) {
        return each.channel == stretch.channel && each.begin < stretch.end && stretch.begin < each.end;
      });
      if (held) continue;
      options_.held_out.push_back(stretch);
      any = true;
    }
    confirmed_ = options_.held_out;
    return any;
  }

  [[nodiscard]] Index settled(const EstimationResult& result) const {
    const auto count = static_cast<Index>(std::llround(problem_->settings.settle * record_.sample_rate));
    return result.failure ? 0 : std::min(count, measured_.samples() - 1);
  }

  [[nodiscard]] std::vector<SensorEvent> faults(const EstimationResult& result) const {
    return events_of(measured_, result, options_.held_out, options_.outliers.limit);
  }

  /// The noise of sensors that state it relative to their rms, where part of the channel is no measurement.
  void state_noise(const EstimationResult& result) {
    const auto events = faults(result);
    const Record used = without(measured_, events);
    for (const auto& sensor : setup_.sensors) {
      const bool affected = std::ranges::any_of(events, [&](const auto& each) { return each.channel == sensor.name; });
      if (!sensor.relative_noise || !affected) continue;
      const Index row = used.find(sensor.name);
      record_.channels[static_cast<std::size_t>(record_.find(sensor.name))].noise =
          sensor.deviation(rms_of_present(used.values.row(row).transpose()));
    }
  }

  const EstimationProblemPtr& problem_;
  const AugmentedModelSetup& setup_;
  Record record_, measured_;  ///< as given, with the noise that holds now; the sensors' channels of it
  EstimationOptions options_;
  std::vector<HeldOutSamples> confirmed_;
};

}  // namespace

ScreenedFilter run_screened_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                   const Record& record, EstimationOptions options) {
  return Screening(problem, setup, record, std::move(options)).run();
}

}  // namespace kalfem
