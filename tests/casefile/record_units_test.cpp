// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/record_cases.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/frf_residual.hpp"

// Units of a record's columns: of the case, of the file, and both.
namespace kalfem::record_cases {
namespace {

constexpr double gravity = 9.80665;
using Changes = std::vector<std::pair<std::string, std::string>>;

class RecordUnits : public RecordCase {
protected:
  void write_titled(const std::string& F, const std::string& x, const std::string& a, double factor_F = 1.0,
                    double factor_x = 1.0, double factor_a = 1.0) {
    write_record(
        {{F, written(force, factor_F)}, {x, written(displacement, factor_x)}, {a, written(acceleration, factor_a)}},
        1.0);
  }
  /// Whether sensors and force are in SI.
  void expect_si(const Changes& changes = {}) {
    SCOPED_TRACE(changes.empty() ? "" : changes.front().second);
    try {
      const Study study = load(changes);
      const auto force_samples = study.structure->signals.at(0)->sample(0.0, 1.0 / rate, 101);
      for (int k = 0; k <= 100; ++k) {
        const double t = k / rate;
        // the table is written with twelve digits: found 5e-14 m, 5e-12 m/s^2 and 4e-12 N
        EXPECT_NEAR(study.record->record.values(0, k), displacement(t), 5e-13);
        EXPECT_NEAR(study.record->record.values(1, k), acceleration(t), 5e-11);
        EXPECT_NEAR(force_samples(k, 0), force(t), 4e-11);
      }
    } catch (const InvalidInput& error) {
      ADD_FAILURE() << error.what();
    }
  }

