// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/record_cases.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"

// What a case says of a record with gaps, and of sensors that measure nothing.
namespace kalfem::record_cases {
namespace {

using Changes = std::vector<std::pair<std::string, std::string>>;

class MeasuredRecords : public RecordCase {
protected:
  /// The sound record with some cells of the columns x and a written otherwise.
  void write_with(const std::function<std::string(double)>& x, const std::function<std::string(double)>& a) {
    write_record({{"F", written(force)}, {"x", x}, {"a", a}});
  }
};

TEST_F(MeasuredRecords, MayMissSamplesAtAnyPlace) {
  const auto x = [](double t) { return t < 0.045 ? "" : written(displacement)(t); };
  const auto a = [](double t) { return t > 3.95 ? "NA" : std::abs(t - 2.0) < 0.1 ? "nan" : written(acceleration)(t); };
  write_with(x, a);
  const std::pair<std::string, std::string> skip{"{file: record.csv}\nest",
                                                 "{file: record.csv, skip_missing: true}\nest"};
  const Study study = load({skip});
  EXPECT_EQ(study.record->record.values.row(0).array().isNaN().count(), 5);
  EXPECT_EQ(study.record->record.values.row(1).array().isNaN().count(), 5 + 19);
  const StudyResults results = run_study(study, "predict");
  ASSERT_TRUE(results.complete()) << results.failure;
  // without noise: found .035, the step of the augmented model
  EXPECT_NEAR(results.get<EstimationOutcome>().result.unknowns.mean(0, 400), stiffness, 0.1);
  // Per cent of the rms of the samples that are there: 24 missing ones of 401 would take 3 % off it.
  // found 1.7e-4
  EXPECT_NEAR(results.get<EstimationOutcome>().measurements.channels[1].noise,
              0.01 * omega * omega * amplitude / std::numbers::sqrt2, 2e-4);
  expect_in(errors(), {"record.csv:2: column 'x' is empty", "skip_missing: true"});
}

TEST_F(MeasuredRecords, AStartThatIsReadFromThemMustBeThere) {
  const Changes changes = {{"{file: record.csv}\nest", "{file: record.csv, skip_missing: true}\nest"},
                           {"estimate_initial_state: true", "initial_state_from_record: true"}};
  write_with(written(displacement), [](double t) { return t < 0.2 ? "" : written(acceleration)(t); });
  EXPECT_EQ(errors(changes), "");
  EXPECT_TRUE(run_study(load(changes), "estimate").complete());  // what accelerometers miss does not matter
  write_with([](double t) { return t < 0.025 ? "" : written(displacement)(t); }, written(acceleration));
  expect_in(errors(changes), {"case.yaml:7: sensors.x: one of the first 4 samples is missing", "record.start"});
}

TEST_F(MeasuredRecords, OfASensorThatDrivesAnInterfaceMustBeThere) {
  write_with(written(displacement), [](double t) { return std::abs(t - 2.0) < 0.001 ? "" : written(acceleration)(t); });
  std::ofstream(folder_ / "case.yaml") << R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg}}
  top: {masses: {n: 1 kg}}
connectors:
  c: {from: s.m, to: top.n, law: linear, parameters: {k: 100 N/m, c: 1 N s/m}}
sensors:
  a: {acceleration: s.m, noise: 1 %}
  x: {displacement: top.n, noise: 0.01 mm}
record: {file: record.csv, skip_missing: true}
estimate:
  unknown: {c.k: {initial: 90 N/m, std: 20 %}}
  local: {substructures: top, interface: {s.m: {acceleration: {sensor: a}}}}
)";
  try {
    load_study((folder_ / "case.yaml").string());
    FAIL();
  } catch (const InvalidInput& error) {
    expect_in(error.what(),
              {"case.yaml:8: sensors.a drives an interface of the filter's model, but its sample is missing at 2 s"});
  }
}

