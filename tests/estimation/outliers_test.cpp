// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/chain_model.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Replaces a part of the samples by ones that lie `size` noise deviations away, on either side.
int add_outliers(FilterInput& record, double part, double size, std::uint64_t seed) {
  int count = 0;
  for (Index i = 0; i < record.measured.values.rows(); ++i) {
    RandomStream random(seed, "outliers " + std::to_string(i));
    for (Index k = 0; k < record.measured.samples(); ++k) {
      if (random.uniform() >= part) continue;
      record.measured.values(i, k) += (random.uniform() < 0.5 ? -size : size) * std::sqrt(record.noise(i, i));
      ++count;
    }
  }
  return count;
}

struct OutlierSetting {
  Chain chain;
  ConvergedSolution reference = chain.reference(3.0);
  AugmentedModelOptions options = [this] {
    auto all = chain.options();
    all.substeps = 4;
    return all;
  }();

  FilterInput record(std::uint64_t seed) const {
    auto record = Chain::record(reference, seed);
    record.inputs = chain.inputs(4 * Chain::rate, 4 * (reference.sensors.cols() - 1) + 1);
    return record;
  }
  EstimationResult run(const FilterInput& record, FilterKind filter, const OutlierOptions& outliers,
                       const std::vector<HeldOutSamples>& held_out = {}) const {
    AugmentedModelOptions own = options;
    if (filter == FilterKind::partially_linear) own.coordinates = StateCoordinates::modal;
    const AugmentedModel model(chain.model.system(), chain.sensors, {}, own);
    return estimate(model, record,
                    {.filter = filter, .state_deviations = false, .outliers = outliers, .held_out = held_out});
  }
};

double relative_error(const EstimationResult& result) {
  const VectorXd estimates = result.unknowns.mean.rightCols(1);
  return std::max(std::abs(estimates[0] / Chain::mu_k1 - 1.0), std::abs(estimates[1] / Chain::mu_c1 - 1.0));
}

const OutlierSetting& setting() {
  static const OutlierSetting one;
  return one;
}

class OutliersInEveryFilter : public testing::TestWithParam<FilterKind> {};

TEST_P(OutliersInEveryFilter, HardlyMoveTheEstimates) {
  auto record = setting().record(2);
  const double clean = relative_error(setting().run(record, GetParam(), {}));
  const int count = add_outliers(record, 0.05, 20.0, 2);
  const double spoilt = relative_error(setting().run(record, GetParam(), {}));
  EXPECT_GT(spoilt, 2.0 * clean);
  for (const auto treatment : {OutlierTreatment::gate, OutlierTreatment::robust}) {
    const auto result = setting().run(record, GetParam(), {treatment});
    ASSERT_FALSE(result.failure);
    EXPECT_LT(relative_error(result), 0.5 * spoilt);
    EXPECT_NEAR(static_cast<double>(result.set_aside.size()), count, 0.02 * count);
  }
}

TEST_P(OutliersInEveryFilter, WithoutOutliersTheGateChangesNothing) {
  const auto record = setting().record(3);
  const auto kept = setting().run(record, GetParam(), {}),
             gated = setting().run(record, GetParam(), {OutlierTreatment::gate});
  EXPECT_EQ(kept.unknowns.mean, gated.unknowns.mean);
  EXPECT_EQ(kept.nis, gated.nis);
  EXPECT_TRUE(gated.set_aside.empty());
}

TEST_P(OutliersInEveryFilter, SamplesHeldOutAreAsIfMissingAndPredicted) {
  auto record = setting().record(4);
  const auto held = setting().run(record, GetParam(), {}, {{1, 500, 1500}});
  record.measured.values.row(1).segment(500, 1000).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto missing = setting().run(record, GetParam(), {});
  EXPECT_LT((held.unknowns.mean - missing.unknowns.mean).norm(), 1e-9 * missing.unknowns.mean.norm());
  ASSERT_EQ(held.set_aside.size(), 1000u);
  double square = 0.0;
  for (const auto& each : held.set_aside) {
    EXPECT_EQ(each.channel, 1);
    EXPECT_FALSE(each.outlier);
    square += std::pow(each.innovation / each.deviation, 2) / 1000.0;
  }
  EXPECT_NEAR(square, 1.0, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Filters, OutliersInEveryFilter,
                         testing::Values(FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::extended,
                                         FilterKind::partially_linear, FilterKind::partially_linear_square_root));

TEST(OutlierWeight, IsOneNearThePredictionAndFallsBeyond) {
  EXPECT_EQ(outlier_weight({}, 100.0), 1.0);
  EXPECT_EQ(outlier_weight({OutlierTreatment::gate}, -5.9), 1.0);
  EXPECT_EQ(outlier_weight({OutlierTreatment::gate}, -6.1), 0.0);
  EXPECT_EQ(outlier_weight({OutlierTreatment::robust}, 1.0), 1.0);
  EXPECT_NEAR(outlier_weight({OutlierTreatment::robust}, -20.0), 11.0 / 410.0, 1e-12);
}

}  // namespace
}  // namespace kalfem
