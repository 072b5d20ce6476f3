// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "casefile/probes.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/records/record_splice.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

/// Keys of sensors with their measurement chains, and of measured records.
namespace kalfem::wiring {
namespace {

Study with_sensor(const std::string& text) { return study_of(lumped_case({{"sensors", "{y: {" + text + "}}"}})); }

/// Weights of s.a and s.b in what the sensor sees, of displacement, velocity and acceleration.
Eigen::Matrix<double, 3, 2> seen(const std::string& quantity) {
  const auto study = with_sensor(quantity + ", noise: 1");
  const auto map = make_outputs(*study.model, {study.sensors[0].output});
  Eigen::Matrix<double, 3, 2> rows;
  rows << Eigen::MatrixXd(map.displacement).row(0), Eigen::MatrixXd(map.velocity).row(0),
      Eigen::MatrixXd(map.acceleration).row(0);
  return rows;
}

void motions() {
  const Eigen::RowVector2d a(1, 0), difference(-1, 0.5);
  EXPECT_EQ(seen("displacement: s.a"), (Eigen::Matrix<double, 3, 2>{{1, 0}, {0, 0}, {0, 0}}));
  EXPECT_EQ(seen("velocity: s.a"), (Eigen::Matrix<double, 3, 2>{{0, 0}, {1, 0}, {0, 0}}));
  EXPECT_EQ(seen("acceleration: s.a"), (Eigen::Matrix<double, 3, 2>{{0, 0}, {0, 0}, {1, 0}}));
  EXPECT_EQ(seen("displacement: {s.a: -1, s.b: 0.5}"), (Eigen::Matrix<double, 3, 2>{{-1, 0.5}, {0, 0}, {0, 0}}));
}

void connector_quantities() {
  const auto force = with_sensor("force: c, noise: 1");
  const auto map = make_outputs(*force.model, {force.sensors[0].output});
  EXPECT_EQ(map.force.rows(), 1);
  near(map.force(0, 0), 1.0);
  EXPECT_EQ(seen("deformation: c"), (Eigen::Matrix<double, 3, 2>{{-1, 1}, {0, 0}, {0, 0}}));
  EXPECT_EQ(seen("rate: c"), (Eigen::Matrix<double, 3, 2>{{0, 0}, {-1, 1}, {0, 0}}));
}

/// Noise of a strain is a strain, unless it is in per cent.
void strains() {
  const auto sensor = [](const std::string& text) {
    const std::string gauges = "gauges: {g: {element: 2}, h: {element: 1}}";
    return study_of(beam_case({{"substructures", "{b: {finite_elements: {" + beam_elements(gauges) + "}}}"},
                               {"sensors", "{y: {" + text + "}}"}}));
  };
  const auto row = [&](const std::string& strain) -> Eigen::VectorXd {
    const auto study = sensor("strain: " + strain + ", noise: 1e-6");
    return Eigen::MatrixXd(make_outputs(*study.model, {study.sensors[0].output}).displacement).row(0).transpose();
  };
  const auto study = sensor("strain: b.g, noise: 1e-6");
  EXPECT_EQ(study.sensors[0].unit, "m/m");
  EXPECT_FALSE(study.sensors[0].relative_noise);
  near(row("b.g"), study.model->strain("b.g"));
  near(row("{b.g: 0.5, b.h: -0.5}"), 0.5 * (study.model->strain("b.g") - study.model->strain("b.h")));
  for (const char* noise : {"2 um/m", "2 ppm", "2 microstrain", "2 µε", "0.002 mm/m"}) {
    const auto absolute = sensor("strain: b.g, noise: " + std::string(noise)).sensors[0];
    EXPECT_FALSE(absolute.relative_noise) << noise;
    near(absolute.noise, 2e-6, many_roundings);
  }
  const auto relative = sensor("strain: b.g, noise: 2 %").sensors[0];
  EXPECT_TRUE(relative.relative_noise);
  near(relative.noise, 0.02);
  EXPECT_THROW(sensor("strain: b.g, noise: 1"), InvalidInput);  // a strain of 100 %
  EXPECT_THROW(sensor("strain: b.g, noise: 1 um"), InvalidInput);
  EXPECT_THROW(sensor("strain: b.tip, noise: 1e-6"), InvalidInput);
  EXPECT_THROW(sensor("displacement: b.g, noise: 1e-6"), InvalidInput);
}

/// A load cell feels the mass that it carries: f + m a of the end `to`, f - m a of the end `from`.
void load_cells_with_mass() {
  const auto carried = [](const std::string& more) {
    const auto study = with_sensor("force: {c: 2}, noise: 1, mass: 3 kg" + more);
    const auto map = make_outputs(*study.model, {study.sensors[0].output});
    near(map.force(0, 0), 2.0);
    return Eigen::MatrixXd(map.acceleration);
  };
  EXPECT_EQ(carried(""), (Eigen::Matrix<double, 1, 2>{0, 6}));
  EXPECT_EQ(carried(", mass_at: to"), (Eigen::Matrix<double, 1, 2>{0, 6}));
  EXPECT_EQ(carried(", mass_at: from"), (Eigen::Matrix<double, 1, 2>{-6, 0}));
  EXPECT_THROW(with_sensor("displacement: s.a, noise: 1, mass: 3 kg"), InvalidInput);
  EXPECT_THROW(with_sensor("force: c, noise: 1, mass: 0 kg"), InvalidInput);
}

void relative_to_the_base() {
  const auto base_part = [](const std::string& more) {
    const auto study = study_of(lumped_case({{"excitation", "{e: {base_acceleration: all, constant: 1}}"},
                                             {"sensors", "{y: {acceleration: s.b, noise: 1" + more + "}}"}}));
    return make_outputs(*study.model, {study.sensors[0].output}).input_value(0, 0);
  };
  near(base_part(""), 1.0);
  near(base_part(", relative: false"), 1.0);
  EXPECT_EQ(base_part(", relative: true"), 0.0);
}

void noise_is_absolute_or_a_part_of_the_rms() {
  const auto absolute = with_sensor("displacement: s.a, noise: 2 mm");
  near(absolute.sensors[0].deviation(5.0), 2e-3);
  const auto relative = with_sensor("displacement: s.a, noise: 3 %");
  near(relative.sensors[0].deviation(5.0), 0.15);
  // The record that a simulation makes has this noise, the filter expects it, and its level is that of the clean
  // signal.
  const auto study = study_of(estimated_case(
      {{"sensors", "{y: {displacement: s.b, noise: 5 %}}"}, {"simulate", "{duration: 20 s, sample_rate: 100 Hz}"}}));
  const auto results = run(study, "simulate");
  const Eigen::VectorXd clean = results.get<SimulationOutcome>().reference.sensors.row(0).transpose();
  near(results.get<SimulationOutcome>().measurements.channels[0].noise, 0.05 * rms(clean));
  const Eigen::VectorXd noise = results.get<SimulationOutcome>().measurements.values.row(0).transpose() - clean;
  // 2001 samples: the rms of the noise is known to 1.6 %, three deviations.
  near(rms(noise), results.get<SimulationOutcome>().measurements.channels[0].noise, 3.0 / std::sqrt(2.0 * 2001));
  const auto filter = make_filter_run(study.problem, *study.augmented_model, record_of(study, results));
  near(filter.input.noise(0, 0), std::pow(results.get<SimulationOutcome>().measurements.channels[0].noise, 2));
}

std::complex<double> response(const std::string& chain, double frequency) {
  return with_sensor("displacement: s.a, noise: 1, chain: [" + chain + "]")
      .sensors[0]
      .chain.frequency_response(frequency);
}

/// Butterworth filters by their formula; Bessel ones at the cut-off and by the library.
void filters() {
  const auto low = [](int order, double ratio) { return 1.0 / std::sqrt(1.0 + std::pow(ratio, 2 * order)); };
  near(std::abs(response("{butterworth: {low_pass: 20 Hz}}", 30.0)), low(4, 1.5), many_roundings);
  near(std::abs(response("{butterworth: {order: 2, low_pass: 20 Hz}}", 30.0)), low(2, 1.5), many_roundings);
  near(std::abs(response("{butterworth: {order: 3, high_pass: 20 Hz}}", 30.0)), low(3, 1.0 / 1.5), many_roundings);
  near(std::abs(response("{butterworth: {order: 2, band_pass: [10, 40]}}", 20.0)), 1.0, many_roundings);
  near(std::abs(response("{butterworth: {order: 2, band_pass: [10, 40]}}", 10.0)), std::sqrt(0.5), many_roundings);
  near(std::abs(response("{butterworth: {order: 2, band_pass: [10, 40]}}", 40.0)), std::sqrt(0.5), many_roundings);
  for (const auto band : {FilterBand::low_pass, FilterBand::high_pass, FilterBand::band_pass}) {
    const std::string text = band == FilterBand::low_pass    ? "low_pass: 20"
                             : band == FilterBand::high_pass ? "high_pass: 20"
                                                             : "band_pass: [20, 50]";
    const MeasurementChain bessel({{FilterSection{FilterFamily::bessel, band, 3, 20.0, 50.0}}});
    // the same sections
    EXPECT_LT(std::abs(response("{bessel: {order: 3, " + text + "}}", 17.0) - bessel.frequency_response(17.0)), 1e-14);
  }
}

void other_stages() {
  const double f = 25.0, omega = 2 * 3.14159265358979323846 * f;
  // a delay of 4 ms at 30 Hz is far inside its approximation: rounding is left
  EXPECT_LT(std::abs(response("{delay: 4 ms}", f) - std::polar(1.0, -omega * 4e-3)), 1e-14);
  const auto resonance = [&](double zeta) {
    return 1.0 / std::complex<double>(1.0 - std::pow(f / 100.0, 2), 2.0 * zeta * f / 100.0);
  };
  EXPECT_LT(std::abs(response("{resonance: {frequency: 100 Hz, damping: 0.3}}", f) - resonance(0.3)), 1e-14);
  EXPECT_LT(std::abs(response("{resonance: {frequency: 100 Hz}}", f) - resonance(0.7)), 1e-14);
  EXPECT_LT(std::abs(response("{gain: -2.5}", f) + 2.5), 1e-15);
  EXPECT_LT(std::abs(response("{gain: 2}, {gain: -1.5}", f) + 3.0), 1e-15);
  EXPECT_LT(std::abs(response("{gain: 2}, {delay: 4 ms}", f) - 2.0 * std::polar(1.0, -omega * 4e-3)), 2e-14);
}

// --- records ---------------------------------------------------------------------------------------------------------

/// Whether `with_record` reads the record of a validation in the place of the case's own.
bool of_validation = false;

Study with_record(const std::string& text, const Sections& more = {}) {
  Sections sections{{"simulate", ""}, {"record", "{" + text + "}"}};
  if (of_validation)
    sections = {{"simulate", ""},
                {"excitation", ""},
                {"update", "{parameters: {s.a.mass: {}}, compare: {f: {modes: s, frequencies: [3]}}}"},
                {"validate", "{record: {" + text + "}}"}};
  for (const auto& [key, value] : more) sections[key] = value;
  Study study = study_of(lumped_case(sections));
  if (of_validation) study.record = study.validation->record;
  return study;
}

const std::vector<double> ramp{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, fall{9, 8, 7, 6, 5, 4, 3, 2, 1, 0};

void record_columns() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}, {"z", fall}}, 2.0));
  const auto own = with_record("file: record.csv");
  near(own.record->record.sample_rate, 10.0);
  near(own.record->record.start, 2.0);
  near(own.record->record.values.row(0).transpose(), Eigen::VectorXd::LinSpaced(10, 0, 9));
  EXPECT_EQ(own.record->record.samples_used(), 10);
  const auto other = with_record("file: record.csv", {{"sensors", "{y: {displacement: s.b, noise: 1, channel: z}}"}});
  near(other.record->record.values.row(0).transpose(), Eigen::VectorXd::LinSpaced(10, 9, 0));
  EXPECT_EQ(other.record->record.channels[0].name, "y");
}