TEST_F(MeasuredRecords, AnExcitationMayMissNothing) {
  write_record({{"F", [](double t) { return t > 1.0 && t < 1.02 ? "" : written(force)(t); }},
                {"x", written(displacement)},
                {"a", written(acceleration)}});
  const std::string refused = errors({{"{file: record.csv}\nest", "{file: record.csv, skip_missing: true}\nest"}});
  expect_in(refused, {"record.csv:103: ", "excitation.F: column 'F' is empty"});
}

TEST_F(MeasuredRecords, ThatMoveFastForTheirRateSaySo) {
  const auto fast = [](double t) { return std::sin(2.0 * std::numbers::pi * 0.4 * rate * t); };
  write_record({{"F", [&](double t) { return std::to_string(force(t) + 20.0 * fast(t)); }},
                {"x", written(displacement)},
                {"a", [&](double t) { return std::to_string(acceleration(t) + 3.0 * fast(t)); }}});
  const auto preparation = [&] {
    const Study study = load();
    std::string told;
    for (const auto& words : study.record->preparation) told += words + "\n";
    return told;
  };
  const std::string told = preparation();
  expect_in(told, {"excitation 'F': ",
                   "% of its variance lies above 25 Hz, a quarter of its sampling rate; interpolated "
                   "as a band-limited signal",
                   "a: without its noise, "});
  EXPECT_EQ(told.find("x: "), std::string::npos) << told;
  write_record(si_columns());
  EXPECT_EQ(preparation().find("quarter"), std::string::npos);
}

TEST_F(MeasuredRecords, AnInputThatEndsTooEarlySaysByHowMuch) {
  write_record(si_columns());
  std::ofstream(folder_ / "force.csv") << table({{"F", written(force)}}, 3.99);
  expect_in(errors({{"F: {force: s.m, file: record.csv", "F: {force: s.m, file: force.csv"}}),
            {"the input ends at 3.99 s, 10 ms before 4 s, where it is needed"});
}

/// Acceleration of a mass of 2 kg on 800 N/m, damped by `ratio`, under a blow of 100 N in one sample every 10 s.
double after_blows(double t, double ratio) {
  const double w = 20.0, decay = ratio * w, damped = w * std::sqrt(1.0 - ratio * ratio), impulse = 100.0 / rate;
  const double since = std::fmod(t, 10.0) - 1.0;
  const double force = std::abs(since) < 1e-6 ? 100.0 / mass : 0.0;
  if (since < 1e-6) return force;
  return force + impulse / (mass * damped) * std::exp(-decay * since) *
                     ((decay * decay - damped * damped) * std::sin(damped * since) -
                      2.0 * decay * damped * std::cos(damped * since));
}

TEST_F(MeasuredRecords, WhoseWindowWouldWidenAResonanceGiveNoMagnitudes) {
  const auto blow = [](double t) { return std::abs(std::fmod(t, 10.0) - 1.0) < 1e-6 ? "100" : "0"; };
  const auto problems = [&](const std::string& keys) {
    std::ofstream(folder_ / "case.yaml") << R"(kalfem: 1
substructures: {s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m}], damping: {modal: 1 %}}}
update:
  parameters: {s.k.stiffness: {bounds: [600 N/m, 1000 N/m]}}
  compare:
    accelerance: {frf: s, inputs: [{force: m, record: record.csv, input: F}], outputs: [m], bands: [[1 Hz, 6 Hz]])"
                                         << keys << "}\n";
    try {
      std::string told;
      for (const auto& words : load_study((folder_ / "case.yaml").string()).warnings) told += words + "\n";
      return told;
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
  };
  for (const double ratio : {0.01, 0.1}) {
    write_record({{"F", blow}, {"m", [&](double t) { return std::to_string(after_blows(t, ratio)); }}}, 100.0);
    const std::string magnitudes = problems(", compare: log_magnitude");
    EXPECT_EQ(magnitudes.find("narrower than two lines of a segment of 8 s (0.25 Hz)") != std::string::npos,
              ratio < 0.02)
        << magnitudes;
    // The spectra of the whole record have no window.
    EXPECT_EQ(problems("").find("narrower"), std::string::npos) << problems("");
  }
}

