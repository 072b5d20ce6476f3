// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/chain_structure.hpp"

namespace kalfem::test {
namespace {

FilterAttempt failed(FilterKind filter, StateCoordinates coordinates,
                     FilterOutcome outcome = FilterOutcome::covariance_not_positive_definite) {
  return {filter, coordinates, EstimationFailure{.outcome = outcome}};
}

std::vector<std::string> forms(const std::vector<FilterAttempt>& attempts) {
  std::vector<std::string> all;
  for (const auto& [filter, coordinates, failure] : attempts)
    all.push_back(to_string(filter) + (coordinates == StateCoordinates::modal ? " modal" : " physical"));
  return all;
}

using Forms = std::vector<std::string>;

TEST(FilterAttempts, AreFormsOfTheSameFilterThatLoseFewerDigits) {
  EXPECT_EQ(forms(attempts_after(failed(FilterKind::partially_linear, StateCoordinates::modal), false)),
            (Forms{"partially_linear_ukf physical", "partially_linear_ukf_square_root physical"}));
  EXPECT_EQ(forms(attempts_after(failed(FilterKind::partially_linear, StateCoordinates::physical), false)),
            Forms{"partially_linear_ukf_square_root physical"});
}

/// Coordinates are not what the user chose; the kind of filter is.
TEST(FilterAttempts, KeepTheKindThatWasAskedFor) {
  EXPECT_EQ(forms(attempts_after(failed(FilterKind::partially_linear, StateCoordinates::modal), true)),
            Forms{"partially_linear_ukf physical"});
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::extended})
    EXPECT_EQ(forms(attempts_after(failed(kind, StateCoordinates::physical), true)), Forms{});
}

TEST(FilterAttempts, AreNotMadeWhereNoFormHelps) {
  for (const auto outcome : {FilterOutcome::model_not_evaluable, FilterOutcome::linear_part_impossible})
    EXPECT_EQ(forms(attempts_after(failed(FilterKind::partially_linear, StateCoordinates::modal, outcome), false)),
              Forms{});
  EXPECT_EQ(forms(attempts_after({FilterKind::partially_linear, StateCoordinates::modal, {}}, false)), Forms{});
}

TEST(FilterAttempts, OfARunThatSucceedsAreOne) {
  const auto problem = shared(chain_problem());
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  const auto filtered = run_filter(problem, setup, chain_record(*problem, 0.2), {});
  EXPECT_EQ(forms(filtered.attempts), Forms{"partially_linear_ukf modal"});
  EXPECT_FALSE(filtered.attempts.front().failure);
}

}  // namespace
}  // namespace kalfem::test