void record_units_and_rates() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}}));
  near(with_record("file: record.csv, unit: mm").record->record.values(0, 9), 9e-3);
  write_file("bare.csv", "y\n0\n1\n2\n3\n");
  near(with_record("file: bare.csv, sample_rate: 50 Hz").record->record.sample_rate, 50.0);
}

/// The unit of a sensor's own column comes before that of the whole record.
void units_of_channels() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}, {"z", fall}}));
  const auto record = [](const std::string& unit, const std::string& whole) {
    return with_record("file: record.csv" + whole, {{"sensors", "{y: {displacement: s.b, noise: 1" + unit +
                                                                    "}, z: {acceleration: s.a, noise: 1, unit: g}}"}})
        .record->record.values;
  };
  near(record("", "")(0, 9), 9.0);
  near(record(", unit: mm", "")(0, 9), 9e-3);
  near(record(", unit: mm", ", unit: g")(0, 9), 9e-3);
  near(record("", "")(1, 0), 9 * 9.80665);
}

/// A channel of one value is a dead sensor, unless the case says that it was measured.
void constant_channels() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}, {"z", std::vector<double>(10, 3.0)}}));
  const auto record = [](const std::string& more) {
    return *with_record("file: record.csv", {{"sensors",
                                              "{y: {displacement: s.b, noise: 1}, z: {displacement: s.a, "
                                              "noise: 1" +
                                                  more + "}}"}})
                .record;
  };
  EXPECT_THROW(record(""), InvalidInput);
  EXPECT_THROW(record(", accept_constant: false"), InvalidInput);
  near(record(", accept_constant: true").record.values.row(1).transpose(), Eigen::VectorXd::Constant(10, 3.0));
}

