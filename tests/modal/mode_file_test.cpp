// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/mode_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "formats/universal_texts.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/modal/modal_result.hpp"
#include "kalfem/report/modal_report.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using testing::AllOf;
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

/// A matrix of MATLAB; complex where there is an imaginary part.
matvar_t* matrix(const char* name, const Eigen::MatrixXd& real, const Eigen::MatrixXd& imaginary = {}) {
  std::size_t lengths[] = {static_cast<std::size_t>(real.rows()), static_cast<std::size_t>(real.cols())};
  if (imaginary.size() == 0)
    return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, lengths, const_cast<double*>(real.data()), 0);
  mat_complex_split_t parts{const_cast<double*>(real.data()), const_cast<double*>(imaginary.data())};
  return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, lengths, &parts, MAT_F_COMPLEX);
}

matvar_t* cell(const char* name, const std::vector<std::string>& texts) {
  std::size_t lengths[] = {texts.size(), 1};
  matvar_t* all = Mat_VarCreate(name, MAT_C_CELL, MAT_T_CELL, 2, lengths, nullptr, 0);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::size_t length[] = {1, texts[i].size()};
    Mat_VarSetCell(all, static_cast<int>(i),
                   Mat_VarCreate(nullptr, MAT_C_CHAR, MAT_T_UINT8, 2, length, const_cast<char*>(texts[i].data()), 0));
  }
  return all;
}

std::filesystem::path write_matlab(const std::filesystem::path& path, mat_ft version,
                                   const std::vector<matvar_t*>& variables) {
  std::filesystem::remove(path);
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
  for (auto* each : variables) {
    Mat_VarWrite(file, each, MAT_COMPRESSION_NONE);
    Mat_VarFree(each);
  }
  Mat_Close(file);
  return path;
}

TEST(ModeFile, ReadsModesOfMatlab) {
  const ScratchFolder folder("mode-file");
  const Eigen::Matrix<double, 2, 2> real{{1.0, 0.5}, {-0.5, ModeSet::unknown}}, imaginary{{0.0, 0.1}, {0.02, 0.0}},
      deviations{{0.01, 0.02}, {0.03, 0.04}};
  for (const auto version : {MAT_FT_MAT5, MAT_FT_MAT73}) {
    const auto set = read_modes(write_matlab(
        folder.path() / "modes.mat", version,
        {matrix("frequencies", Eigen::RowVector2d(3.25, 7.5)), matrix("dampings", Eigen::Vector2d(0.01, 0.02)),
         matrix("shapes", real, imaginary), matrix("shape_std", deviations), cell("points", {"a1", "a2"})}));
    EXPECT_THAT(set.points, ElementsAre("a1", "a2"));
    ASSERT_EQ(set.modes.size(), 2U);
    EXPECT_EQ(set.modes[1].frequency, 7.5);
    EXPECT_EQ(set.modes[1].damping, 0.02);
    EXPECT_TRUE(std::isnan(set.modes[1].frequency_std));
    EXPECT_EQ(set.modes[0].shape[1], Complex(-0.5, 0.02));
    EXPECT_TRUE(std::isnan(set.modes[1].shape[1].real()) && std::isnan(set.modes[1].shape[1].imag()));
    EXPECT_NEAR(set.modes[0].shape_covariance(3, 3), 9e-4, 1e-18);
    EXPECT_EQ(set.modes[0].shape_covariance(0, 1), 0.0);
  }
}

TEST(ModeFile, TellsAllThatIsWrongWithAMatlabFile) {
  const ScratchFolder folder("mode-file");
  const auto refused = [&](const std::vector<matvar_t*>& variables) -> std::string {
    try {
      read_modes(write_matlab(folder.path() / "modes.mat", MAT_FT_MAT5, variables));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(
      refused({matrix("freq", Eigen::Vector2d(1, 2))}),
      AllOf(HasSubstr("modes.mat: there is no variable 'frequencies'"), HasSubstr("there is no variable 'shapes'")));
  EXPECT_THAT(
      refused({matrix("frequencies", Eigen::Vector2d(1, 2)), matrix("shapes", Eigen::MatrixXd::Ones(2, 3)),
               matrix("dampings", Eigen::Vector3d(0.1, 0.1, 0.1)), cell("points", {"a"})}),
      AllOf(HasSubstr("shapes are 2 x 3"), HasSubstr("dampings holds 3 values"), HasSubstr("points holds 1 names")));
}

/// As test benches write them: header (151), units (164), nodes (15), trace lines (82), complex modes (55) with more
/// motions than were measured.
TEST(ModeFile, ReadsAUniversalFileOfATestBench) {
  const ScratchFolder folder("mode-file");
  using universal_text::dataset;
  using universal_text::formatted;
  std::string nodes, shape;
  for (const int node : {1, 2}) {
    nodes += formatted("%10d%10d%10d%10d%13.5E%13.5E%13.5E\n", node, 0, 0, 8, 250.0 * (node - 1), 0.0, 0.0);
    const auto z = node == 1 ? Complex(1.0, 0.1) : Complex(-0.5, 0.02);
    shape += formatted("%10d\n%13.5E%13.5E%13.5E%13.5E%13.5E%13.5E\n", node, 0.0, 0.0, 0.0, 0.0, z.real(), z.imag());
  }
  const double omega = 2.0 * M_PI * 12.5, damping = 0.015;
  std::ofstream(folder.path() / "bench.unv")
      << dataset("151", "Rig\nNONE\nTestLab\n01-Jan-20\n01-Jan-20\nTestLab 15\n01-Jan-20\n") +
             dataset("164",
                     "         5mm (milli-newton)            2\n  1.00000000000000000D+03  1.00000000000000000D+03  "
                     "1.00000000000000000D+00\n  2.73149999999999977D+02\n") +
             dataset("15", nodes) + dataset("82", "         1         2         8\nBeam\n         1         2\n") +
             dataset("55",
                     "First bending\nNONE\nNONE\nNONE\nNONE\n         1         3         2         8         5"
                     "         3\n         2         6         0         1\n" +
                         formatted("%13.5E%13.5E%13.5E%13.5E%13.5E%13.5E\n", -damping * omega,
                                   omega * std::sqrt(1.0 - damping * damping), 0.0, 0.0, 0.0, 0.0) +
                         shape);
  const auto set = read_modes(folder.path() / "bench.unv");
  EXPECT_THAT(set.points, ElementsAre("1:+Z", "2:+Z"));
  ASSERT_EQ(set.modes.size(), 1U);
  EXPECT_NEAR(set.modes[0].frequency, 12.5, 1e-4);  // six digits of the eigenvalue
  EXPECT_NEAR(set.modes[0].damping, damping, 1e-7);
  EXPECT_LT(std::abs(set.modes[0].shape[0] - Complex(1e-3, 1e-4)), 1e-18);  // in m
  EXPECT_LT(std::abs(set.modes[0].shape[1] - Complex(-5e-4, 2e-5)), 1e-18);
  ASSERT_EQ(set.nodes.size(), 2U);
  EXPECT_NEAR(set.nodes[1].position[0], 0.25, 1e-12);  // 250 mm
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
