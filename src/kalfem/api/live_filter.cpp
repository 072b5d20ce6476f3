// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/live_filter.hpp"

#include "kalfem/api/online_problem.hpp"
#include "kalfem/live/sample_queue.hpp"
#include "kalfem/live/state_file.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::vector<OnlineInput> all_or_none(std::vector<OnlineInput> inputs) {
  const auto online = std::ranges::count_if(inputs, [](const auto& input) { return !input.signal; });
  if (online != 0 && online != std::ssize(inputs))
    throw InvalidInput("some inputs of the structure have a signal and some have none",
                       "a LiveFilter is told all of them, or none", "give no input a signal");
  return inputs;
}

}  // namespace

LiveFilter::LiveFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
                       const LiveOptions& live)
    : queue_(std::make_shared<SampleQueue>(online_problem(structure, sample_rate, options),
                                           all_or_none(online_inputs(structure)), live)),
      filter_(std::shared_ptr<OnlineSteps>(queue_, &queue_->steps())) {}
LiveFilter::LiveFilter(LiveFilter&&) noexcept = default;
LiveFilter& LiveFilter::operator=(LiveFilter&&) noexcept = default;
LiveFilter::~LiveFilter() = default;

Index LiveFilter::push(const std::string& channel, double time, const Eigen::Ref<const VectorXd>& values) {
  return queue_->push(channel, time, values);
}
Index LiveFilter::push(const std::string& channel, const Eigen::Ref<const VectorXd>& times,
                       const Eigen::Ref<const VectorXd>& values) {
  return queue_->push(channel, times, values);
}
Index LiveFilter::flush() { return queue_->flush(); }

OnlineFilter& LiveFilter::filter() { return filter_; }
Index LiveFilter::samples() const { return queue_->samples(); }
Index LiveFilter::dropped() const { return queue_->dropped(); }

void LiveFilter::write_state(const std::filesystem::path& file) const {
  write_state_file(file, queue_->fingerprint(), *queue_);
}
void LiveFilter::read_state(const std::filesystem::path& file) {
  read_state_file(file, queue_->fingerprint(), *queue_);
}

}  // namespace kalfem
