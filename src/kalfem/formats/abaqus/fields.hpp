#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

/// The field as a number, `otherwise` where it is empty; what is neither is a problem that names `what`.
double number_or(const DataLine& line, std::size_t field, double otherwise, const std::string& what,
                 Problems& problems);
/// The field as a number; an empty one is a problem too, and nothing is returned.
std::optional<double> number_at(const DataLine& line, std::size_t field, const std::string& what, Problems& problems);
/// All fields of some lines from `first` on, as one row; empty ones are 0.
std::vector<double> all_numbers(const Block& block, std::size_t first_line, const std::string& what,
                                Problems& problems);
/// The value of a parameter as a number; nothing where it is absent, a problem where it is none.
std::optional<double> number_parameter(const Keyword& keyword, std::string_view parameter, Problems& problems);
/// The line of a block, an empty one behind the last.
const DataLine& line_of(const Block& block, std::size_t index);

/// Without blanks around it.
std::string_view trimmed_field(std::string_view text);
/// What a message can show of a field: at most 40 printable characters.
std::string to_string(std::string_view field);

/// The number that fills the whole field, exponents by E or D; nothing where it is none or not finite.
std::optional<double> to_number(std::string_view field);
std::optional<std::int64_t> to_integer(std::string_view field);
/// The number of a node or element: an integer from 1 to 10^12; nothing else.
std::optional<std::int64_t> to_label(std::string_view field);

/// Gives the fields of a data line one after the other: between commas, without blanks and quotation marks around them.
class FieldCursor {
public:
  explicit FieldCursor(std::string_view line) : rest_(line) {}
  /// False behind the last field. A comma at the end of the line has no field behind it.
  bool next(std::string_view& field);

private:
  std::string_view rest_;
};

/// All fields of a line.
std::vector<std::string> split_fields(std::string_view line);

}  // namespace kalfem::abaqus