void record_datasets() {
  const auto path = write_file("record.h5", "");
  {
    auto file = Hdf5File::create(path.string());
    const Eigen::MatrixXd rising = Eigen::VectorXd::LinSpaced(4, 0, 3).replicate(1, 2);
    file.write_matrix("/run2", (rising.array() + 5.0).matrix());
    file.write_matrix("/run1", (rising.array() + 6.0).matrix());
  }
  const auto value = [](const std::string& dataset) {
    return with_record("file: record.h5, dataset: /" + dataset + ", sample_rate: 20 Hz",
                       {{"sensors", "{y: {displacement: s.b, noise: 1, channel: '1'}}"}})
        .record->record.values(0, 0);
  };
  near(value("run2"), 5.0);
  near(value("run1"), 6.0);
}

void record_window() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}}, 2.0));
  const auto part = with_record("file: record.csv, start: 2.3 s, end: 2.7 s");
  near(part.record->record.start, 2.3);
  near(part.record->record.values.row(0).transpose(), Eigen::VectorXd::LinSpaced(5, 3, 7));
  EXPECT_EQ(part.record->record.samples_used(), 5);
}

void missing_samples() {
  auto record = [] {
    const auto path = write_file("record.h5", "");
    auto file = Hdf5File::create(path.string());
    Eigen::MatrixXd values = Eigen::VectorXd::LinSpaced(10, 0, 9);
    values(4, 0) = std::numeric_limits<double>::quiet_NaN();
    file.write_matrix("/d", values);
  };
  record();
  const Sections first{{"sensors", "{y: {displacement: s.b, noise: 1, channel: '0'}}"}};
  EXPECT_THROW(with_record("file: record.h5, dataset: /d, sample_rate: 10", first), InvalidInput);
  const auto study = with_record("file: record.h5, dataset: /d, sample_rate: 10, skip_missing: true", first);
  EXPECT_TRUE(std::isnan(study.record->record.values(0, 4)));
  near(study.record->record.values(0, 5), 5.0);
}

