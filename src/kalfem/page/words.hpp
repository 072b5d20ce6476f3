// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "kalfem/page/page.hpp"

namespace kalfem {

/// A table as text with aligned columns.
std::string to_text(const Table& table);
/// Without columns, other than the first, of which every row has only a dash.
Table without_empty_columns(Table table);

/// Four significant digits.
std::string four_digits(double value);
/// A ratio with two decimals, "-" where it is not finite.
std::string per_cent(double ratio);
/// "1 connector", "4 connectors".
std::string counted(Eigen::Index count, const std::string& noun);
/// "12 times faster than real time": of a filter, by the time of the record over that of its computation.
std::string speed_in_words(double ratio);
/// A change as a ratio with its sign and two decimals, "+1.37 %"; "0.00 %" where these show none, "-" where it is not
/// finite.
std::string signed_per_cent(double ratio);
/// With a capital at its start, unless the first word is a name such as body.3.mass or mu_k1.
std::string capitalised(std::string words);
/// A line of its own, capitalised.
std::string sentence(std::string words);

}  // namespace kalfem