  const std::string record_ = "record: {file: record.csv}";
  const std::string a_ = "a: {acceleration: s.m, noise: 1 %}";
};

TEST_F(RecordUnits, OfTheTitlesAreHonoured) {
  write_titled("F (kN)", "x [mm]", "a (g)", 1e-3, 1e3, 1.0 / gravity);
  expect_si();
  // Columns may be asked for with their unit.
  expect_si(
      {{"channel: F", "channel: F (kN)"}, {"a: {acceleration: s.m,", "a: {channel: 'a (g)', acceleration: s.m,"}});
  // Where the case says the same, it says nothing new.
  expect_si({{a_, "a: {acceleration: s.m, noise: 1 %, unit: g}"}});
  expect_si({{a_, "a: {acceleration: s.m, noise: 1 %, unit: g0}"}, {"channel: F}", "channel: F, unit: kN}"}});
  write_titled("F [mN]", "x (µm)", "a [mg]", 1e3, 1e6, 1e3 / gravity);
  expect_si();
  write_titled("F (filtered)", "x", "a [m/s²]");
  expect_si({{"channel: F", "channel: F (filtered)"}});
}

TEST_F(RecordUnits, OfTheCaseAreHonoured) {
  write_titled("F", "x", "a", 1.0, 1e3, 1.0 / gravity);
  expect_si({{record_, "record: {file: record.csv, unit: mm}"}, {a_, "a: {acceleration: s.m, noise: 1 %, unit: g}"}});
  expect_si({{"x: {displacement: s.m, noise: 0.01 mm}", "x: {displacement: s.m, noise: 0.01 mm, unit: mm}"},
             {record_, "record: {file: record.csv, unit: g}"}});
  write_titled("F", "x", "a [g]", 1.0, 1e3, 1.0 / gravity);
  expect_si({{"x: {displacement: s.m, noise: 0.01 mm}", "x: {displacement: s.m, noise: 0.01 mm, unit: mm}"}});
}

TEST_F(RecordUnits, OfNoiseAreThoseOfTheSensor) {
  write_titled("F", "x", "a");
  const Study study = load({{a_, "a: {acceleration: s.m, noise: 0.02 g, offset: 3 mg}"}});
  EXPECT_NEAR(study.sensors.at(1).noise, 0.02 * gravity, 1e-15);
  EXPECT_NEAR(study.record->record.values(1, 0), acceleration(0.0) - 3e-3 * gravity, 5e-11);
  // The resolved case says the same again.
  EXPECT_EQ(study.resolved_case.find(" kg\n", study.resolved_case.find("noise")), std::string::npos);
  EXPECT_NE(errors({{a_, "a: {acceleration: s.m, noise: 0.02 kg}"}}).find("0.02 kg given where m/s^2 is required"),
            std::string::npos);
  EXPECT_NE(errors({{"noise: 0.01 mm", "noise: 0.01 g"}}).find("given where m is required"), std::string::npos);
}

TEST_F(RecordUnits, OfAnotherQuantityAreRefused) {
  write_titled("F", "x", "a");
  for (const std::string unit : {"s", "kg", "mm", "'%'", "V", "rad"}) {
    const auto refused = errors({{a_, "a: {acceleration: s.m, noise: 1 %, unit: " + unit + "}"}});
    expect_in(refused, {"case.yaml:8: sensors.a.unit: ", " given where m/s^2 is required"});
  }
  expect_in(errors({{record_, "record: {file: record.csv, unit: g}"}}),
            {"case.yaml:9: record.unit: ", "g given where m is required", "sensors.x"});
  expect_in(errors({{record_, "record: {file: record.csv, unit: furlong}"}}),
            {"case.yaml:9: record.unit: ", "furlong"});
  expect_in(errors({{"channel: F}", "channel: F, unit: mm}"}}),
            {"case.yaml:5: ", "excitation.F.unit: ", "mm given where N is required"});
  // Rotations are in radians.
  EXPECT_EQ(errors({{a_, "a: {acceleration: s.m, noise: 1 %, unit: deg/s^2}"}}), "");
  EXPECT_EQ(errors({{"x: {displacement: s.m, noise: 0.01 mm}", "x: {displacement: s.m, noise: 0.01 mm, unit: mrad}"}}),
            "");

  write_titled("F [N]", "x [mm]", "a [mm]");
  expect_in(errors(), {"record.csv:1: column 'a' (sensors.a): mm given where m/s^2 is required"});
  write_titled("F [counts]", "x", "a [counts]");
  expect_in(errors({{"channel: F}", "channel: F, unit: kN}"}}),
            {"record.csv:1: column 'a'", "'counts' is not known", "state it in sensors.a.unit"});
  expect_in(errors({{a_, "a: {acceleration: s.m, noise: 1 %, unit: g}"}}),
            {"record.csv:1: ", "column 'F'", "state it in excitation.F.unit"});
  EXPECT_EQ(errors({{a_, "a: {acceleration: s.m, noise: 1 %, unit: g}"}, {"channel: F}", "channel: F, unit: kN}"}}),
            "");
}

TEST_F(RecordUnits, ThatContradictEachOtherAreRefused) {
  write_titled("F (kN)", "x [mm]", "a (g)");
  expect_in(errors({{a_, "a: {acceleration: s.m, noise: 1 %, unit: m/s^2}"}}),
            {"case.yaml:8: sensors.a.unit is 'm/s^2', but the column 'a' (sensors.a) is in 'g'", "record.csv:1"});
  expect_in(errors({{record_, "record: {file: record.csv, unit: m}"}}),
            {"case.yaml:9: record.unit is 'm', but the column 'x' (sensors.x) is in 'mm'", "set sensors.x.unit"});
  expect_in(
      errors({{"channel: F}", "channel: F, unit: N}"}}),
      {"case.yaml:5: ", "excitation.F.unit is 'N', but the column 'F' (excitation.F) is in 'kN'", "record.csv:1"});
}

TEST_F(RecordUnits, AreEchoed) {
  write_titled("F", "x", "a");
  const Study study = load({{a_, "a: {acceleration: s.m, noise: 1 %, unit: g}"}});
  const std::string echo = study.resolved_case;
  EXPECT_NE(echo.find("unit: g"), std::string::npos) << echo;
}

TEST_F(RecordUnits, OfAnHdf5DatasetAreItsAttribute) {
  const auto write = [&](const std::string& attribute, const std::string& unit) {
    Eigen::MatrixXd values(101, 2);
    for (int k = 0; k <= 100; ++k) values.row(k) << 1e3 * displacement(k / rate), 1e3 * acceleration(k / rate);
    auto file = Hdf5File::create((folder_ / "record.h5").string());
    file.write_matrix("/run", values);
    file.set_attribute("/run", "fs", rate);
    if (!attribute.empty()) file.set_attribute("/run", attribute, unit);
    file.close();
  };
  write_titled("F", "x", "a");
  const Changes changes = {{"x: {displacement: s.m,", "x: {channel: '0', displacement: s.m,"},
                           {a_, "# "},
                           {record_, "record: {file: record.h5, dataset: /run}"}};
  write("unit", "mm");
  // one multiplication
  EXPECT_NEAR(load(changes).record->record.values(0, 7), displacement(0.07), 4e-17);
  write("units", "mm");
  EXPECT_NEAR(load(changes).record->record.values(0, 7), displacement(0.07), 4e-17);
  write("", "");
  EXPECT_NEAR(load(changes).record->record.values(0, 7), 1e3 * displacement(0.07), 4e-14);
  write("unit", "s");
  expect_in(errors(changes), {"record.h5: column '0' (sensors.x): s given where m is required"});
}

/// 1 / (k - m w^2), in mm/kN.
std::string receptances(const std::string& title) {
  std::string text = "f (Hz)," + title + "\n";
  for (int f = 1; f < 6; ++f) {
    const double w = 2.0 * std::numbers::pi * f;
    text += std::to_string(f) + "," + std::to_string(1e6 / (stiffness - mass * w * w)) + "\n";
  }
  return text;
}

TEST_F(RecordUnits, OfFrequencyResponsesAndFrequenciesAreHonoured) {
  const std::string compared = R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m}]}
