#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/formats/abaqus/problems.hpp"

namespace kalfem::abaqus {

/// A keyword line: "*SHELL SECTION, ELSET=skin, MATERIAL=al".
struct Keyword {
  std::string name;                                             ///< capitals without blanks: SHELLSECTION
  std::string title;                                            ///< for messages: "*SHELL SECTION"
  std::vector<std::pair<std::string, std::string>> parameters;  ///< names like the keyword's; values as they stand
  Where where;

  [[nodiscard]] bool has(std::string_view parameter) const;
  /// Value of a parameter, "" where it is absent or has none.
  [[nodiscard]] std::string get(std::string_view parameter) const;
  /// The value in capitals without blanks, for words of the format.
  [[nodiscard]] std::string word(std::string_view parameter) const;
};

/// Takes a keyword line apart. `line` begins with its asterisk.
Keyword parse_keyword(std::string_view line, const Where& where);

}  // namespace kalfem::abaqus