/// The channel holds gain signal + offset, late by delay + drift t.
void calibrations_of_channels() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}}));
  const auto values = [](const std::string& more) {
    return Eigen::VectorXd(
        with_record("file: record.csv", {{"sensors", "{y: {displacement: s.b, noise: 1" + more + "}}"}})
            .record->record.values.row(0)
            .transpose());
  };
  near(values(", gain: -2")[9], -4.5);
  near(values(", offset: 3 mm")[9], 9.0 - 3e-3);
  near(values(", gain: 2, offset: 1")[9], 4.0);
  EXPECT_THROW(values(", gain: 0"), InvalidInput);
  EXPECT_THROW(values(", offset: 3 m/s"), InvalidInput);
  near(values(", delay: 0.2 s")[4], ramp[6], many_roundings);
  EXPECT_EQ(values(", delay: 0.2 s").array().isNaN().count(), 2);
  EXPECT_NEAR(values(", drift: 5 %")[0], ramp[0], 1e-10);                            // of a ramp to 5: found 5e-12
  EXPECT_EQ(values(", delay: 0.2 s, drift: 50000 ppm").array().isNaN().count(), 2);  // 0.24 s at 0.8 s
  EXPECT_THROW(values(", drift: 50"), InvalidInput);
}

/// A channel of another file stands at its own times; a file of another rate leaves the samples between missing.
void channels_of_other_files() {
  write_file("record.csv", csv_of(10.0, {{"y", ramp}}));
  write_file("same.csv", csv_of(10.0, {{"z [mm]", fall}}));
  write_file("slow.csv", csv_of(5.0, {{"z", std::vector<double>(ramp.begin(), ramp.begin() + 5)}}));
  const auto with = [](const std::string& file, const std::string& more = "") {
    return with_record("file: record.csv" + more, {{"sensors",
                                                    "{y: {displacement: s.b, noise: 1}, z: {displacement: s.a, "
                                                    "noise: 1, file: " +
                                                        file + "}}"}})
        .record->record;
  };
  const auto same = with("same.csv");
  for (int k = 0; k < 10; ++k) near(same.values(0, k), ramp[std::size_t(k)]);
  for (int k = 0; k < 10; ++k) near(same.values(1, k), 1e-3 * fall[std::size_t(k)]);
  const auto slow = with("slow.csv", ", skip_missing: true");
  near(slow.sample_rate, 10.0);
  near(slow.values(1, 4), ramp[2]);
  EXPECT_TRUE(std::isnan(slow.values(1, 3)));
  EXPECT_THROW(with("absent.csv"), InvalidInput);
  EXPECT_THROW(
      with_record("file: record.csv", {{"sensors", "{y: {displacement: s.b, noise: 1, file: same.csv, channel: z}}"},
                                       {"validate", "{record: {file: record.csv}}"}}),
      InvalidInput);
}

