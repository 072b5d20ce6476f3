// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <optional>
#include <string>
#include <string_view>

#include "base/places.hpp"

// The figures of docs/accuracy.md. docs/figures.txt states each by a name and in the digits that the page shows, such
// as "chain.mu_k1.error = 0.24 %"; tests measure them. `scripts/accuracy` writes what they measure into the file and
// makes the page anew.

namespace kalfem::test {

/// A figure as the page shows it: 0.24 % is {0.0024, 0.0001}.
struct StatedFigure {
  double value = 0.0;
  double last_digit = 0.0;  ///< the unit of the last digit shown

  /// Measured values may differ by one in the last digit: another processor may round to the neighbour.
  [[nodiscard]] bool agrees_with(double measured) const { return std::abs(measured - value) <= 1.0001 * last_digit; }
};

/// "0.24 %", "-3.1", ".989", "1.6e-5" or "18"; nothing for what is no number.
inline std::optional<StatedFigure> parse_figure(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (end == text.c_str()) return std::nullopt;
  const std::string digits(text.c_str(), static_cast<const char*>(end));
  const std::string rest(end);
  const double unit = rest == " %" ? 0.01 : 1.0;
  if (unit == 1.0 && !rest.empty()) return std::nullopt;
  const auto exponent_at = std::min(digits.find('e'), digits.size());
  const auto point_at = digits.find('.');
  const double decimals = point_at < exponent_at ? static_cast<double>(exponent_at - point_at - 1) : 0.0;
  const double exponent = exponent_at < digits.size() ? std::stod(digits.substr(exponent_at + 1)) : 0.0;
  return StatedFigure{number * unit, unit * std::pow(10.0, exponent - decimals)};
}

/// The text that docs/figures.txt states for a name, without the comment that begins with #.
inline std::optional<std::string> stated_text(const std::string& name) {
  std::ifstream file(std::filesystem::path(source_folder()) / "docs/figures.txt");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(name + " = ")) continue;
    const std::string text = line.substr(name.size() + 3, line.find('#') - name.size() - 3);
    return text.substr(0, text.find_last_not_of(' ') + 1);
  }
  return std::nullopt;
}

/// Leaves what was measured where `scripts/accuracy` reads it: figures/<name> in the build folder.
inline void leave_figure(const std::string& name, double measured) {
  const auto folder = std::filesystem::path(command_file()).parent_path().parent_path() / "figures";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << std::setprecision(17) << measured << "\n";
}

/// Measures a figure of docs/accuracy.md: the test fails where it has moved beyond its stated digits. With
/// KALFEM_FIGURES=record in the environment it is only written down.
inline void expect_figure(const std::string& name, double measured) {
  leave_figure(name, measured);
  const char* mode = std::getenv("KALFEM_FIGURES");
  if (mode && std::string_view(mode) == "record") return;
  const auto text = stated_text(name);
  if (!text) {
    ADD_FAILURE() << "docs/figures.txt does not state the figure '" << name << "'; measured: " << measured;
    return;
  }
  const auto stated = parse_figure(*text);
  if (!stated) {
    ADD_FAILURE() << "docs/figures.txt states '" << *text << "' for '" << name << "': that is not a number";
    return;
  }
  EXPECT_TRUE(stated->agrees_with(measured))
      << "'" << name << "' is " << std::setprecision(6) << measured << ", but docs/accuracy.md states " << *text
      << ": find out why it moved; if the change is meant, run scripts/accuracy and commit what it writes";
}

}  // namespace kalfem::test
