// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/remembered.hpp"

#include <algorithm>
#include <deque>
#include <mutex>
#include <utility>

namespace kalfem {
namespace {

using Eigen::Index;

constexpr Index shortest_call = 1000;      ///< below, a search costs as much as the samples
constexpr Index most_samples = 4'000'000;  ///< of all calls that are kept
constexpr std::size_t most_calls = 8;

class Remembered final : public Signal {
public:
  explicit Remembered(SignalPtr signal) : signal_(std::move(signal)) {}

  SignalSamples sample(double start, double step, Index count) const override {
    if (count < shortest_call || count > most_samples) return signal_->sample(start, step, count);
    const std::scoped_lock lock(guard_);  // a second thread waits for what the first one computes
    const auto known = std::ranges::find_if(calls_, [&](const Call& call) {
      return call.start == start && call.step == step && call.samples.rows() == count;
    });
    if (known != calls_.end()) return known->samples;
    SignalSamples samples = signal_->sample(start, step, count);
    keep({start, step, samples});
    return samples;
  }

  bool covers(double begin, double end) const override { return signal_->covers(begin, end); }
  double determined_until() const override { return signal_->determined_until(); }

private:
  struct Call {
    double start = 0.0, step = 0.0;
    SignalSamples samples;
  };

  /// In the place of the oldest calls.
  void keep(Call call) const {
    Index total = call.samples.rows();
    for (const auto& each : calls_) total += each.samples.rows();
    for (; !calls_.empty() && (total > most_samples || calls_.size() >= most_calls); calls_.pop_front())
      total -= calls_.front().samples.rows();
    calls_.push_back(std::move(call));
  }

  SignalPtr signal_;
  mutable std::mutex guard_;
  mutable std::deque<Call> calls_;  ///< the oldest first
};

}  // namespace

SignalPtr remembered(SignalPtr signal) { return std::make_shared<Remembered>(std::move(signal)); }

}  // namespace kalfem