update:
  parameters: {s.k.stiffness: {initial: 800 N/m, bounds: [500, 1000]}}
  compare:
    responses: {frf: s, quantity: displacement, inputs: [{force: m, file: frf.csv}], outputs: [m], compare: difference}
    modes: {modes: s, frequencies: {file: modes.csv, column: f, first: 1}}
)";
  std::ofstream(folder_ / "case.yaml") << compared;
  const auto residuals = [&](const std::string& title, const std::string& modes) {
    std::ofstream(folder_ / "frf.csv") << receptances(title);
    std::ofstream(folder_ / "modes.csv") << modes;
    const Study study = load_study((folder_ / "case.yaml").string());
    std::vector<double> norms;
    for (const auto& comparison : study.updating_plan->comparisons)
      norms.push_back(comparison.continuation_steps.front()
                          ->evaluate(Eigen::VectorXd::Constant(1, stiffness), false)
                          ->values.norm());
    return norms;
  };
  const auto in_rad = residuals("H [mm/kN]", "f (rad/s)\n20\nnot measured\n");
  // rounding, in the comparison's deviations
  EXPECT_LT(in_rad.at(0), 1e-7);
  EXPECT_LT(in_rad.at(1), 1e-12);
  EXPECT_LT(residuals("H [mm/kN]", "f [kHz]\n3.183098861837907e-3\n").at(1), 1e-12);
  EXPECT_THROW(residuals("H", "f\n3.18\n"), InvalidInput);  // a million times too large in m/N
  EXPECT_THROW(residuals("H [mm]", "f\n3.18\n"), InvalidInput);
  EXPECT_THROW(residuals("H [mm/kN]", "f [mm]\n3.18\n"), InvalidInput);
}

}  // namespace
}  // namespace kalfem::record_cases