/// From 0 to 1 in 5 s, and 1 for another 5 s.
std::vector<double> ramp_and_hold() {
  std::vector<double> y(2000, 1.0);
  for (int k = 0; k < 1000; ++k) y[std::size_t(k)] = k / 1000.0;
  return y;
}

std::vector<double> two_sines(double slow, double fast, double offset) {
  std::vector<double> y(2000);
  for (int k = 0; k < 2000; ++k)
    y[std::size_t(k)] =
        offset + std::sin(6.283185307179586 * slow * k / 200.0) + std::sin(6.283185307179586 * fast * k / 200.0);
  return y;
}

/// What is done to all channels. The middle of the record shows filters without their ends.
void preparations() {
  write_file("record.csv", csv_of(200.0, {{"y", ramp_and_hold()}}));
  const auto prepared = [](const std::string& file, const std::string& text) {
    return *with_record("file: " + file + ", prepare: {" + text + "}").record;
  };
  const auto value = [&](const std::string& text, Eigen::Index k) {
    return prepared("record.csv", text).record.values(0, k);
  };
  near(value("remove_offset: {}", 0), -0.74975, many_roundings);
  near(value("remove_offset: {to: 4.995 s}", 1999), 1.0 - 0.4995, 1e-3);
  near(value("remove_offset: {from: 5 s, to: 9 s}", 0), -1.0, 1e-3);
  EXPECT_EQ(prepared("record.csv", "remove_offset: {from: 5 s}").preparation.size(), 1U);
  EXPECT_LT(std::abs(value("remove_trend: true", 0)), 0.5);
  near(value("remove_trend: false", 1999), 1.0);
  write_file("sines.csv", csv_of(200.0, {{"y", two_sines(1.0, 40.0, 0.0)}}));
  const auto middle_rms = [&](const std::string& text) {
    const auto record = prepared("sines.csv", text).record;
    return rms(record.values.row(0).transpose().segment(record.samples() / 4, record.samples() / 2));
  };
  near(middle_rms("low_pass: 0"), 1.0, 1e-3);
  near(middle_rms("low_pass: 10 Hz"), std::sqrt(0.5), 1e-3);
  near(middle_rms("high_pass: 10 Hz"), std::sqrt(0.5), 1e-3);
  near(middle_rms("high_pass: 1 Hz"), std::sqrt(0.75), 1e-3);  // half of the power at its limit
  const auto lower = prepared("sines.csv", "sample_rate: 50 Hz");
  near(lower.record.sample_rate, 50.0);
  near(middle_rms("sample_rate: 50 Hz"), std::sqrt(0.5), 1e-3);  // 40 Hz is stopped
  EXPECT_THROW(prepared("sines.csv", "sample_rate: 500 Hz"), InvalidInput);
}

