// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "identification/imperfect_sensors.hpp"
#include "identification/linear_record.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/refined_filter.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Rounding of the filter, of the dense factor, and of two matrix exponentials.
constexpr double rounding = 1e-8;

const std::vector<std::string> linear_names{"frame.1.mass", "frame.b.stiffness", "frame.a.damping", "gain",
                                            "noise",        "density",           "offset"};

VectorXd values_of(const LinearNumbers& numbers) {
  return VectorXd{{numbers.lower_mass, numbers.upper_stiffness, numbers.lower_damping, numbers.gain, numbers.noise,
                   numbers.density, numbers.offset}};
}

void expect_relatively_near(double value, double expected, double tolerance) {
  EXPECT_NEAR(value, expected, tolerance * std::abs(expected));
}

TEST(FilterLikelihood, OfALinearStructureIsTheJointNormalDensityOfAllSamples) {
  const Record record = linear_record({}, 1, true);
  const FilterLikelihood likelihood(shared(linear_problem()), record, linear_names);
  EXPECT_EQ(likelihood.names(), linear_names);
  EXPECT_EQ(likelihood.first(), values_of({}));
  for (const auto& numbers : {LinearNumbers{},
                              {.lower_mass = 2.3, .upper_stiffness = 280.0, .lower_damping = 0.0},
                              {.gain = -1.2, .noise = 5e-3, .density = 0.5, .offset = 0.01}})
    expect_relatively_near(likelihood.log_likelihood(values_of(numbers)), dense_log_likelihood(numbers, record),
                           rounding);
}

// Some are named; the others keep their values in the structure, or stay in the state. The gain's density is the same
// in either unit.
TEST(FilterLikelihood, InnovationsGiveTheDensityOfEverySampleAsRecorded) {
  auto problem = linear_problem();
  problem.settings.unknowns.clear();
  const Record record = linear_record({}, 2, true);
  const FilterLikelihood likelihood(shared(problem), record, {"gain", "noise"});
  const VectorXd theta{{1.1, 3e-3}};
  const auto innovations = likelihood.innovations(theta);
  const auto densities = likelihood.log_densities(theta);
  ASSERT_TRUE(innovations && densities);
  for (Index k = 0; k < record.samples(); ++k) {
    double expected = 0.0;
    std::vector<Index> there;
    for (Index i = 0; i < 2; ++i)
      if (std::isfinite(record.values(i, k))) there.push_back(i);
    MatrixXd S(2, 2);
    S << innovations->covariance(0, k), innovations->covariance(1, k), innovations->covariance(1, k),
        innovations->covariance(2, k);
    if (!there.empty()) {
      const VectorXd v = innovations->value.col(k)(there);
      const MatrixXd own = S(there, there);
      expected = -0.5 * (v.dot(own.inverse() * v) + std::log(own.determinant()) +
                         static_cast<double>(there.size()) * std::log(2.0 * std::numbers::pi));
    }
    EXPECT_NEAR((*densities)[k], expected, 1e-9 * (1.0 + std::abs(expected))) << k;
    for (Index i = 0; i < 2; ++i)
      EXPECT_EQ(std::isfinite(innovations->value(i, k)), std::isfinite(record.values(i, k)));
  }
}

TEST(FilterLikelihood, WithNothingNamedIsThatOfTheEstimation) {
  auto problem = chain_problem();
  problem.settings.estimate_initial_state = true;  // constants beside the state: they change no prediction
  const auto given = shared(problem);
  const Record record = chain_record(problem, 1.0);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
  issues.raise();
  const auto estimated = run_refined_filter(given, setup, record, {}).filtered.result;
  const FilterLikelihood likelihood(given, record, {});
  expect_relatively_near(likelihood.log_likelihood(VectorXd()), estimated.log_likelihood, rounding);
}

// The filter keeps a damping ratio of the linear part among its unknowns, about which it relinearises.
TEST(FilterLikelihood, NamedValuesAreThoseOfTheStructure) {
  auto problem = chain_problem();
  problem.settings.substeps = 4;
  problem.settings.unknowns.push_back(unknown(*problem.structure, "body.damping.modal", 0.02, 0.01));
  const Record record = chain_record(problem, 1.0);
  problem.settings.unknowns.push_back(unknown(*problem.structure, "body.3-4.stiffness", body_stiffness, 3e3));
  const FilterLikelihood likelihood(shared(problem), record, {"suspension.mu_k1", "body.3-4.stiffness"});
  const VectorXd theta{{17.0, 2.8e4}};

  auto other = problem;
  StructureParts parts = chain_parts();
  set_parameter(parts, parameter(*problem.structure, "suspension.mu_k1"), theta[0]);
  set_parameter(parts, parameter(*problem.structure, "body.3-4.stiffness"), theta[1]);
  other.structure = chain_structure(parts);
  std::erase_if(other.settings.unknowns, [](const Unknown& each) {
    return each.name == "suspension.mu_k1" || each.name == "body.3-4.stiffness";
  });
  const auto given = shared(other);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
  issues.raise();
  const auto expected = run_filter(given, setup, record, {}).result;
  ASSERT_GT(expected.linearisations, 0);
  expect_relatively_near(likelihood.log_likelihood(theta), expected.log_likelihood, rounding);
}

