// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/mode_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/modal/modal_result.hpp"
#include "kalfem/report/modal_report.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using testing::ElementsAre;
using testing::HasSubstr;

ModalResult two_modes() {
  ModalResult result{.channels = {"a1", "a2"}, .units = {"m/s^2", "m/s^2"}, .references = {"a1"}};
  for (const double frequency : {3.25, 7.5}) {
    IdentifiedMode mode{.frequency = frequency, .damping = 0.0125, .covariance = {}, .degrees_of_freedom = 40.0};
    mode.covariance << 1e-4, 1e-6, 1e-6, 4e-6;
    mode.shape = Eigen::Vector2cd(1.0, Complex(-0.5, 0.01));
    mode.shape_covariance = 1e-4 * Eigen::Matrix4d::Identity();
    mode.shape_covariance(1, 3) = mode.shape_covariance(3, 1) = frequency * 1e-6;
    result.modes.push_back(mode);
  }
  return result;
}

TEST(ModeFile, ReadsWhatModalWrites) {
  const ScratchFolder folder("mode-file");
  const auto result = two_modes();
  write_modal_files(folder.path(), "record.csv", result, {{.node = 4, .direction = 3}, {.node = 7, .direction = -1}});
  const auto read = read_modes(folder.path() / "modes.json"), expected = mode_set(result);
  EXPECT_EQ(read.points, expected.points);
  ASSERT_EQ(read.modes.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.modes[i].frequency, expected.modes[i].frequency);
    EXPECT_EQ(read.modes[i].frequency_std, 0.01);
    EXPECT_EQ(read.modes[i].damping_std, 0.002);
    EXPECT_EQ(read.modes[i].degrees_of_freedom, 40.0);
    EXPECT_EQ(read.modes[i].shape, expected.modes[i].shape);
    EXPECT_EQ(read.modes[i].shape_covariance, expected.modes[i].shape_covariance);
  }
  const auto universal = read_modes(folder.path() / "modes.unv");
  EXPECT_THAT(universal.points, ElementsAre("4:+Z", "7:+X"));
  EXPECT_NEAR(universal.modes[1].frequency, 7.5, 1e-5);  // six digits of an eigenvalue
  EXPECT_NEAR(universal.modes[1].damping, 0.0125, 1e-7);
  EXPECT_TRUE(std::isnan(universal.modes[1].frequency_std));
  EXPECT_EQ(universal.modes[1].shape[1], Complex(0.5, -0.01));  // a channel against x
}

/// A direction without motion in every mode is no point; a node that is missing in one mode is not measured there.
TEST(ModeFile, TakesZerosAndAbsentNodesOfUniversalFilesForNotMeasured) {
  MeasuredFile file;
  file.nodes = {{1, {0, 0, 0}}, {2, {1, 0, 0}}};
  MeasuredShape first{.name = "one", .frequency = 4.0, .nodes = {1, 2}, .values = Eigen::MatrixXcd::Zero(2, 3)};
  first.values(0, 2) = 1.0;
  first.values(1, 2) = -0.5;
  MeasuredShape second{.name = "two", .frequency = 9.0, .nodes = {2}, .values = Eigen::MatrixXcd::Zero(1, 3)};
  second.values(0, 0) = Complex(0.25, 0.5);
  file.shapes = {first, second, {.name = "load", .nodes = {1}, .values = Eigen::MatrixXcd::Ones(1, 3)}};
  const ScratchFolder folder("mode-file");
  write_universal(folder.path() / "test.unv", file);
  const auto set = read_modes(folder.path() / "test.unv");
  EXPECT_THAT(set.points, ElementsAre("1:+Z", "2:+X", "2:+Z"));
  ASSERT_EQ(set.modes.size(), 2U);
  EXPECT_EQ(set.nodes.size(), 2U);
  EXPECT_EQ(set.modes[0].shape[0], 1.0);
  EXPECT_EQ(set.modes[0].shape[1], 0.0);  // measured, as the second mode moves it
  EXPECT_TRUE(std::isnan(set.modes[1].shape[0].real()));
  EXPECT_EQ(set.modes[1].shape[1], Complex(0.25, 0.5));
  EXPECT_TRUE(std::isnan(set.modes[0].damping));
}

TEST(ModeFile, RefusesOtherFiles) {
  const ScratchFolder folder("mode-file");
  const auto refused = [&](const std::string& name, const std::string& text) -> std::string {
    std::ofstream(folder.path() / name) << text;
    try {
      read_modes(folder.path() / name);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refused("broken.json", "{\"channels\": ["), HasSubstr("is not modes.json of `kalfem modal`"));
  EXPECT_THAT(refused("other.json", "{\"channels\": [\"a\"], \"modes\": [{\"shape\": 3}]}"),
              HasSubstr("is not modes.json"));
  EXPECT_THAT(refused("none.json", "{\"channels\": [\"a\"], \"modes\": []}"), HasSubstr("holds no modes"));
  EXPECT_THAT(refused("table.csv", "t [s],a\n0,1\n1,2\n2,3\n"), HasSubstr("holds no modes"));
}

}  // namespace
}  // namespace kalfem
