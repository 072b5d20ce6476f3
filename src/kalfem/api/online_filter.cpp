// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/online_filter.hpp"

#include "kalfem/api/online_problem.hpp"
#include "kalfem/live/state_file.hpp"

namespace kalfem {

using Eigen::VectorXd;

OnlineFilter::OnlineFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
                           const OnlineOptions& online)
    : steps_(std::make_shared<OnlineSteps>(online_problem(structure, sample_rate, options), online_inputs(structure),
                                           online)) {}
OnlineFilter::OnlineFilter(OnlineFilter&&) noexcept = default;
OnlineFilter& OnlineFilter::operator=(OnlineFilter&&) noexcept = default;
OnlineFilter::~OnlineFilter() = default;

void OnlineFilter::start(const std::vector<InputSample>& inputs) { steps_->start(inputs); }
void OnlineFilter::start(const VectorXd& values) { steps_->start(values); }
bool OnlineFilter::predict(const std::vector<InputSample>& inputs) { return steps_->predict(inputs); }
bool OnlineFilter::predict() { return steps_->predict(); }
bool OnlineFilter::predict_values(const VectorXd& values) { return steps_->predict_values(values); }
bool OnlineFilter::update(const VectorXd& measured) { return steps_->update(measured); }
bool OnlineFilter::finish() { return steps_->finish(); }

bool OnlineFilter::in_physical_coordinates() const { return steps_->loop().in_physical_coordinates(); }
double OnlineFilter::time() const { return steps_->loop().time(); }
const std::optional<FilterStop>& OnlineFilter::failure() const { return steps_->loop().failure(); }
const Verdict& OnlineFilter::verdict() const { return steps_->loop().verdict(); }
ConsistencySummary OnlineFilter::consistency() const { return steps_->loop().consistency(); }

FilterCondition OnlineFilter::condition() const { return steps_->loop().condition(); }
SpanHealth OnlineFilter::health(HealthSpan span) const { return steps_->loop().health(span); }

std::vector<FilterEvent> OnlineFilter::events() const {
  const auto& kept = steps_->loop().log().events();
  return {kept.begin(), kept.end()};
}

void OnlineFilter::covariate(const std::string& name, double time, double value) {
  auto* monitor = steps_->monitor();
  const auto found = monitor ? monitor->find(name) : std::nullopt;
  if (!found) throw InvalidInput("the filter has no covariate '" + name + "'", "", "name it in OnlineOptions::changes");
  monitor->add(*found, time, value);
}

std::vector<Alarm> OnlineFilter::alarms() const {
  const auto* monitor = steps_->monitor();
  if (!monitor) return {};
  return {monitor->alarms().begin(), monitor->alarms().end()};
}

std::vector<ParameterChange> OnlineFilter::changes() const {
  return steps_->monitor() ? steps_->monitor()->present_changes() : std::vector<ParameterChange>{};
}

std::vector<ParameterDay> OnlineFilter::trend() const {
  return steps_->monitor() ? steps_->monitor()->trend() : std::vector<ParameterDay>{};
}

std::vector<ParameterEstimate> OnlineFilter::parameters() const {
  std::vector<ParameterEstimate> all;
  for (std::size_t i = 0; i < steps_->loop().unknowns(); ++i) {
    const auto now = steps_->loop().parameter(i);
    all.push_back(
        {.name = now.name, .unit = now.unit, .mean = now.mean, .std = now.std, .interval_95 = {now.lower, now.upper}});
  }
  return all;
}

PresentEstimate OnlineFilter::parameter(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& each : parameters()) {
    if (each.name == name) return {each.mean, each.std};
    known.push_back(each.name);
  }
  throw InvalidInput("the filter has no parameter '" + name + "'" + did_you_mean(name, known), "", "");
}

PresentEstimate OnlineFilter::state(const std::string& name) { return steps_->loop().observe(name); }
std::optional<SmoothedEstimate> OnlineFilter::smoothed() { return steps_->loop().smoothed(); }
const VectorXd& OnlineFilter::innovation() const { return steps_->loop().innovation(); }
double OnlineFilter::nis() const { return steps_->loop().nis(); }

void OnlineFilter::write_state(const std::filesystem::path& file) const {
  write_state_file(file, steps_->fingerprint(), *steps_);
}
void OnlineFilter::read_state(const std::filesystem::path& file) {
  read_state_file(file, steps_->fingerprint(), *steps_);
}

}  // namespace kalfem