/// Two sines that are quiet up to sample 300 and noisy behind it, where 6 samples are missing.
void splices_are_repaired() {
  std::vector<double> y(900), z(900);
  RandomStream random(3, "splice");
  for (int k = 0; k < 900; ++k) {
    const double t = (k < 300 ? k : k + 6) / 500.0, noise = k < 300 ? 2e-7 : 1e-5;
    y[std::size_t(k)] = 0.03 * std::cos(9.4 * t) + noise * random.normal();
    z[std::size_t(k)] = 0.03 * std::cos(13.8 * t + 0.3) + noise * random.normal();
  }
  write_file("record.csv", csv_of(500.0, {{"y", y}, {"z", z}}));
  const Sections sensors{{"sensors", "{y: {displacement: s.b, noise: 1}, z: {displacement: s.a, noise: 1}}"}};
  EXPECT_EQ(with_record("file: record.csv", sensors).record->record.samples(), 900);
  const auto study = with_record("file: record.csv, repair_splice: true", sensors);
  const auto& mended = study.record->record;
  ASSERT_EQ(mended.samples(), 906);
  ASSERT_EQ(study.record->preparation.size(), 1u);
  // The six samples, the one behind them and two on either side are missing; behind them the time is right: to 5
  // deviations of noise.
  EXPECT_EQ(mended.values.row(0).array().isNaN().count(), 11);
  for (const Eigen::Index k : {297, 309, 500, 905})
    // found 1.2e-5
    EXPECT_NEAR(mended.values(0, k), 0.03 * std::cos(9.4 * double(k) / 500.0), 5e-5) << k;
}

