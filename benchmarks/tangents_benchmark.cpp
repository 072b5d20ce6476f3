// SPDX-License-Identifier: Apache-2.0
// Cost of the score test of all numbers that an estimation of the chain holds fixed, as ratios of processor time to one
// filter pass (medians of alternating repetitions): the pass that keeps its gains, the run of the mean, the run with
// the tangents of all numbers, and a run of the mean beside one number, its model made anew.
#include <ctime>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/identification/runs_beside.hpp"
#include "kalfem/kalfem.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;

constexpr int repetitions = 9;
constexpr double duration = 20.0, sample_rate = 1000.0;  ///< [s], [Hz]

template <typename Work>
double processor_seconds(Work work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double begin = now();
  (void)work();
  return now() - begin;
}

/// The chain of the examples: a wheel on a road, a saturating suspension, ten masses.
Structure chain_on_a_road() {
  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  s.connect(
      "suspension", "wheel.w", "body.1",
      law("saturating", {{"k", 5e3}, {"mu_k1", 20.0}, {"mu_k2", 2e-3}, {"c", 10.0}, {"mu_c1", 10.0}, {"mu_c2", 0.05}}));
  s.base_displacement("road", "wheel.ground",
                      make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = duration, .seed = 7}));
  return s;
}

void time_study(int substeps, int order) {
  const Structure s = chain_on_a_road();
  EstimateOptions options{.unknowns = {{"suspension.mu_k1", {.initial = 19.0, .std = 1.0}},
                                       {"suspension.mu_c1", {.initial = 10.0, .std = 1.0}}},
                          .substeps = substeps,
                          .step_order = order};
  for (const char* point : {"2", "4", "6", "10"})
    options.sensors.push_back({std::string("a") + point, acceleration(std::string("body.") + point), 0.3});
  const Record record =
      simulate(s, {.sensors = options.sensors, .duration = duration, .sample_rate = sample_rate, .seed = 1}).record;
  const FilterProblem problem = make_filter_problem(s, sample_rate, options);
  const RecordEstimate start;
  const RecordEstimateOptions monitored;
  RunsBeside runs(problem.problem, problem.setup, record, start, monitored, {});
  const auto& run = runs.filter();
  const auto pass = [&](bool keep_gains, bool deviations = false) {
    return estimate(*run.choice.augmented_model, run.input,
                    {.filter = run.choice.filter,
                     .state_means = deviations,
                     .state_deviations = deviations,
                     .keep_gains = keep_gains});
  };
  const double count = static_cast<double>(runs.numbers().size());
  std::vector<double> passes, with_deviations, with_gains, base, tangents, beside;
  for (int i = 0; i < repetitions; ++i) {
    Gains gains;
    passes.push_back(processor_seconds([&] { return pass(false).log_likelihood; }));
    with_deviations.push_back(processor_seconds([&] { return pass(false, true).log_likelihood; }));
    with_gains.push_back(processor_seconds([&] {
      gains = pass(true).gains;
      return 0;
    }));
    base.push_back(processor_seconds([&] { return runs.run_base(gains); }));
    tangents.push_back(processor_seconds([&] {
      for (const auto& group : runs.groups()) (void)runs.derivatives(group);
      return 0;
    }));
    beside.push_back(0.5 * processor_seconds([&] { return runs.difference(0, 1e-4).has_value(); }));
  }
  const double one = median(passes);
  std::printf("%zu numbers, %d states, %d substeps of order %d\n", runs.numbers().size(),
              static_cast<int>(run.choice.augmented_model->layout().size()), substeps, order);
  line("one filter pass", 1e3 * one, "ms");
  line("  that keeps its gains", median(with_gains) / one, "passes");
  line("run of the mean", median(base) / one, "passes");
  line("tangents of all numbers", median(tangents) / one, "passes");
  const double study = median(with_gains) + median(base) + median(tangents);
  line("score test of all numbers (at most 4)", study / one, "passes");
  line("  to a pass with the deviations of all states", study / median(with_deviations), "passes");
  line("  by a run beside each number", (median(with_gains) + median(base) + count * median(beside)) / one, "passes");
}

}  // namespace

int main() {
  try {
    time_study(4, 2);
    time_study(1, 2);
    time_study(2, 4);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
