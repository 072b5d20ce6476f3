// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/progress.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kalfem {

Progress part_of(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [=](std::string_view words, double fraction) { whole(words, from + (to - from) * fraction); };
}

JobProgress::JobProgress(std::vector<PlannedStep> plan, Progress show)
    : plan_(std::move(plan)), show_(std::move(show)) {}

Progress JobProgress::begin(const std::string& step) {
  const auto at = std::ranges::find(plan_, step, &PlannedStep::name);
  if (!show_ || at == plan_.end()) return {};
  const auto shares = [](auto first, auto last) {
    return std::accumulate(first, last, 0.0, [](double sum, const PlannedStep& each) { return sum + each.share; });
  };
  const double all = shares(plan_.begin(), plan_.end()), before = shares(plan_.begin(), at);
  const std::string name = plan_.size() == 1 ? step
                                             : step + " (" + std::to_string(at - plan_.begin() + 1) + " of " +
                                                   std::to_string(plan_.size()) + ")";
  show(name, before / all);
  return [this, step, name, from = before / all, share = at->share / all](std::string_view words, double fraction) {
    show(words == step ? name : name + ": " + std::string(words), from + share * std::clamp(fraction, 0.0, 1.0));
  };
}

void JobProgress::show(const std::string& words, double fraction) {
  shown_ = std::max(shown_, fraction);
  show_(words, shown_);
}

Progress passes_of(const Progress& whole, const std::string& name) {
  if (!whole) return {};
  struct Passes {
    int number = 1;
    double fraction = 0.0;
  };
  return [=, passes = std::make_shared<Passes>()](std::string_view, double fraction) {
    if (fraction < passes->fraction) ++passes->number;
    passes->fraction = fraction;
    const double left = std::ldexp(1.0, 1 - passes->number);
    whole(name + " " + std::to_string(passes->number), 1.0 - left + 0.5 * left * fraction);
  };
}

}  // namespace kalfem
