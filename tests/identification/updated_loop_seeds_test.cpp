// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>

#include "identification/updated_loop.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/parameter_interval.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/robust_statistics.hpp"

// Intervals of the multi-stage loop over many seeds of the noise. KALFEM_LOOP_SEEDS: another number of them.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// What one seed gave: of three updated parameters and the mounts' six.
struct Seed {
  int updated_true = 0, mounts_true = 0;
  bool usable = false;
  double rms = 0.0;
  Eigen::Array3d error;  ///< in stated standard deviations
};

/// Intervals of the mounts that hold the truth, by the filter with the updated structure.
int true_mounts(const EstimationProblemPtr& problem, const Record& record, const VectorXd& updated) {
  const auto setup = loop_setup(*problem->structure);
  const StructureParts parts = ParameterisedStructure(problem->structure, setup.bindings, 3).at(updated).parts;
  IssueList issues;
  auto model = make_augmented_model_setup(*problem, parts, present_values(setup, updated), issues);
  issues.raise();
  const auto result = run(make_filter_run(problem, model, record));
  const auto last = result.state.mean.cols() - 1;
  int count = 0;
  for (std::size_t i = 0; i < problem->settings.unknowns.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const double value = result.unknowns.mean(at, last), deviation = result.unknowns.deviation(at, last);
    count += std::abs(value - *problem->settings.unknowns[i].truth) <= 1.96 * deviation;
  }
  return count;
}

Seed seed_of(const EstimationProblemPtr& problem, const Eigen::MatrixXd& accelerations, std::uint64_t number) {
  const auto parameters = loop_setup(*problem->structure).parameters;
  const auto record = loop_record(*problem, accelerations, number);
  const auto residual = loop_residual(problem, record);
  const auto found = minimise(residual, parameters, {.search = {.max_evaluations = 100, .cost_floor = 1e-6}});
  const auto stated = parameter_statistics(parameters, found.parameters, found.residual);
  const auto robust =
      robust_statistics(parameters, found.residual, {{"record", 0, residual.size(), residual.layout()}}, stated);
  Seed seed{.usable = found.usable(),
            .rms = std::sqrt(found.residual.values.squaredNorm() / static_cast<double>(residual.size()))};
  for (Index i = 0; i < 3; ++i) {
    const auto interval =
        parameter_interval(parameters[static_cast<std::size_t>(i)], i, found.parameters[i], stated, robust);
    seed.updated_true += interval && interval->lower <= loop_truth()[i] && loop_truth()[i] <= interval->upper;
    seed.error[i] = (found.parameters[i] - loop_truth()[i]) / stated.deviations[i];
  }
  seed.mounts_true = true_mounts(problem, record, found.parameters);
  return seed;
}

/// Whether so many of `count` events of probability 0.95 lie in the 99 % range of the binomial distribution.
bool in_binomial_range(int hits, int count) {
  const auto tail = [&](auto within) {
    double sum = 0.0, term = std::pow(0.95, count);  // of k hits, from all down: none is too rare to be a number
    for (int k = count; k >= 0; --k) {
      if (within(k)) sum += term;
      term *= k / (19.0 * (count - k + 1.0));
    }
    return sum;
  };
  return tail([&](int k) { return k <= hits; }) >= 0.005 && tail([&](int k) { return k >= hits; }) >= 0.005;
}

TEST(UpdatedLoopOverSeeds, IntervalsHoldTheTruthAsOftenAsTheySay) {
  const char* asked = std::getenv("KALFEM_LOOP_SEEDS");
  const int seeds = asked ? std::atoi(asked) : 45;
  const double duration = 10.0;
  const auto problem = shared(loop_problem(duration, 0.15));
  const auto accelerations = LoopSimulator(problem->structure, duration).run();
  int updated = 0, mounts = 0, usable = 0;
  Eigen::Array3d squares = Eigen::Array3d::Zero(), sum = squares;
  for (int number = 1; number <= seeds; ++number) {
    const Seed seed = seed_of(problem, accelerations, static_cast<std::uint64_t>(number));
    updated += seed.updated_true;
    mounts += seed.mounts_true;
    usable += seed.usable;
    squares += seed.error.square();
    sum += seed.error;
    std::cout << number << ": residual " << seed.rms << ", errors / deviations " << seed.error.transpose() << ", "
              << seed.mounts_true << " of 6 mounts" << std::endl;
    EXPECT_NEAR(seed.rms, 1.0, 0.05);
  }
  const double count = seeds;
  std::cout << "converged " << usable << " of " << seeds << "; updated " << updated << " of " << 3 * seeds
            << "; mounts " << mounts << " of " << 6 * seeds << "; rms of errors / deviations "
            << (squares / count).sqrt().transpose() << ", mean " << (sum / count).transpose() << std::endl;
  EXPECT_EQ(usable, seeds);
  EXPECT_TRUE(in_binomial_range(updated, 3 * seeds)) << updated;
  EXPECT_TRUE(in_binomial_range(updated + mounts, 9 * seeds)) << updated + mounts;
}

}  // namespace
}  // namespace kalfem::test
