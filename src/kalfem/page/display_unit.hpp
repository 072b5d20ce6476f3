// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kalfem {

/// The number of the last place at which a deviation has two digits: -2 for 0.31. The deviation is rounded first,
/// because 0.0996 has its two digits, 0.10, one place further left. `deviation`: finite and positive.
int last_place(double deviation);
/// A value rounded there, without a power of ten: 17984 for 17984.3 +- 31, 12350 for 12345 +- 450.
std::string rounded_at(int place, double value);

/// How people read one quantity: with a prefix of its unit that brings it between 1 and 1000, "210.0 GPa" for
/// 2.1e11 Pa, and with the digits that its deviation leaves.
class DisplayUnit {
public:
  /// `unit`: as the library has it ("N s/m"). The first of `values` that is finite and not zero decides the prefix.
  /// Units that begin with another symbol than N, Pa, m, s, Hz, V, A, J or W to the first power keep what they are;
  /// lengths and times get small prefixes only.
  /// `own`: the unit that the user wrote, which stays where the value reads well in it; empty: none.
  DisplayUnit(const std::string& unit, const std::vector<double>& values, const std::string& own = {});

  [[nodiscard]] const std::string& unit() const { return unit_; }  ///< "GPa"
  [[nodiscard]] double scaled(double value) const { return value * factor_; }
  /// Two digits of the deviation are shown; four of the value without one (NaN or zero). "-" for what is not finite.
  [[nodiscard]] std::string value(double value, double deviation) const;
  [[nodiscard]] std::string value(double value) const;
  [[nodiscard]] std::string deviation(double deviation) const { return value(deviation, deviation); }

private:
  std::string unit_;
  double factor_ = 1.0;
};

}  // namespace kalfem
