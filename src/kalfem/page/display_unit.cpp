// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/display_unit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "kalfem/base/units.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

constexpr std::array small_prefixes{"", "m", "µ", "n"};
constexpr std::array large_prefixes{"", "k", "M", "G", "T"};

/// "N" of "N s/m"; empty where it has another power than one.
std::string_view first_symbol(std::string_view unit) {
  const auto end = std::ranges::find_if_not(unit, [](char c) { return std::isalpha(static_cast<unsigned char>(c)); });
  if (end != unit.end() && *end != ' ' && *end != '/') return {};
  return unit.substr(0, static_cast<std::size_t>(end - unit.begin()));
}

/// Power of a thousand, as far as there are prefixes.
int thousands(std::string_view symbol, double value) {
  static constexpr std::array<std::string_view, 9> known{"N", "Pa", "m", "s", "Hz", "V", "A", "J", "W"};
  if (std::ranges::find(known, symbol) == known.end()) return 0;
  const int power = static_cast<int>(std::floor(std::log10(std::abs(value)) / 3.0 + 1e-9));
  const bool small_only = symbol == "m" || symbol == "s";
  return std::clamp(power, 1 - static_cast<int>(small_prefixes.size()),
                    small_only ? 0 : static_cast<int>(large_prefixes.size()) - 1);
}

}  // namespace

int last_place(double deviation) { return std::stoi(fmt::format("{:.1e}", deviation).substr(4)) - 1; }

std::string rounded_at(int place, double value) {
  const double step = std::pow(10.0, std::max(0, place));
  return fmt::format("{:.{}f}", place > 0 ? step * std::round(value / step) : value, std::max(0, -place));
}

DisplayUnit::DisplayUnit(const std::string& unit, const std::vector<double>& values, const std::string& own)
    : unit_(unit) {
  const auto decides = std::ranges::find_if(values, [](double v) { return std::isfinite(v) && v != 0.0; });
  if (decides == values.end()) return;
  if (!own.empty()) {
    constexpr double least = 1e-3, most = 1e6;  // what reads well in any unit
    factor_ = 1.0 / parse_unit_as(own, unit).factor;
    unit_ = own;
    if (const double shown = std::abs(scaled(*decides)); shown >= least && shown < most) return;
  }
  const int power = thousands(first_symbol(unit), *decides);
  factor_ = std::pow(1000.0, -power);
  unit_ =
      (power < 0 ? small_prefixes[static_cast<std::size_t>(-power)] : large_prefixes[static_cast<std::size_t>(power)]) +
      unit;
}

std::string DisplayUnit::value(double value) const { return four_digits(value * factor_); }

std::string DisplayUnit::value(double value, double deviation) const {
  const double shown = value * factor_, last = deviation * factor_;
  if (!std::isfinite(shown) || !std::isfinite(last) || last == 0.0) return four_digits(shown);
  constexpr double plain = 1e6;  // beyond it, and far below one, powers of ten are shorter
  const int place = last_place(std::abs(last));
  if (std::abs(shown) >= plain || place < -7) return four_digits(shown);
  return rounded_at(place, shown);
}

}  // namespace kalfem
