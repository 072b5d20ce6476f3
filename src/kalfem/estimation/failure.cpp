// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/failure.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double notable = 6.0;     ///< deviations: white noise gets there once in five hundred million samples
constexpr Index last_samples = 50;  ///< before the failure in which an innovation counts as its precursor

bool carries_factor(FilterKind kind) {
  return kind == FilterKind::unscented_square_root || kind == FilterKind::partially_linear_square_root;
}

/// Something that was far from what the filter expected, in standard deviations.
struct Symptom {
  Index index = -1;  ///< of the channel or unknown
  Index sample = 0;
  double deviations = 0.0;

  [[nodiscard]] bool notable() const { return deviations > kalfem::notable; }
};

/// The unknown that stood furthest from its prior, in the filter's state.
Symptom furthest_unknown(const FailureTrace& trace, const AugmentedModel& model, const EstimationResult& result) {
  Symptom found;
  const auto& unknowns = model.options().unknowns;
  if (trace.computed == 0) return found;
  const Index last = trace.computed - 1;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto& transform = unknowns[i].transform;
    const double start = transform.to_state(unknowns[i].initial);
    const double prior = unknowns[i].deviation / transform.slope(start);
    const double moved =
        std::abs(result.state.mean(model.layout().unknown() + static_cast<Index>(i), last) - start) / prior;
    if (unknowns[i].random_walk == 0.0 && moved > found.deviations) found = {static_cast<Index>(i), last, moved};
  }
  return found;
}

/// The largest innovation of the last samples, against what the filter expected of it.
Symptom loudest_channel(const FailureTrace& trace, const EstimationResult& result) {
  Symptom found;
  const Index end = std::min(trace.computed, result.innovation.cols());
  for (Index k = std::max<Index>(0, end - last_samples); k < end; ++k)
    for (Index i = 0; i < result.innovation.rows(); ++i) {
      const double deviations = std::abs(result.innovation(i, k)) / result.innovation_deviation(i, k);
      if (std::isfinite(deviations) && deviations > found.deviations) found = {i, k, deviations};
    }
  return found;
}

/// Collects what is known about a failure, the strongest symptom first.
class Explanation {
public:
  Explanation(const FailureTrace& trace, const AugmentedModel& model, const FilterInput& input,
              const EstimationOptions& options, const EstimationResult& result)
      : trace_(trace),
        model_(model),
        input_(input),
        options_(options),
        result_(result),
        unknown_(furthest_unknown(trace, model, result)),
        channel_(loudest_channel(trace, result)) {}

  EstimationFailure failure() {
    describe();
    advise();
    EstimationFailure failure{.outcome = trace_.outcome,
                              .time = static_cast<double>(trace_.sample) * model_.options().step,
                              .reason = to_string(trace_.outcome),
                              .subject = subject_,
                              .cause = joined(causes_, "; "),
                              .remedy = joined(remedies_, ", or "),
                              .computed = trace_.computed};
    if (!failure.cause.empty()) failure.reason += ": " + failure.cause;
    return failure;
  }

private:
  static std::string joined(const std::vector<std::string>& parts, const std::string& between) {
    std::string text;
    for (const auto& part : parts) text += (text.empty() ? "" : between) + part;
    return text;
  }

  [[nodiscard]] const UnknownParameter& unknown() const {
    return model_.options().unknowns[static_cast<std::size_t>(unknown_.index)];
  }

  [[nodiscard]] std::string channel_name(Index channel) const {
    const auto& channels = input_.measured.channels;
    const auto index = static_cast<std::size_t>(channel);
    return index < channels.size() ? channels[index].name : std::to_string(channel + 1);
  }

  void name(const std::string& subject, const std::string& cause) {
    if (subject_.empty()) subject_ = subject;
    causes_.push_back(cause);
  }

  void describe() {
    if (trace_.outcome == FilterOutcome::innovation_not_positive_definite) describe_noise();
    if (trace_.outcome == FilterOutcome::linear_part_impossible && unknown_.index >= 0) describe_unknown();
    if (unknown_.notable() && causes_.empty()) describe_unknown();
    if (channel_.notable()) describe_channel();
    if (trace_.connector) describe_connector();
    if (!causes_.empty()) return;
    if (trace_.computed == 0)
      causes_.emplace_back("it is the first sample, so the prior or the noise that the case states leads to it");
    else
      causes_.push_back(fmt::format(
          "no innovation before it was larger than {:.2g} expected deviations, so rounding errors are likely",
          std::max(1.0, channel_.deviations)));
  }

  void describe_noise() {
    for (Index i = 0; i < input_.noise.rows(); ++i)
      if (input_.noise(i, i) == 0.0) name(channel_name(i), fmt::format("'{}' has no noise", channel_name(i)));
  }