TEST_F(MeasuredRecords, AChannelWithoutANumberIsRefusedByItsName) {
  write_with(written(displacement), [](double) { return "nan"; });
  const std::pair<std::string, std::string> skip{"{file: record.csv}\nest",
                                                 "{file: record.csv, skip_missing: true}\nest"};
  expect_in(errors({skip}), {"case.yaml:8: sensors.a: channel 'a' has no number", "401 samples from 0 s to 4 s"});
  write_with([](double) { return ""; }, [](double) { return "nan"; });
  expect_in(errors({skip}), {"sensors.x: channel 'x' has no number", "sensors.a: channel 'a' has no number"});
  // There are numbers, but none in the part that is used.
  write_with(written(displacement), [](double t) { return t > 2.0 ? "" : written(acceleration)(t); });
  expect_in(errors({{skip.first, "{file: record.csv, skip_missing: true, start: 2.5 s}\nest"}}),
            {"channel 'a' has no number", "from 2.5 s to 4 s"});
}

TEST_F(MeasuredRecords, AConstantChannelIsRefusedWithItsValue) {
  for (const std::string value : {"0", "-0.37"}) {
    write_with(written(displacement), [=](double) { return value; });
    const std::string refused = errors();
    expect_in(refused, {"case.yaml:8: sensors.a: channel 'a' has the value " + value + " m/s^2 throughout",
                        "401 samples from 0 s to 4 s", "dead sensor", "accept_constant"});
    EXPECT_EQ(refused.find("sensors.x"), std::string::npos) << refused;
  }
  // Before the motion begins a good sensor shows nothing either: the part is named.
  write_record({{"F", written(force)},
                {"x", [](double t) { return t < 1.0 ? "0" : written(displacement)(t); }},
                {"a", written(acceleration)}});
  EXPECT_EQ(errors(), "");
  expect_in(errors({{"{file: record.csv}\nest", "{file: record.csv, end: 0.5 s}\nest"}}),
            {"sensors.x: channel 'x' has the value 0 m throughout", "51 samples from 0 s to 0.5 s"});
}

TEST_F(MeasuredRecords, AConstantChannelMayBeMeant) {
  write_with(written(displacement), [](double) { return "0"; });
  const auto accepted = [](const std::string& noise) {
    return std::pair<std::string, std::string>{"a: {acceleration: s.m, noise: 1 %}",
                                               "a: {acceleration: s.m, noise: " + noise + ", accept_constant: true}"};
  };
  EXPECT_EQ(errors({accepted("0.1 m/s^2")}), "");
  // Per cent of zero is no noise.
  expect_in(errors({accepted("1 %")}),
            {"case.yaml:8: sensors.a.noise: the noise is 1 % of the channel's rms", "0 throughout", "in m/s^2"});
}

TEST_F(MeasuredRecords, NoiseInPerCentOfASimulatedChannelOfZeroHasItsOwnMessage) {
  const std::string text = R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg, still: 1 kg}, springs: [{from: ground, to: m, stiffness: 800 N/m}, {from: ground, to: still, stiffness: 10 N/m}]}
connectors:
  c: {from: s.ground, to: s.m, law: linear, parameters: {k: 1 N/m, c: 1 N s/m}}
excitation:
  F: {force: s.m, sine: {amplitude: 1 N, frequency: 2 Hz}}
sensors:
  x: {acceleration: s.m, noise: 5 %}
  dead: {acceleration: s.still, noise: 5 %}
simulate: {duration: 0.2 s, sample_rate: 100 Hz}
estimate: {unknown: {c.c: {initial: 2 N s/m, std: 50 %}}, settle: 0.1 s}
)";
  std::ofstream(folder_ / "case.yaml") << text;
  const Study study = load_study((folder_ / "case.yaml").string());
  EXPECT_TRUE(run_study(study, "simulate").complete());  // no filter: nothing has to be weighed
  try {
    run_study(study, "predict");
    FAIL();
  } catch (const InvalidInput& error) {
    expect_in(error.what(), {"case.yaml:10: sensors.dead.noise: the noise is 5 % of the channel's rms, but the "
                             "simulated channel is 0 throughout"});
  }
}

}  // namespace
}  // namespace kalfem::record_cases
