// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/formats/universal/universal.hpp"

namespace kalfem {

/// @name Text of universal files
///@{
std::string integer_column(long value, int width);
/// 1.50000E+00 in so many columns with so many decimals.
std::string real_column(double value, int width, int decimals);
/// Text without line breaks, NONE where it is empty, cut at a character and filled with blanks to its columns.
std::string text_column(const std::string& text, std::size_t width);
/// A dataset between its marks.
std::string dataset(int number, const std::string& content);
///@}

/// Datasets 58 or 58b of a channel and of a function of frequency.
std::string function_dataset(const MeasuredChannel& channel, bool binary);
std::string function_dataset(const MeasuredFunction& function, bool binary);

}  // namespace kalfem
