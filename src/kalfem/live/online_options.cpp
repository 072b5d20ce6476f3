// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/online_options.hpp"

#include <cmath>
#include <set>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

void check(const GateOptions& gates, IssueList& issues) {
  const auto require = [&](const char* name, double value, double least, double most, const char* why) {
    if (value >= least && value <= most) return;
    issues.add({}, std::string("gates.") + name + ": " + shortest(value), why,
               "give a number from " + shortest(least) + " to " + shortest(most));
  };
  constexpr double many = 1e7;
  require("limit", gates.limit, 3.0, 1e6, "good values reach 3 deviations once in 400");
  require("warm_up", gates.warm_up, 0, many, "so many samples are not gated");
  require("memory", gates.memory, 20, 1e5, "so many samples judge a channel");
  require("suspend_after", gates.suspend_after, 1, gates.memory, "so many of the memory put a channel out");
  require("stuck", gates.stuck, 3, gates.memory, "so many equal values put a channel out");
  require("patience", gates.patience, 1, many, "after so many samples the filter is at fault");
  require("inflation", gates.inflation, 1.0, 1e6, "deviations are multiplied by it");
  require("silence", gates.silence, 1, many, "so many samples without a value are silence");
  require("most_events", gates.most_events, 1, 1e6, "so many are kept");
}

void check(const ChangeOptions& changes, double step, IssueList& issues) {
  const auto require = [&](const char* name, double value, double least, double most, const char* why) {
    if (value >= least && value <= most) return;
    issues.add({}, std::string("changes.") + name + ": " + shortest(value), why,
               "give a number from " + shortest(least) + " to " + shortest(most));
  };
  require("window", changes.window, 10.0 * step, 1e8, "an estimate is formed of at least ten samples");
  require("reference", changes.reference, 2, 1e7, "so many windows say what changes are compared with");
  require("memory", changes.memory, 2, 1000, "a change that is not yet known began in one of so many windows");
  require("level", changes.level, 1e-9, 1e3, "smaller changes give no alarm");
  require("hysteresis", changes.hysteresis, 0.0, 1.0, "by this part of the level a change must fall below it");
  require("persistence", changes.persistence, 1, 1000, "so many windows in succession must show a change");
  require("false_alarms_every", changes.false_alarms_every, changes.window, 1e12,
          "it is the mean time between two false alarms");
  std::set<std::string> names;
  for (const auto& [name, effect] : changes.covariates) {
    if (!(effect > 0.0) || !std::isfinite(effect))
      issues.add({}, "changes.covariates." + name + ".effect: " + shortest(effect),
                 "it is the prior deviation of a relative change per unit", "give a number > 0");
    if (!names.insert(name).second)
      issues.add({}, "the covariate '" + name + "' is given twice", "", "remove one of them");
  }
}

}  // namespace

void check(const OnlineOptions& online, double step) {
  IssueList issues;
  if (online.input_delay < 0 || online.input_delay > 1000)
    issues.add({}, "input_delay: " + std::to_string(online.input_delay) + " samples",
               "the filter stays behind its inputs by that", "give a number from 0 to 1000; 8 is nearly exact");
  if (online.window < 100 || online.window > 10'000'000)
    issues.add({}, "window: " + std::to_string(online.window) + " samples",
               "the innovations of so many samples tell whether the filter is usable",
               "give a number from 100 to 10,000,000");
  if (online.lag < 0 || online.lag > 100'000)
    issues.add({}, "lag: " + std::to_string(online.lag) + " samples",
               "the smoothed estimates stay behind the filter by that", "give a number from 0, for none, to 100,000");
  if (online.gates) check(*online.gates, issues);
  if (online.changes) check(*online.changes, step, issues);
  issues.raise();
}

}  // namespace kalfem
