// SPDX-License-Identifier: Apache-2.0
#include <complex>
#include <numbers>

#include "casefile/updating_probes.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/updating/frf_residual.hpp"

/// Keys of the frequency responses that an updating compares: residuals against their definition.
namespace kalfem::wiring {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// H = (i omega)^derivative (K + i omega C - omega^2 M)^-1 e_input at the lines, lines x 2.
MatrixXcd responses(const VectorXd& lines, int input, int derivative) {
  const auto [m, k] = matrices();
  const auto modes = modes_at();
  const VectorXd rates = 2 * 0.02 * 2 * std::numbers::pi * modes.frequencies;
  const MatrixXd c = m * modes.shapes * rates.asDiagonal() * modes.shapes.transpose() * m;
  MatrixXcd h(lines.size(), 2);
  for (Index i = 0; i < lines.size(); ++i) {
    const Complex s(0.0, 2 * std::numbers::pi * lines[i]);
    const MatrixXcd z = m.cast<Complex>() * s * s + c.cast<Complex>() * s + k.cast<Complex>();
    h.row(i) = (std::pow(s, derivative) * z.inverse().col(input)).transpose();
  }
  return h;
}

const VectorXd lines = VectorXd::LinSpaced(20, 0.5, 5.25);

void write_table(const std::string& name, const MatrixXcd& values) {
  std::ostringstream text;
  text.precision(17);
  text << "f,a_re,a_im,b_re,b_im\n";
  for (Index i = 0; i < values.rows(); ++i)
    text << lines[i] << "," << values(i, 0).real() << "," << values(i, 0).imag() << "," << values(i, 1).real() << ","
         << values(i, 1).imag() << "\n";
  write_file(name, text.str());
}

/// Measured: the model's responses 10 % greater and 0.1 rad ahead.
const Complex error = 1.1 * std::polar(1.0, 0.1);

VectorXd frf_residual(const std::string& more, int derivative = 2, const std::string& outputs = "a, b") {
  write_table("frf.csv", error * responses(lines, 0, derivative));
  return residual_of("frf: s, inputs: [{force: a, file: frf.csv}], outputs: [" + outputs + "]" + more);
}

}  // namespace

void frequency_responses_of_tables() {
  const double magnitude = -std::log(1.1), phase = -0.1;
  const auto check = [&](const VectorXd& values, double deviation) {
    ASSERT_EQ(values.size(), 80);
    for (Index i = 0; i < values.size(); i += 2) {
      // rounding of the table's digits, in deviations: found 1e-13
      EXPECT_NEAR(values[i], magnitude / deviation, 2e-12);
      EXPECT_NEAR(values[i + 1], phase / deviation, 2e-12);
    }
  };
  check(frf_residual(", floor: 0"), 0.05);
  check(frf_residual(", floor: 0, deviation: 0.2"), 0.2);
  check(frf_residual(", floor: 0, quantity: acceleration"), 0.05);
  check(frf_residual(", floor: 0, quantity: velocity", 1), 0.05);
  check(frf_residual(", floor: 0, quantity: displacement", 0), 0.05);
  check(frf_residual(", floor: 0, compare: logarithm"), 0.05);
}

