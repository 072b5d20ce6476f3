// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <sstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/study/study.hpp"

/// Small cases that read a record: a mass of 2 kg on a spring of 800 N/m (20 rad/s) and a dashpot of 2 N s/m, moving
/// as x = A sin(omega t) under the force that makes it do so.
namespace kalfem::record_cases {

constexpr double mass = 2.0, stiffness = 800.0, dashpot = 2.0;
constexpr double amplitude = 0.02, omega = 2.0 * std::numbers::pi * 2.5, rate = 100.0;

inline double displacement(double t) { return amplitude * std::sin(omega * t); }
inline double velocity(double t) { return amplitude * omega * std::cos(omega * t); }
inline double acceleration(double t) { return -omega * omega * displacement(t); }
inline double force(double t) { return mass * acceleration(t) + dashpot * velocity(t) + stiffness * displacement(t); }

/// A column of a record: its title and how a sample is written.
struct Column {
  std::string title;
  std::function<std::string(double time)> cell;
};

/// "%.12g" of factor * value.
inline std::function<std::string(double)> written(double (*value)(double), double factor = 1.0) {
  return [=](double t) {
    char text[40];
    std::snprintf(text, sizeof text, "%.12g", factor * value(t));
    return std::string(text);
  };
}

inline std::string table(const std::vector<Column>& columns, double duration = 4.0) {
  std::ostringstream text;
  text << "t";
  for (const auto& column : columns) text << "," << column.title;
  for (int k = 0; k <= int(std::lround(duration * rate)); ++k) {
    text << "\n" << k / rate;
    for (const auto& column : columns) text << "," << column.cell(k / rate);
  }
  return text.str() + "\n";
}

inline std::vector<Column> si_columns() {
  return {{"F", written(force)}, {"x", written(displacement)}, {"a", written(acceleration)}};
}

const std::string sound_case = R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m, damping: 2 N s/m}]}
excitation:
  F: {force: s.m, file: record.csv, channel: F}
sensors:
  x: {displacement: s.m, noise: 0.01 mm}
  a: {acceleration: s.m, noise: 1 %}
record: {file: record.csv}
estimate:
  unknown: {s.k.stiffness: {initial: 760 N/m, std: 20 %}}
  estimate_initial_state: true
  initial_state: {s.m: {displacement_std: 50 mm, velocity_std: 1 m/s}}
  settle: 0.5 s
)";

/// A folder with a case and its record.
class RecordCase : public testing::Test {
protected:
  void write_record(const std::vector<Column>& columns, double duration = 4.0) {
    std::ofstream(folder_ / "record.csv") << table(columns, duration);
  }
  /// The study of the sound case with some of its text changed.
  [[nodiscard]] Study load(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
    std::string text = sound_case;
    for (const auto& [from, to] : changes) {
      const auto place = text.find(from);
      EXPECT_NE(place, std::string::npos) << from;
      if (place != std::string::npos) text.replace(place, from.size(), to);
    }
    std::ofstream(folder_ / "case.yaml") << text;
    return load_study((folder_ / "case.yaml").string());
  }
  [[nodiscard]] std::string errors(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
    try {
      static_cast<void>(load(changes));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }
  static void expect_in(const std::string& text, const std::vector<std::string>& pieces) {
    for (const auto& piece : pieces) EXPECT_NE(text.find(piece), std::string::npos) << piece << "\nin: " << text;
  }

  ScratchFolder folder_{"record-case"};
};

}  // namespace kalfem::record_cases
