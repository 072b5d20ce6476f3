#pragma once

#include <string_view>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// A column's title taken apart: "a [g]" and "a (g)" are the name a and the unit g.
///
/// Brackets at the end always hold a unit. Parentheses hold one where they are written like one ("(m/s^2)", "(kN)",
/// "(dB)"); otherwise they belong to the name, as in "Displacement (filtered)" or "Channel (2)".
Channel channel_of(std::string_view title);

/// Column of the channel that `wanted` names with or without its unit, or -1.
Eigen::Index find_channel(const std::vector<Channel>& channels, std::string_view wanted);

}  // namespace kalfem
