// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signal.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {

namespace {

// Signals are immutable and shared; a factor, a sum or a delay is a signal that asks others for their samples. A signal
// covers an interval where all that it is made of do.
class Scaled final : public Signal {
public:
  Scaled(SignalPtr signal, double factor) : signal_(std::move(signal)), factor_(factor) {}
  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    return factor_ * signal_->sample(start, step, count);
  }
  bool covers(double begin, double end) const override { return signal_->covers(begin, end); }
  double determined_until() const override { return signal_->determined_until(); }

private:
  SignalPtr signal_;
  double factor_;
};

class Sum final : public Signal {
public:
  explicit Sum(std::vector<SignalPtr> signals) : signals_(std::move(signals)) {}
  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    check_sampling(start, step, count);
    SignalSamples total = SignalSamples::Zero(count, 3);
    for (const auto& signal : signals_) total += signal->sample(start, step, count);
    return total;
  }
  bool covers(double begin, double end) const override {
    return std::ranges::all_of(signals_, [&](const auto& signal) { return signal->covers(begin, end); });
  }
  double determined_until() const override {
    double until = std::numeric_limits<double>::infinity();
    for (const auto& signal : signals_) until = std::min(until, signal->determined_until());
    return until;
  }

private:
  std::vector<SignalPtr> signals_;
};

class Delayed final : public Signal {
public:
  Delayed(SignalPtr signal, double delay) : signal_(std::move(signal)), delay_(delay) {}
  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    return signal_->sample(start - delay_, step, count);
  }
  bool covers(double begin, double end) const override { return signal_->covers(begin - delay_, end - delay_); }
  double determined_until() const override { return signal_->determined_until() + delay_; }

private:
  SignalPtr signal_;
  double delay_;
};

void require_signal(IssueList& issues, const SignalPtr& signal) {
  if (!signal) issues.add({}, "a signal is missing (null pointer)", "this signal modifies another one");
}

}  // namespace

// Times are start + k step, not a running sum: late samples of a long record would gather its rounding.
SignalSamples FormulaSignal::sample(double start, double step, Eigen::Index count) const {
  check_sampling(start, step, count);
  SignalSamples samples(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) samples.row(k) = at(start + static_cast<double>(k) * step);
  return samples;
}

// Every signal checks what it is asked for: samples from a start at equal steps, values with two derivatives in
// columns. A wrong step would otherwise show far from here, as a trajectory without meaning.
void check_sampling(double start, double step, Eigen::Index count) {
  IssueList issues;
  require_finite(issues, "start time of the samples", start);
  require_positive(issues, "time step of the samples", step);
  if (count < 0) issues.add({}, "number of samples is " + std::to_string(count), "it must be zero or positive");
  issues.raise();
}

SignalPtr scaled(SignalPtr signal, double factor) {
  IssueList issues;
  require_signal(issues, signal);
  require_finite(issues, "scale factor of a signal", factor);
  issues.raise();
  return std::make_shared<Scaled>(std::move(signal), factor);
}

SignalPtr sum(std::vector<SignalPtr> signals) {
  IssueList issues;
  for (const auto& signal : signals) require_signal(issues, signal);
  issues.raise();
  return std::make_shared<Sum>(std::move(signals));
}

SignalPtr delayed(SignalPtr signal, double delay) {
  IssueList issues;
  require_signal(issues, signal);
  require_finite(issues, "delay of a signal [s]", delay);
  issues.raise();
  return std::make_shared<Delayed>(std::move(signal), delay);
}

}  // namespace kalfem
