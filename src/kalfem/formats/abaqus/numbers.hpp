#pragma once

#include <optional>
#include <string>
#include <vector>

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

}  // namespace kalfem::abaqus
