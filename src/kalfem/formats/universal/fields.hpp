// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// The number that fills the text between blanks, as Fortran and C write it: 1.5, -.5E+01, 1.D-3, 1.00000-101 (three
/// digits of exponent leave no room for its letter), NaN. Nothing where it is no number, or is infinite.
std::optional<double> universal_number(std::string_view text);

/// A whole number; blanks are zero, as in Fortran. Nothing where it is none.
std::optional<long> universal_integer(std::string_view text);

/// Appends the numbers of a line of samples. They stand between blanks; where they do not, in columns of these widths,
/// over and over; and where they do not either, one ends where the next can only begin. Returns the text that is no
/// number, empty where there is none.
std::string append_numbers(std::string_view line, std::span<const int> widths, std::vector<double>& numbers);

/// Whole numbers in columns of one width; between blanks where the columns hold none. Nothing where there are other
/// things.
std::optional<std::vector<long>> integers_of(std::string_view line, std::size_t width);

/// Text between blanks.
std::vector<std::string_view> words_of(std::string_view line);

/// Columns of a line, from 0, without blanks around them; shorter or empty where the line ends.
std::string_view columns(std::string_view line, std::size_t first, std::size_t count);

}  // namespace kalfem
