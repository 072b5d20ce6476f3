// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kalfem::rewriting {

/// The number as a field of at most `width` columns (8 or 16) states it best, with a decimal point as Nastran wants it:
/// "7850.", ".0012346", "2.1+11", "20512.+7".
std::string nastran_real(double value, std::size_t width);

/// A field of a line that gets another content.
struct LineEdit {
  std::size_t at = 0, length = 0;  ///< the present content, in the line
  std::variant<double, std::string> content;
};

struct RewrittenLine {
  std::string text;                   ///< without the line's end; two lines where it became one of large fields
  std::vector<std::string> contents;  ///< of the edits, in their order
  bool became_large = false;
};

/// A line of bulk data in small, large or free field without tabs, with other contents of some fields. Fields of 8
/// columns that would round a number by more than 2e-6 make the line one of large fields.
RewrittenLine rewritten_line(std::string_view line, const std::vector<LineEdit>& edits);

}  // namespace kalfem::rewriting