// The error of a central difference falls with the square of its step, and rounding of a log-likelihood of 1e4 leaves
// 1e4 * 1e-13 / 1e-3 of it.
TEST(FilterLikelihood, IsSmooth) {
  auto problem = chain_problem();
  problem.settings.likelihood_unknowns = {unknown_delay("a6", 5e-4)};
  const Record record = chain_record(problem, 1.0);
  const FilterLikelihood likelihood(shared(problem), record,
                                    {"suspension.mu_k1", "suspension.mu_c1", "sensors.a6.delay"});
  const VectorXd theta{{18.0, 11.0, 1e-4}}, scale{{18.0, 11.0, 1e-3}};
  for (Index i = 0; i < theta.size(); ++i) {
    const auto slope = [&](double step) {
      const VectorXd move = step * scale[i] * VectorXd::Unit(theta.size(), i);
      return (likelihood.log_likelihood(theta + move) - likelihood.log_likelihood(theta - move)) / (2.0 * step);
    };
    expect_relatively_near(slope(1e-3), slope(2e-4), 1e-4);
  }
}

TEST(FilterLikelihood, ADelayIsMostLikelyWhereItIs) {
  auto problem = chain_problem();
  const Record record = faulty_record(problem, fine_chain_signals(problem, 1.0), {{}, {}, {.delay = 6}, {}}, 1);
  problem.settings.likelihood_unknowns = {unknown_delay("a6", 1e-3)};
  const FilterLikelihood likelihood(shared(problem), record, {"sensors.a6.delay"});
  const auto at = [&](double delay) { return likelihood.log_likelihood(VectorXd::Constant(1, delay)); };
  const double truth = 1.5e-3;  // its standard deviation is some hundredths of a sample
  EXPECT_GT(at(truth), at(truth - 2e-4) + 10.0);
  EXPECT_GT(at(truth), at(truth + 2e-4) + 10.0);
}

TEST(FilterLikelihood, OfImpossibleValuesIsNone) {
  const FilterLikelihood likelihood(shared(linear_problem()), linear_record({}, 1), linear_names);
  const auto none_at = [&](const LinearNumbers& numbers) {
    const VectorXd theta = values_of(numbers);
    return likelihood.log_likelihood(theta) == -infinity && !likelihood.innovations(theta);
  };
  EXPECT_TRUE(none_at({.lower_mass = -1.0}));
  EXPECT_TRUE(none_at({.lower_mass = 0.0}));
  EXPECT_TRUE(none_at({.upper_stiffness = -300.0}));
  EXPECT_TRUE(none_at({.upper_stiffness = infinity}));
  EXPECT_TRUE(none_at({.lower_damping = std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_TRUE(none_at({.gain = 0.0}));
  EXPECT_TRUE(none_at({.noise = -1e-3}));
  EXPECT_TRUE(none_at({.density = -0.2}));
  EXPECT_FALSE(none_at({}));
}

// A dashpot that drives the motion: nothing or a density, and no crash.
TEST(FilterLikelihood, OfAnUnstableStructureIsNoneOrSmall) {
  auto problem = chain_problem();
  problem.settings.unknowns.push_back(unknown(*problem.structure, "suspension.c", 10.0, 5.0));
  const FilterLikelihood likelihood(shared(problem), chain_record(problem, 1.0), {"suspension.c"});
  const double truth = likelihood.log_likelihood(VectorXd::Constant(1, 10.0));
  EXPECT_TRUE(std::isfinite(truth));
  for (const double damping : {-1e3, -1e5, -1e9, 1e12}) {
    const double there = likelihood.log_likelihood(VectorXd::Constant(1, damping));
    EXPECT_FALSE(std::isnan(there)) << damping;
    EXPECT_LT(there, truth) << damping;
  }
}

TEST(FilterLikelihood, SeveralThreadsAtOnceGiveTheSameBits) {
  const auto problem = chain_problem();
  const FilterLikelihood likelihood(shared(problem), chain_record(problem, 0.3), {"suspension.mu_k1"});
  const auto at = [&](int i) { return *likelihood.log_densities(VectorXd::Constant(1, 15.0 + i)); };
  std::vector<VectorXd> alone, together(6);
  for (int i = 0; i < 6; ++i) alone.push_back(at(i));
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 6; ++i) threads.emplace_back([&, i] { together[static_cast<std::size_t>(i)] = at(i); });
  }
  EXPECT_EQ(alone, together);
}

TEST(FilterLikelihood, SaysWhichNamesItCannotTake) {
  auto problem = linear_problem();
  problem.settings.unknowns.front().random_walk = 0.1;
  const Record record = linear_record({}, 1);
  const auto said = [&](const EstimationProblem& of, const std::vector<std::string>& names,
                        const FilterLikelihoodOptions& options = {}) {
    return refusal([&] { FilterLikelihood(shared(of), record, names, options); });
  };
  EXPECT_NE(said(problem, {"frame.b.stifness"}).find("frame.b.stiffness"), std::string::npos);
  EXPECT_NE(said(problem, {"gain", "gain"}).find("twice"), std::string::npos);
  EXPECT_NE(said(problem, {"frame.1.mass"}).find("drifts"), std::string::npos);
  EXPECT_NE(said(problem, {"gain"}, {.first = VectorXd::Zero(1)}).find("not possible"), std::string::npos);
  EXPECT_NE(said(problem, {"gain"}, {.first = VectorXd::Ones(2)}).find("2 first values"), std::string::npos);
  problem.settings.adaptive_noise.sensors = true;
  EXPECT_NE(said(problem, {"gain"}).find("adapt"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
