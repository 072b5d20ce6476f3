// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Seconds in one of a time column's unit; nothing where it is no unit of time.
std::optional<double> seconds_in(const std::string& unit);

/// Whether a unit is known and measures something else than time.
bool is_unit_but_of_time(const std::string& unit);

/// Whether a cell of a line of units may hold one: "[mm]", "(g)", "m/s^2", "-" or nothing.
bool is_unit_cell(std::string_view cell);

/// Titles of a table of so many columns, from its line of names and its line of units; both may be empty. Columns
/// without a name are `column_1`, `column_2`, ... Text that is no UTF-8 is taken as Windows-1252.
std::vector<Channel> table_titles(const std::vector<std::string_view>& names,
                                  const std::vector<std::string_view>& units, std::size_t width);

/// The names in the last comment (# or %) above the first line of a table: as many as it has columns, whatever
/// separates them, and none of them a number. Empty where there are none.
std::vector<std::string_view> names_in_comment(std::string_view text, const TextLine& first, char separator,
                                               char decimal, std::size_t width);

/// The sampling rate [Hz] that a line above a table states: "Sample rate: 1000 Hz", "dt;0,001;s".
std::optional<double> stated_rate(std::string_view line, char decimal);

}  // namespace kalfem
