// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "kalfem/formats/tables/frf_table.hpp"
#include "kalfem/updating/frf_residual.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "updating/chain_model.hpp"

// The measured 3 x 3 accelerance of a three-storey aluminium frame against a chain of three masses whose storeys are
// those of beam theory: four clamped legs 25 x 3 mm, 153.3 mm long.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using test::ChainModel;
using Kind = ChainModel::Kind;

constexpr double storey_mass = 5.201;
const std::vector<std::string> floors = {"floor1", "floor2", "floor3"};

std::filesystem::path folder() { return data_folder("southampton-3storey"); }

double stiffness_of_beam_theory() {
  const double inertia = 0.025 * std::pow(0.003, 3) / 12.0;
  return 4.0 * 12.0 * 70e9 * inertia / std::pow(0.1533, 3);
}

std::vector<MeasuredFrf> measured_frfs() {
  std::vector<MeasuredFrf> measured;
  for (const std::string name : {"frf_Experimental.csv", "frf_test_2.csv", "frf_test_3.csv"})
    measured.push_back({name, read_frf_table(folder() / name), {FrfInput::force, floors[measured.size()], floors}});
  return measured;
}

/// Storey stiffnesses and, last, damping ratios as parameters.
std::shared_ptr<ChainModel> frame(std::size_t ratios) {
  auto chain = std::make_shared<ChainModel>();
  chain->masses.assign(3, storey_mass);
  chain->stiffnesses.assign(3, stiffness_of_beam_theory());
  chain->ratios.assign(ratios, 0.002);
  for (std::size_t i = 0; i < 3; ++i) chain->parameters.push_back({Kind::stiffness, {i}});
  for (std::size_t i = 0; i < ratios; ++i) chain->parameters.push_back({Kind::ratio, {i}});
  return chain;
}

std::vector<UpdatingParameter> parameters_of(const ChainModel& chain) {
  std::vector<UpdatingParameter> parameters;
  for (const double stiffness : chain.stiffnesses)
    parameters.push_back({"storey" + std::to_string(parameters.size() + 1), "N/m", stiffness, 2e4, 1e5});
  for (const double ratio : chain.ratios) parameters.push_back({"ratio", "", ratio, 2e-4, 2e-2});
  return parameters;
}

LeastSquaresOutcome update(const std::shared_ptr<ChainModel>& chain, const FrfResidualOptions& options,
                           const std::vector<double>& widths) {
  const auto parameters = parameters_of(*chain);
  LeastSquaresOutcome outcome;
  outcome.parameters = initial_values(parameters);
  for (const double width : widths) {
    FrfResidualOptions at_width = options;
    at_width.smoothing = width;
    const FrfResidual residual(chain, measured_frfs(), outcome.parameters, at_width);
    outcome = minimise(residual, parameters, {.search = {}, .start = outcome.parameters, .watch = {}});
    EXPECT_TRUE(outcome.usable()) << outcome.reason();
  }
  return outcome;
}

VectorXd frequencies_of(const ChainModel& chain, const VectorXd& values) {
  const auto model = chain.at(values).model;
  return normal_modes(model.mass, model.stiffness).frequencies;
}

/// Standard deviations with the residual's own scatter.
VectorXd deviations_of(const LeastSquaresOutcome& outcome) {
  const auto& [values, jacobian] = outcome.residual;
  const double scatter = values.squaredNorm() / double(values.size() - jacobian.cols());
  return (scatter * (jacobian.transpose() * jacobian).inverse()).diagonal().cwiseSqrt();
}

class Southampton : public testing::Test {
protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder() / "frf_Experimental.csv"))
      KALFEM_ABSENT("the measured FRFs are not at " + folder().string() + "; set KALFEM_DATA to their parent folder");
  }
};