namespace {

/// With a floor the deviation of a line is (0.05 |H|)^2 + (floor rms)^2; differences are those of the complex values.
void frequency_response_differences() {
  const MatrixXcd model = responses(lines, 0, 2), measured = error * model;
  for (const double floor : {0.05, 0.3}) {
    const VectorXd values = frf_residual(", compare: difference, floor: " + std::to_string(floor));
    Index row = 0;
    for (Index line = 0; line < 20; ++line)
      for (Index output = 0; output < 2; ++output, row += 2) {
        const double rms = std::sqrt(measured.col(output).squaredNorm() / 20.0);
        const double sigma = std::hypot(0.05 * std::abs(measured(line, output)), floor * rms);
        const Complex difference = (model(line, output) - measured(line, output)) / sigma;
        // rounding
        EXPECT_NEAR(values[row], difference.real(), 1e-12);
        EXPECT_NEAR(values[row + 1], difference.imag(), 1e-12);
      }
  }
  near(frf_residual(", compare: difference"), frf_residual(", compare: difference, floor: 0.05"));
}

void frequency_response_selection() {
  EXPECT_EQ(frf_residual(", bands: [[1, 2], [3, 3.3]]").size(), 4 * (5 + 2));
  EXPECT_EQ(frf_residual("").size(), 80);
  // Columns by name, in the outputs' order.
  write_table("frf.csv", responses(lines, 1, 2));
  const auto columns = [](const std::string& text) { return residual_of("frf: s, inputs: [" + text).norm(); };
  // rounding of eighty values
  EXPECT_LT(columns("{force: b, file: frf.csv}], outputs: [a, b]"), 2e-12);
  EXPECT_LT(columns("{force: b, file: frf.csv, columns: [b, a]}], outputs: [b, a]"), 2e-12);
  EXPECT_LT(columns("{force: b, file: frf.csv, columns: [b]}], outputs: [b]"), 1e-12);
  EXPECT_GT(columns("{force: b, file: frf.csv, columns: [b, a]}], outputs: [a, b]"), 1.0);
  EXPECT_GT(columns("{force: a, file: frf.csv}], outputs: [a, b]"), 1.0);
}

void frequency_responses_to_a_ground() {
  // z per acceleration of the ground: [K + s C (relative) + s^2 M] (z - 1 r) = -s^2 M 1 r.
  const auto [m, k] = matrices();
  const MatrixXcd forces = responses(lines, 0, 0) * 2.0 + responses(lines, 1, 0) * 3.0;  // of M 1
  MatrixXcd h(lines.size(), 2);
  for (Index i = 0; i < lines.size(); ++i) {
    const Complex s(0.0, 2 * std::numbers::pi * lines[i]);
    h.row(i) = (1.0 - s * s * forces.row(i).array()).matrix();
  }
  write_table("frf.csv", h);
  // rounding
  EXPECT_LT(residual_of("frf: s, inputs: [{ground: ground, file: frf.csv}], outputs: [a, b]").norm(), 2e-12);
}

/// Columns of magnitudes, plain or in decibels, where their names do not say what they hold.
void frequency_response_columns() {
  const auto magnitudes = responses(lines, 0, 2).cwiseAbs().eval();
  const auto residual = [&](const std::string& values, double (*written)(double)) {
    std::ostringstream text;
    text.precision(17);
    text << "f,a,b\n";
    for (Index i = 0; i < lines.size(); ++i)
      text << lines[i] << "," << written(1.1 * magnitudes(i, 0)) << "," << written(1.1 * magnitudes(i, 1)) << "\n";
    write_file("magnitudes.csv", text.str());
    return residual_of("frf: s, inputs: [{force: a, file: magnitudes.csv, values: " + values +
                       "}], outputs: [a, b], compare: log_magnitude, floor: 0");
  };
  const VectorXd expected = VectorXd::Constant(40, -std::log(1.1) / 0.05);
  near(residual("magnitude", [](double h) { return h; }), expected, many_roundings);
  near(residual("dB", [](double h) { return 20 * std::log10(h); }), expected, many_roundings);
  // Complex numbers without `values` as well.
  std::ostringstream text;
  text.precision(17);
  text << "f,a,b\n";
  const MatrixXcd h = error * responses(lines, 0, 2);
  for (Index i = 0; i < lines.size(); ++i) {
    text << lines[i];
    for (const Complex each : {h(i, 0), h(i, 1)})
      text << "," << each.real() << std::showpos << each.imag() << std::noshowpos << "j";
    text << "\n";
  }
  write_file("complex.csv", text.str());
  for (const std::string values : {"", ", values: complex"})
    near(residual_of("frf: s, inputs: [{force: a, file: complex.csv" + values +
                     "}], outputs: [a, b], compare: log_magnitude, floor: 0"),
         expected, 1e-6);
}

/// Measured: responses 1.3 and 0.8 times the model's, which one factor cannot make good and two can.
void frequency_response_scales() {
  write_table("frf.csv", responses(lines, 0, 2) * Eigen::Vector2cd(1.3, 0.8).asDiagonal());
  const auto scales = [](const std::string& text) {
    const auto residuals = residuals_of(with_comparison(
        "frf: s, inputs: [{force: a, file: frf.csv}], outputs: [a, b], compare: log_magnitude, floor: 0" + text));
    const auto& frf = dynamic_cast<const FrfResidual&>(*residuals[0].continuation_steps[0]);
    return frf.scales(frf.model_responses(VectorXd::Constant(1, 800.0))).at(0);
  };
  for (const std::string text : {"", ", scale: fixed"}) near(scales(text), vector({1, 1}));
  near(scales(", scale: per_response"), vector({1.3, 0.8}), many_roundings);
  // Equal deviations of all logarithms: the geometric mean.
  const double mean = std::sqrt(1.3 * 0.8);
  near(scales(", scale: per_input"), vector({mean, mean}), many_roundings);
}

void smoothed_frequency_responses() {
  write_table("frf.csv", responses(lines, 0, 2));
  const auto continuation_steps = [](const std::string& text) {
    return residuals_of(with_comparison("frf: s, inputs: [{force: a, file: frf.csv}], outputs: [a, b]" + text))[0]
        .continuation_steps.size();
  };
  EXPECT_EQ(continuation_steps(""), 1u);
  EXPECT_EQ(continuation_steps(", smoothing: 0.9 Hz"), smoothing_widths(0.9, 0.09).size());
}

/// A record of noise at one mass: the local fits of its spectra are the model's responses at lines of the whole record.
/// For magnitudes alone H1 has the lines that the length of the segments sets.
void frequency_responses_of_records() {
  const auto simulated =
      run(with_update("", {{"update", ""},
                           {"excitation",
                            "{f: {force: s.a, random: {rms: 10, band: [0.1, 40], duration: 80, "
                            "fade_in: 0}}}"},
                           {"sensors", "{a: {acceleration: s.a, noise: 0}, b: {acceleration: s.b, noise: 0}}"},
                           {"simulate", "{duration: 80 s, sample_rate: 100 Hz, tolerance: 1e-2}"}}),
          "simulate");
  const MatrixXd outputs = simulated.get<SimulationOutcome>().reference.sensors;
  const auto column = [&](Index j) { return std::vector<double>(outputs.row(j).begin(), outputs.row(j).end()); };
  const auto study = with_update("", {{"update", ""},
                                      {"excitation",
                                       "{f: {force: s.a, random: {rms: 10, band: [0.1, 40], duration: 80, fade_in: "
                                       "0}}}"},
                                      {"simulate", "{duration: 80 s, sample_rate: 100 Hz}"}});
  const VectorXd force = study.structure->signals[0]->sample(0.0, 0.01, 8001).col(0).matrix();
  const std::vector<double> input(force.begin(), force.end());
  write_file("shaker.csv", csv_of(100.0, {{"a", column(0)}, {"b", column(1)}, {"p", input}}));
  MatrixXd table(8001, 3);
  table << force, outputs.transpose();
  const auto path = write_file("shaker.h5", "");
  {
    auto file = Hdf5File::create(path.string());
    file.write_matrix("/wrong", 2.0 * MatrixXd::Ones(8001, 3));
    file.write_matrix("/test", table);
  }
  const auto compared = [](const std::string& input_text, const std::string& more = ", bands: [[0.4, 6]]") {
    const auto residuals =
        residuals_of(with_comparison("frf: s, inputs: [{force: a, " + input_text + "}], outputs: [a, b]" + more));
    return dynamic_cast<const FrfResidual&>(*residuals[0].continuation_steps[0]).compared().at(0);
  };
  const std::string magnitudes = ", compare: log_magnitude, bands: [[5, 6]]";
  for (const std::string text :
       {"record: shaker.csv, input: p", "record: shaker.csv, input: p, columns: [a, b]",
        "record: shaker.h5, dataset: /test, sample_rate: 100, input: '0', columns: ['1', '2']"}) {
    const auto whole = compared(text), usual = compared(text, magnitudes),
               longer = compared(text + ", segment: 20 s", magnitudes);
    near(whole.lines[1] - whole.lines[0], 0.0125, many_roundings);
    near(usual.lines[1] - usual.lines[0], 0.125, many_roundings);
    near(longer.lines[1] - longer.lines[0], 0.05, many_roundings);
    const auto line = [&](double f) { return Index(std::lround((f - whole.lines[0]) / 0.0125)); };
    for (const double f : {2.5, 5.5}) {
      const MatrixXcd expected = responses(VectorXd::Constant(1, f), 0, 2);
      for (Index j : {0, 1})
        EXPECT_LT(std::abs(whole.values(line(f), j) / expected(0, j) - 1.0), 0.015) << text << " at " << f << " Hz";
    }
  }
  EXPECT_THROW(compared("record: shaker.h5, dataset: /test, input: '0', columns: ['1', '2']"), InvalidInput);
}

}  // namespace

KeyChecks compared_response_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add(compare_at, {"frf", "quantity"}, frequency_responses_of_tables);
  add(compare_at, {"compare", "floor"}, frequency_response_differences);
  add(compare_at, {"bands", "outputs", "inputs[].file", "inputs[].columns", "inputs[].force"},
      frequency_response_selection);
  add(compare_at, {"inputs[].ground"}, frequency_responses_to_a_ground);
  add(compare_at, {"inputs[].values"}, frequency_response_columns);
  add(compare_at, {"scale"}, frequency_response_scales);
  add(compare_at, {"smoothing"}, smoothed_frequency_responses);
  add(compare_at, {"inputs[].record", "inputs[].input", "inputs[].segment", "inputs[].dataset", "inputs[].sample_rate"},
      frequency_responses_of_records);
  return keys;
}

}  // namespace kalfem::wiring
