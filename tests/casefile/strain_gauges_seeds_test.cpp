// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iostream>
#include <map>

#include "base/places.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/steps/estimation/compute.hpp"
#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

// Strain of the vehicle's frame where no gauge is: errors and bands over roads and draws of the noise.

namespace kalfem::test {
namespace {

Study vehicle_on_road(int road) {
  std::vector<CaseChange> changes{{"simulate.duration", "5 s"}};
  for (int wheel = 1; wheel <= 4; ++wheel)
    changes.push_back(
        {"excitation.road_" + std::to_string(wheel) + ".random.seed", std::to_string(road) + std::to_string(wheel)});
  return load_study(source_folder() + "/examples/vehicle/strain.yaml", changes);
}

/// Puts another draw of the noise into the simulated record.
void draw_noise(const Study& study, std::uint64_t seed, SimulationOutcome& outcome) {
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    RandomStream random(seed, study.sensors[i].name);
    outcome.measurements.values.row(row) = outcome.reference.sensors.row(row);
    for (double& value : outcome.measurements.values.row(row))
      value += outcome.measurements.channels[i].noise * random.normal();
  }
}

TEST(VehicleStrain, LiesInItsBandOver20Records) {
  const int roads = 4, draws = 5;
  std::map<std::string, double> worst, covered;
  for (int road = 1; road <= roads; ++road) {
    const Study study = vehicle_on_road(road);
    StudyResults results = run_study(study, "simulate");
    ASSERT_TRUE(results.complete()) << results.failure;
    for (int draw = 1; draw <= draws; ++draw) {
      draw_noise(study, static_cast<std::uint64_t>(draws * road + draw), results.get<SimulationOutcome>());
      auto setup = *study.augmented_model;
      const auto estimation = run_estimation(study, setup, results, {}, {}, {});
      ASSERT_FALSE(estimation.result.failure);
      for (const auto& gauge : study.report.strains) {
        const auto* strain = find_quantity(estimation.points, gauge, ObservedQuantity::strain);
        ASSERT_NE(strain, nullptr) << gauge;
        worst[gauge] = std::max(worst[gauge], strain->nrmse_in_band.value());
        covered[gauge] += strain->coverage.value() / (roads * draws);
      }
    }
  }
  ASSERT_EQ(worst.size(), 5u);
  double mean = 0.0;
  for (const auto& [gauge, error] : worst) {
    std::cout << gauge << ": NRMSE in band at most " << error << ", truth in the 95 % band " << covered[gauge] << "\n";
    EXPECT_LT(error, 0.03) << gauge;
    mean += covered[gauge] / static_cast<double>(worst.size());
  }
  EXPECT_GT(mean, 0.90);
  EXPECT_LT(mean, 0.99);
}

}  // namespace
}  // namespace kalfem::test