// Which file is which floor: the FRFs of a pair of floors are the same both ways, and the first mode grows upwards.
TEST_F(Southampton, FilesAreTheFloorsFromBelow) {
  const auto measured = measured_frfs();
  const auto rows = Eigen::seq(100, 1000);  // 3.2 ... 31 Hz
  for (Index i = 0; i < 3; ++i)
    for (Index j = 0; j < i; ++j) {
      const auto one = measured[std::size_t(i)].response.values(rows, j),
                 other = measured[std::size_t(j)].response.values(rows, i);
      EXPECT_LT((one - other).norm(), 0.07 * one.norm()) << i << j;  // calibrations of the three runs differ
    }
  const Index first_mode = 207;  // 6.5 Hz
  ASSERT_NEAR(measured[0].response.lines[first_mode], 6.5, 1e-9);
  const VectorXd shape = measured[2].response.values.row(first_mode).cwiseAbs();
  EXPECT_LT(shape[0], shape[1]);
  EXPECT_LT(shape[1], shape[2]);
  // Far above its modes a floor moves as a free mass; storeys still add up to 2 k / (m omega^2) = 6 % at 85 Hz.
  for (Index i = 0; i < 3; ++i) {
    const double inertance = measured[std::size_t(i)].response.values(Eigen::seq(2500, 3000), i).real().mean();
    // calibrations differ by 5 %
    EXPECT_NEAR(inertance * storey_mass, 1.06, 0.07) << i;
  }
}

TEST_F(Southampton, PeaksAgreeAmongTheRuns) {
  EXPECT_NEAR(stiffness_of_beam_theory(), 52.5e3, 50.0);  // three digits
  const std::vector<double> expected = {6.514, 17.464, 26.506};
  for (const auto& frf : measured_frfs()) {
    const auto peaks = find_peaks(frf.response, {.band = {3.0, 60.0}});
    ASSERT_EQ(peaks.size(), 3u) << frf.name;
    for (std::size_t i = 0; i < 3; ++i) {
      // peaks of the runs differ by 1 mHz and .0005
      EXPECT_NEAR(peaks[i].frequency, expected[i], 0.002) << frf.name;
      EXPECT_NEAR(peaks[i].damping.value_or(0.0), 0.002, 0.0006) << frf.name;
    }
  }
}

TEST_F(Southampton, StoreysAreFoundFromBeamTheory) {
  const auto peaks = find_peaks(measured_frfs()[0].response, {.band = {3.0, 60.0}});
  ASSERT_EQ(peaks.size(), 3u);
  for (const std::size_t ratios : {1u, 3u})
    for (const FrfForm form : {FrfForm::log, FrfForm::log_magnitude, FrfForm::complex_difference}) {
      const auto chain = frame(ratios);
      const auto outcome = update(chain, {.form = form, .bands = {{4.0, 32.0}}}, smoothing_widths(2.0, 0.2));
      const VectorXd frequencies = frequencies_of(*chain, outcome.parameters);
      for (std::size_t i = 0; i < 3; ++i)
        // a fit of all lines and the peak differ by 9e-4
        EXPECT_NEAR(frequencies[Index(i)] / peaks[i].frequency, 1.0, 0.002) << ratios << int(form);
      // forms and numbers of ratios differ by 60 to 90 N/m
      EXPECT_NEAR(outcome.parameters[0], 42.7e3, 200.0);
      EXPECT_NEAR(outcome.parameters[1], 48.4e3, 200.0);
      EXPECT_NEAR(outcome.parameters[2], 38.0e3, 200.0);
      const VectorXd deviations = deviations_of(outcome);
      for (Index i = 0; i < 3; ++i) {
        EXPECT_GT(deviations[i], 1.0);
        EXPECT_LT(deviations[i], 30.0);
      }
      for (Index i = 3; i < outcome.parameters.size(); ++i) {
        EXPECT_GT(outcome.parameters[i], 0.001);
        EXPECT_LT(outcome.parameters[i], 0.004);
      }
    }
}

}  // namespace
}  // namespace kalfem