/// Held at 40 mm, released at 0.5 s, at rest at 5 mm from 2.5 s on.
void free_responses() {
  std::vector<double> y(1800);
  for (int k = 0; k < 1800; ++k) {
    const double since = k / 500.0 - 0.5;
    y[std::size_t(k)] = since <= 0 ? 0.04 : 0.005 + 0.035 * std::max(0.0, 1.0 - since / 2.0) * std::cos(9.42 * since);
  }
  write_file("record.csv", csv_of(500.0, {{"y", y}}));
  const auto record = [](const std::string& text) {
    return *with_record("file: record.csv, free_response: {" + text + "}").record;
  };
  const auto plain = record("");
  // found .016: 1 % of the excursion and five samples
  EXPECT_NEAR(plain.record.start, 0.5, 0.03);
  near(plain.record.values(0, 10), y[std::size_t(std::llround(plain.record.start * 500)) + 10] - 0.005, many_roundings);
  EXPECT_NEAR(record("delay: 0.2 s").record.start, plain.record.start + 0.2, 1e-12);
  // The amplitude 35 mm (1 - t / 2 s) is below 10 mm from 1.93 s after the release on; the record begins up to 30 ms
  // late.
  const auto used = [&](const std::string& text) { return double(record(text).record.samples_used()) / 500.0; };
  // a swing of .33 s may pass until the threshold is seen: found .05
  EXPECT_NEAR(used("threshold: 10 mm, margin: 0") + plain.record.start, 0.5 + 1.428, 0.1);
  EXPECT_NEAR(used("threshold: 10 mm, margin: 0.3 s"), used("threshold: 10 mm, margin: 0") + 0.3, 1e-12);
  EXPECT_NEAR(used("threshold: 10 mm"), used("threshold: 10 mm, margin: 0.5 s"), 1e-12);
  EXPECT_GT(used("threshold: 1 mm, margin: 0"), used("threshold: 10 mm, margin: 0") + 0.3);
  EXPECT_EQ(record("").record.used, record("threshold: 0.5 mm").record.used);
}

/// Held at 40 mm, released at 0.5 s; it swings about 5 mm and is still moving where the record ends.
void unknown_rest_positions() {
  std::vector<double> y(1100);
  for (int k = 0; k < 1100; ++k) {
    const double since = k / 500.0 - 0.5;
    y[std::size_t(k)] = since <= 0 ? 0.04 : 0.005 + 0.035 * std::exp(-0.5 * since) * std::cos(9.42 * since);
  }
  std::vector<double> rate(y.size(), 0.0);
  for (std::size_t k = 1; k < y.size(); ++k) rate[k] = 500.0 * (y[k] - y[k - 1]);
  write_file("record.csv", csv_of(500.0, {{"y", y}, {"v", rate}}));
  const auto deviation = [](const std::string& text) {
    const auto study = with_record("file: record.csv, free_response: {" + text + "}",
                                   {{"sensors", "{v: {velocity: s.b, noise: 1}, y: {displacement: s.b, noise: 1}}"}});
    EXPECT_FALSE(study.record->free_response->rest);
    return study.record->free_response->deviation;
  };
  // The last whole swing has its peaks 3 and 4 half periods behind the release.
  const double half_period = 3.14159265358979323846 / 9.42;
  near(deviation("")[1], 0.035 * (std::exp(-1.5 * half_period) + std::exp(-2.0 * half_period)) / 2,
       0.003);  // found .0014
  near(deviation("rest_std: 2 mm")[1], 2e-3);
  near(deviation("rest_std: 2 mm")[0], deviation("")[0]);  // of displacements alone
}

/// The same check of the record of a validation.
std::function<void()> in_validation(void (*check)()) {
  return [check] {
    of_validation = true;
    check();
    of_validation = false;
  };
}

Study with_validation(const std::string& text) {
  std::vector<double> rising(40), falling(40);
  for (std::size_t k = 0; k < 40; ++k) rising[k] = double(k), falling[k] = 39.0 - double(k);
  write_file("record.csv", csv_of(10.0, {{"y", rising}, {"f", falling}}));
  write_file("other.csv", csv_of(10.0, {{"y", falling}}));
  write_file("input.csv", csv_of(10.0, {{"f", rising}}));
  return study_of(lumped_case({{"simulate", ""},
                               {"record", "{file: record.csv, end: 0.3 s}"},
                               {"excitation", "{f: {force: s.a, file: record.csv, channel: f}}"},
                               {"estimate", "{unknown: {c.k: {initial: 400, std: 80}}}"},
                               {"validate", "{" + text + "}"}}));
}