  void describe_unknown() {
    name(unknown().name,
         fmt::format("unknown '{}' stood at {:.4g}{}{}, {:.3g} prior deviations from its initial value {:.4g}",
                     unknown().name, result_.unknowns.mean(unknown_.index, unknown_.sample),
                     unknown().unit.empty() ? "" : " ", unknown().unit, unknown_.deviations, unknown().initial));
  }

  void describe_channel() {
    name(channel_name(channel_.index),
         fmt::format("the innovation of '{}' was {:.3g} times as large as expected at {:.6g} s",
                     channel_name(channel_.index), channel_.deviations, input_.measured.time(channel_.sample)));
  }

  void describe_connector() {
    const auto& connector = model_.system().connectors[static_cast<std::size_t>(*trace_.connector)].name;
    name(connector, fmt::format("it is the force of connector '{}'", connector));
  }

  void advise() {
    switch (trace_.outcome) {
      case FilterOutcome::innovation_not_positive_definite:
        remedies_.emplace_back(causes_.empty() || subject_.empty() ? "give every sensor more noise"
                                                                   : "give it a noise above 0");
        break;
      case FilterOutcome::model_not_evaluable:
      case FilterOutcome::linear_part_impossible:
        advise_on_unknown();
        if (trace_.outcome == FilterOutcome::model_not_evaluable) advise_on_substeps();
        break;
      case FilterOutcome::covariance_not_positive_definite:
        if (unknown_.notable()) advise_on_unknown();
        if (!unknown_.notable() && !channel_.notable() && !carries_factor(options_.filter))
          remedies_.emplace_back("use filter: partially_linear_ukf_square_root");
        advise_on_noise();
        break;
      case FilterOutcome::usable:
        break;
    }
    if (channel_.notable()) advise_on_channel();
  }

  void advise_on_unknown() {
    if (model_.options().unknowns.empty()) return;
    const bool one =
        unknown_.notable() || (trace_.outcome == FilterOutcome::linear_part_impossible && unknown_.index >= 0);
    const auto free = [](const UnknownParameter& each) {
      return each.transform.kind == TransformKind::none && each.sensors.empty();
    };
    const auto& all = model_.options().unknowns;
    if (one ? free(unknown()) : std::ranges::any_of(all, free))
      remedies_.push_back(one ? fmt::format("bound '{}' by transform: log or bounds", unknown().name)
                              : std::string("bound the unknown parameters by transform: log or bounds"));
    remedies_.push_back(one ? fmt::format("state a smaller std for '{}' or a better initial value", unknown().name)
                            : std::string("state a smaller std for the unknown parameters"));
  }

  void advise_on_substeps() {
    if (trace_.connector)
      remedies_.push_back(fmt::format("set estimate.substeps to more than {}", model_.options().substeps));
  }

  void advise_on_noise() {
    const auto& noise = model_.options().process_noise;
    remedies_.emplace_back(noise.acceleration.size() == 0 || noise.acceleration.isZero(0.0)
                               ? "give the model process noise (estimate.process_noise)"
                               : "state more process noise (estimate.process_noise)");
  }

  void advise_on_channel() {
    const std::string name = channel_name(channel_.index);
    remedies_.push_back(fmt::format("check sign, unit, place, clock and noise of '{}'", name));
    if (!model_.options().keep_initial_state && channel_.sample < last_samples)
      remedies_.emplace_back(
          "state how uncertain the initial state is (estimate.initial_state, or "
          "estimate_initial_state: true), where the structure moved before the record");
  }

  const FailureTrace& trace_;
  const AugmentedModel& model_;
  const FilterInput& input_;
  const EstimationOptions& options_;
  const EstimationResult& result_;
  Symptom unknown_, channel_;
  std::string subject_;
  std::vector<std::string> causes_, remedies_;
};

}  // namespace

EstimationFailure explain_failure(const FailureTrace& trace, const AugmentedModel& model, const FilterInput& input,
                                  const EstimationOptions& options, const EstimationResult& result) {
  return Explanation(trace, model, input, options, result).failure();
}

std::string remedy_of(FilterOutcome outcome, FilterKind kind) {
  switch (outcome) {
    case FilterOutcome::usable:
      return "";
    case FilterOutcome::model_not_evaluable:
    case FilterOutcome::linear_part_impossible:
      return "bound the unknown parameters (transform: log, or bounds) or narrow their prior";
    case FilterOutcome::covariance_not_positive_definite:
      return carries_factor(kind)
                 ? "add process noise or narrow the prior"
                 : "use filter: partially_linear_ukf_square_root, add process noise or narrow the prior";
    case FilterOutcome::innovation_not_positive_definite:
      return "give every sensor noise";
  }
  return "";
}

}  // namespace kalfem
