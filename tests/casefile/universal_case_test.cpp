// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <complex>

#include "casefile/record_cases.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/frf_residual.hpp"

// Cases whose measured data stand in universal files.
namespace kalfem::record_cases {
namespace {

class UniversalCase : public RecordCase {
protected:
  /// The sound case's force, displacement in mm and acceleration in g; the accelerometer looks against the axis.
  void write_file(double rate_of_a = rate) const {
    const auto channel = [](const std::string& name, const std::string& unit, MeasuredPlace place,
                            double (*value)(double), double factor, double sampling) {
      MeasuredChannel channel{.name = name, .unit = unit, .place = place, .interval = 1.0 / sampling};
      channel.values.resize(401);
      for (int k = 0; k <= 400; ++k) channel.values[k] = factor * value(k / sampling);
      return channel;
    };
    MeasuredFile file;
    file.channels = {channel("hammer", "N", {}, force, 1.0, rate),
                     channel("7:+X", "mm", {7, 1}, displacement, 1e3, rate),
                     channel("7:-X", "g", {7, -1}, acceleration, -1.0 / 9.80665, rate_of_a)};
    write_universal(folder_ / "record.unv", file);
  }

  std::vector<std::pair<std::string, std::string>> changes(const std::string& x, const std::string& a) const {
    return {{"file: record.csv, channel: F", "file: record.unv, channel: hammer"},
            {"x: {displacement", "x: {channel: '" + x + "', displacement"},
            {"a: {acceleration", "a: {channel: '" + a + "', acceleration"},
            {"record: {file: record.csv}", "record: {file: record.unv}"}};
  }
};

TEST_F(UniversalCase, ChannelsBecomeSensorsByNodeDirectionAndPolarity) {
  write_file();
  const Study study = load(changes("7X", "7:+x"));
  const auto force_samples = study.structure->signals.at(0)->sample(0.0, 1.0 / rate, 401);
  for (int k = 0; k <= 400; k += 50) {
    EXPECT_NEAR(study.record->record.values(0, k), displacement(k / rate), 1e-15);
    EXPECT_NEAR(study.record->record.values(1, k), acceleration(k / rate), 1e-12);
    EXPECT_NEAR(force_samples(k, 0), force(k / rate), 1e-11);
  }
}

TEST_F(UniversalCase, WhatDoesNotFitIsRefusedWithTheFileAndWhatToDo) {
  write_file(50.0);
  expect_in(errors(changes("7X", "7X")),
            {"record.unv", "'7:+X' has 401 samples from 0 s to 4 s, '7:-X' has 401 samples from 0 s to 8 s",
             "cover the same time"});
  expect_in(errors(changes("8X", "7X")), {"record.unv", "there is no channel '8X'", "'hammer' [N]"});
  std::ofstream(folder_ / "record.unv") << "PK\x03\x04";
  expect_in(errors(changes("7X", "7X")), {"record.unv", "ZIP", "universal file (.unv"});
}

TEST_F(UniversalCase, FrequencyResponsesAreComparedLikeThoseOfATable) {
  MeasuredFile file;
  const std::complex<double> i(0, 1);
  for (const int sign : {1, -1}) {
    MeasuredFunction frf{.name = "H",
                         .unit = "(g)/(kN)",
                         .kind = MeasuredFunctionKind::frequency_response,
                         .response = {7, sign},
                         .reference = {7, 1}};
    frf.lines = 0.1 * Eigen::VectorXd::LinSpaced(40, 1.0, 40.0);
    frf.values.resize(40);
    for (int k = 0; k < 40; ++k) {
      const double w = 2.0 * std::numbers::pi * frf.lines[k];
      frf.values[k] = double(sign) * 1e3 / 9.80665 * -w * w / (stiffness + i * w * dashpot - w * w * mass);
    }
    if (sign < 0) frf.response.node = 8;
    file.functions.push_back(frf);
  }
  write_universal(folder_ / "frf.unv", file);
  const auto compared = [&](const std::string& columns) {
    std::ofstream(folder_ / "case.yaml") << R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m, damping: 2 N s/m}]}
update:
  parameters: {s.k.stiffness: {}}
  compare:
    tap:
      frf: s
      inputs: [{force: m, file: frf.unv, columns: [')" +
                                                columns + R"(']}]
      outputs: [m]
)";
    const Study study = load_study((folder_ / "case.yaml").string());
    const auto residual =
        std::dynamic_pointer_cast<const FrfResidual>(study.updating_plan->comparisons.at(0).continuation_steps.back());
    return residual->compared()[0].values;
  };
  const double w = 2.0 * std::numbers::pi * 0.5;
  const std::complex<double> expected = -w * w / (stiffness + i * w * dashpot - w * w * mass);
  for (const std::string columns : {"7X", "7:+X/7:+X", "8:+X"})
    EXPECT_NEAR(std::abs(compared(columns)(4, 0) - expected), 0.0, 1e-12 * std::abs(expected)) << columns;
}

}  // namespace
}  // namespace kalfem::record_cases
