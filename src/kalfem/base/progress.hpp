// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// Called by long jobs with words for what is going on, "reference 3 of at most 7", and the fraction done of the job in
/// [0, 1], which never falls. May be empty.
using Progress = std::function<void(std::string_view words, double fraction)>;

/// For a part of a job that takes it from one fraction to another: 0 of the part is `from` of the whole, 1 is `to`.
/// Empty if `whole` is.
Progress part_of(const Progress& whole, double from, double to);

/// A step of a job, with the share of the job's time that it is expected to take, in any unit.
struct PlannedStep {
  std::string name;
  double share = 1.0;
};

/// A job of several steps, one after the other, that shows itself as a whole: "simulate (1 of 3): reference 3 of at
/// most 7" and the fraction done of all steps.
class JobProgress {
public:
  /// Nothing is shown if `show` is empty.
  JobProgress(std::vector<PlannedStep> plan, Progress show);

  /// Begins a step of the plan, and shows that. The progress of its job, valid as long as this object lives.
  Progress begin(const std::string& step);

private:
  void show(const std::string& words, double fraction);

  std::vector<PlannedStep> plan_;
  Progress show_;
  double shown_ = 0.0;  ///< the largest fraction
};

/// A job whose number of passes is not known: each is expected to take half of what is left. A pass ends where the next
/// one begins, with a smaller fraction: "filter pass 2".
Progress passes_of(const Progress& whole, const std::string& name);

}  // namespace kalfem
