// SPDX-License-Identifier: Apache-2.0
// Cost of a record's marginal likelihood by the filter, as ratios within one run (medians of alternating repetitions):
//   one likelihood, its model made at new values and the record walked / one filter pass, predictions and updates
//   alone.
// Usage: likelihood_benchmark CHAIN.yaml, with `simulate` and `estimate`
#include <cstdio>
#include <vector>

#include "filter_walk.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/run_study.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::VectorXd;

constexpr int repetitions = 15;
constexpr std::size_t many = 100;         ///< likelihoods that two threads share
constexpr double asked = 1e4;             ///< that a sampler needs
constexpr double relative_spread = 0.01;  ///< of the values, so that every one is a new model

/// Values of the unknowns near the structure's own.
VectorXd values(const EstimationProblem& problem, std::size_t i) {
  VectorXd theta(std::ssize(problem.settings.unknowns));
  for (Index j = 0; j < theta.size(); ++j) {
    const auto& unknown = problem.settings.unknowns[static_cast<std::size_t>(j)];
    const double here = unknown.targets.front().value;
    theta[j] = here * (1.0 + relative_spread * (static_cast<double>(i % many) / static_cast<double>(many) - 0.5));
  }
  return theta;
}

/// The filter of the estimation, its unknowns in the state, on the record with inputs at the samples.
struct FilterPass {
  FilterPass(const Study& study, const Record& record, int substeps) : run(made(study, record, substeps)) {
    const auto stride = run.input.input_stride(substeps);
    at_samples = {run.input.measured, run.input.inputs(Eigen::all, Eigen::seq(0, Eigen::last, stride)),
                  run.input.noise};
    walk = std::make_unique<FilterWalk>(*run.choice.augmented_model, at_samples, run.choice.filter);
  }

  static FilterRun made(const Study& study, const Record& record, int substeps) {
    AugmentedModelSetup setup = *study.augmented_model;
    setup.options.substeps = substeps;
    return make_filter_run(study.problem, setup, record);
  }

  void operator()() const {
    walk->restart();
    while (!walk->at_end())
      if (!walk->step()) throw std::runtime_error("the filter failed");
  }

  FilterRun run;
  FilterInput at_samples;
  std::unique_ptr<FilterWalk> walk;
};

void time_likelihoods(const Study& study, const Record& record) {
  const auto& problem = study.problem;
  std::vector<std::string> names;
  for (const auto& unknown : problem->settings.unknowns) names.push_back(unknown.name);
  const FilterLikelihood likelihood(problem, record, names);
  const FilterPass of_one(study, record, 1), of_four(study, record, 4);
  std::printf("%d samples, %d states with the unknowns, %zu of which are named\n", static_cast<int>(record.samples()),
              static_cast<int>(of_one.run.choice.augmented_model->layout().size()), names.size());
  std::vector<double> likelihoods, single, four;
  for (std::size_t i = 0; i < repetitions; ++i) {
    likelihoods.push_back(seconds([&] { return likelihood.log_likelihood(values(*problem, i)); }));
    single.push_back(seconds([&] { of_one(); }));
    four.push_back(seconds([&] { of_four(); }));
  }
  line("one filter pass", 1e3 * median(single), "ms");
  line("one filter pass of four substeps", 1e3 * median(four), "ms");
  line("one likelihood", 1e3 * median(likelihoods), "ms");
  line("  ratio to a pass (at most 1.3)", median(likelihoods) / median(single), "");
  line("  ratio to one of four substeps", median(likelihoods) / median(four), "");
  const double together = seconds(
      [&] { for_each_index(many, 2, [&](std::size_t i) { (void)likelihood.log_likelihood(values(*problem, i)); }); });
  line("10,000 likelihoods on two threads (at most 10)", asked / static_cast<double>(many) * together / 60.0, "min");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: likelihood_benchmark CHAIN.yaml\n");
    return 2;
  }
  try {
    const Study chain = load_study(argv[1]);
    time_likelihoods(chain, record_of(chain, run_study(chain, "simulate")));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
