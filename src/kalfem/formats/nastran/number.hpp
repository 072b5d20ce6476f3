#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace kalfem::nastran {

/// The whole number that fills the field, or nothing.
std::optional<std::int64_t> parse_integer(std::string_view field);

/// The finite number that fills the field, or nothing: 1.5, .5, 7, 1.5E3, 1.5e+3, 1.5D3, and 1.5+3 or 1.5-3 with the
/// exponent after its sign alone.
std::optional<double> parse_real(std::string_view field);

}  // namespace kalfem::nastran
