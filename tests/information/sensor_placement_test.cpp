// SPDX-License-Identifier: Apache-2.0
#include "kalfem/information/sensor_placement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

SensorCandidate seen_along(const std::string& name, double a, double b) {
  const Vector2d direction(a, b);
  return {name, {direction * direction.transpose()}};
}

/// Nearly parallel ones, and one across them.
std::vector<SensorCandidate> four() {
  return {seen_along("a", 3, 0), seen_along("b", 3, 0.1), seen_along("c", 0, 1), seen_along("d", 2.9, 0)};
}

TEST(SensorPlacement, RanksAllSetsByTheDeterminant) {
  const auto placement = place_sensors(four(), {.sensors = 2});
  EXPECT_TRUE(placement.exact);
  ASSERT_EQ(placement.sets.size(), 6U);
  // det(u u' + v v') = (u x v)^2: a or b with c, 9, before d with c, 2.9^2
  EXPECT_NEAR(placement.best().criterion, std::log(9.0), 1e-12);
  EXPECT_NEAR(placement.sets[1].criterion, std::log(9.0), 1e-12);
  EXPECT_EQ(placement.sets[2].candidates, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(placement.sets.back().candidates, (std::vector<std::size_t>{0, 3}));  // parallel
  EXPECT_EQ(placement.sets.back().criterion, -std::numeric_limits<double>::infinity());
}

TEST(SensorPlacement, ExchangeFindsTheBestOfManyAndThreadsDoNotMatter) {
  std::vector<SensorCandidate> many;
  for (int i = 0; i < 30; ++i)
    many.push_back(
        seen_along("s" + std::to_string(i), std::cos(0.7 * i) * (1 + i % 7), std::sin(0.7 * i) * (1 + i % 5)));
  for (const auto criterion :
       {PlacementCriterion::d_optimality, PlacementCriterion::a_optimality, PlacementCriterion::e_optimality}) {
    const auto exact = place_sensors(many, {.sensors = 3, .criterion = criterion});
    const auto searched = place_sensors(many, {.sensors = 3, .criterion = criterion, .most_sets = 10, .threads = 2});
    EXPECT_TRUE(exact.exact);
    EXPECT_FALSE(searched.exact);
    EXPECT_LT(searched.tried, exact.tried / 4);
    // An exchange may stop at a local optimum; here it finds the best. By the greedy set of the smallest eigenvalue
    // alone it stopped at 29.7 of 45.5.
    EXPECT_NEAR(searched.best().criterion, exact.best().criterion, 1e-9);
    const auto again = place_sensors(many, {.sensors = 3, .criterion = criterion, .most_sets = 10, .threads = 1});
    EXPECT_EQ(again.best().criterion, searched.best().criterion);
  }
}

TEST(SensorPlacement, HoldsFixedSensorsAndTakesASetFunction) {
  const auto candidates = four();
  const auto placement = place_sensors(candidates, {.sensors = 2, .fixed = {"d"}});
  EXPECT_EQ(placement.best().candidates, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(placement.tried, 3.0);
  const SetInformation none_with_a = [&](const auto& set) -> std::optional<std::vector<MatrixXd>> {
    if (set.front() == 0) return std::nullopt;
    MatrixXd sum = MatrixXd::Zero(2, 2);
    for (const auto i : set) sum += candidates[i].information[0];
    return std::vector{sum};
  };
  const auto by_sets = place_sensors(candidates, none_with_a, {.sensors = 2});
  EXPECT_EQ(by_sets.best().candidates, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(by_sets.failed, 3U);
}

TEST(SensorPlacement, CriteriaHaveTheirClosedForms) {
  const std::vector<MatrixXd> information = {Vector2d(4, 9).asDiagonal().toDenseMatrix()};
  SensorPlacementOptions options;
  const auto value = [&](PlacementCriterion criterion) {
    options.criterion = criterion;
    return placement_criterion(information, options);
  };
  EXPECT_NEAR(value(PlacementCriterion::d_optimality), std::log(36.0), 1e-12);
  EXPECT_NEAR(value(PlacementCriterion::a_optimality), -1.0 / 4 - 1.0 / 9, 1e-12);
  EXPECT_NEAR(value(PlacementCriterion::e_optimality), 4.0, 1e-12);
  options.parameters = {1};
  EXPECT_NEAR(value(PlacementCriterion::expected_deviation), -1.0 / 3, 1e-12);
  options.prior_deviation = VectorXd::Ones(2);
  EXPECT_NEAR(value(PlacementCriterion::mutual_information), 0.5 * std::log(5.0 * 10.0), 1e-12);
}

TEST(SensorPlacement, IsRobustOverParameterValues) {
  const auto at = [](double first, double second) {
    return std::vector<MatrixXd>{MatrixXd::Constant(1, 1, first), MatrixXd::Constant(1, 1, second)};
  };
  const std::vector<SensorCandidate> candidates = {{"brilliant once", at(10000, 1)}, {"always fair", at(50, 50)}};
  const auto best = [&](Robustness robustness) {
    return candidates[place_sensors(candidates, {.sensors = 1, .robustness = robustness}).best().candidates[0]].name;
  };
  EXPECT_EQ(best(Robustness::mean), "brilliant once");
  EXPECT_EQ(best(Robustness::worst_case), "always fair");
}

TEST(SensorPlacement, RefusesWhatCannotBePlaced) {
  const auto message = [](std::vector<SensorCandidate> candidates, const SensorPlacementOptions& options) {
    try {
      place_sensors(candidates, options);
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.issues().size(), 1U);
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message(four(), {.sensors = 5}).find("5 sensors of 4 candidates"), std::string::npos);
  EXPECT_NE(message(four(), {.sensors = 2, .fixed = {"x"}}).find("'x' is not a candidate"), std::string::npos);
  auto doubled = four();
  doubled[1].name = "a";
  EXPECT_NE(message(doubled, {.sensors = 2}).find("'a' is given twice"), std::string::npos);
  EXPECT_NE(message(four(), {.criterion = PlacementCriterion::mutual_information}).find("without a prior"),
            std::string::npos);
  EXPECT_NE(message({}, {.sensors = 1}).find("1 sensors of 0"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