void parts_of_validations() {
  const auto study = with_validation("start: 0.5 s, end: 1.8 s");
  near(study.validation->record.record.values.row(0).transpose(), Eigen::VectorXd::LinSpaced(14, 5, 18));
  near(study.validation->record.record.start, 0.5);
  near(with_validation("start: 0.5 s").validation->record.record.end(), 3.9);
  near(study.validation->signals.at(0)->sample(0.5, 1.0, 1)(0, 0), 34.0);
}

void starts_of_validations() {
  near(with_validation("start: 0.9 s").validation->lead_in, 0.3, many_roundings);  // a tenth
  near(with_validation("start: 0.9 s, lead_in: 0.2 s").validation->lead_in, 0.2);
  EXPECT_FALSE(with_validation("start: 0.9 s, initial: unknown").validation->from_rest);
  EXPECT_TRUE(with_validation("start: 0.9 s, initial: rest").validation->from_rest);
}

void inputs_of_validations() {
  const auto study = with_validation("record: {file: other.csv}, excitation: {f: input.csv}");
  near(study.validation->record.record.values(0, 2), 37.0);
  near(study.validation->signals.at(0)->sample(0.2, 1.0, 1)(0, 0), 2.0);
  near(study.structure->signals.at(0)->sample(0.2, 1.0, 1)(0, 0), 37.0);
}

}  // namespace

KeyChecks sensor_and_record_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add("sensors.*.", {"displacement", "velocity", "acceleration"}, motions);
  add("sensors.*.", {"force", "deformation", "rate"}, connector_quantities);
  add("sensors.*.", {"strain"}, strains);
  add("sensors.*.", {"mass", "mass_at"}, load_cells_with_mass);
  add("sensors.*.", {"file"}, channels_of_other_files);
  add("sensors.*.", {"relative"}, relative_to_the_base);
  add("sensors.*.", {"noise"}, noise_is_absolute_or_a_part_of_the_rms);
  for (const std::string family : {"butterworth", "bessel"})
    add("sensors.*.chain[]." + family + ".", {"order", "low_pass", "high_pass", "band_pass"}, filters);
  add("sensors.*.chain[].", {"delay", "resonance.frequency", "resonance.damping", "gain"}, other_stages);
  add("sensors.*.", {"channel"}, record_columns);
  add("sensors.*.", {"unit"}, units_of_channels);
  add("sensors.*.", {"accept_constant"}, constant_channels);
  add("sensors.*.", {"gain", "offset", "delay", "drift"}, calibrations_of_channels);
  add("record.prepare.",
      {"remove_offset.from", "remove_offset.to", "remove_trend", "high_pass", "low_pass", "sample_rate"}, preparations);
  add("record.", {"file"}, record_columns);
  add("record.", {"sample_rate", "unit"}, record_units_and_rates);
  add("record.", {"dataset"}, record_datasets);
  add("record.", {"start", "end"}, record_window);
  add("record.", {"skip_missing"}, missing_samples);
  add("record.", {"repair_splice"}, splices_are_repaired);
  add("record.free_response.", {"delay", "threshold", "margin"}, free_responses);
  add("record.free_response.", {"rest_std"}, unknown_rest_positions);
  KeyChecks of_records;
  for (const auto& [key, check] : keys)
    if (key.starts_with("record.")) of_records["validate." + key] = in_validation(*check.target<void (*)()>());
  keys.merge(of_records);
  add("validate.", {"start", "end"}, parts_of_validations);
  add("validate.", {"lead_in", "initial"}, starts_of_validations);
  add("validate.", {"excitation"}, inputs_of_validations);
  return keys;
}

}  // namespace kalfem::wiring
