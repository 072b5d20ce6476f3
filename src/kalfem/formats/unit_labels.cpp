// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/unit_labels.hpp"

#include <array>
#include <string_view>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

bool is_known(const std::string& unit) {
  try {
    parse_unit(unit);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

}  // namespace

std::string understood_unit(std::string label) {
  const auto trim = [&] { label = std::string(trimmed(label)); };
  trim();
  if (label.size() > 2 &&
      ((label.front() == '[' && label.back() == ']') || (label.front() == '(' && label.find(')') == label.size() - 1)))
    label = label.substr(1, label.size() - 2);
  trim();
  const std::string small = lower_case(label);
  for (const char* nothing : {"none", "unknown", "null", "n/a", "nounit", "no unit", "no units"})
    if (small == nothing) return {};
  if (label.empty() || is_known(label) || label == "G") return label;
  std::string changed = small;
  constexpr std::array<std::pair<std::string_view, std::string_view>, 14> words = {{{"newtons", "N"},
                                                                                    {"newton", "N"},
                                                                                    {"seconds", "s"},
                                                                                    {"second", "s"},
                                                                                    {"sec", "s"},
                                                                                    {"metres", "m"},
                                                                                    {"metre", "m"},
                                                                                    {"meters", "m"},
                                                                                    {"meter", "m"},
                                                                                    {"inches", "in"},
                                                                                    {"inch", "in"},
                                                                                    {"volts", "V"},
                                                                                    {"volt", "V"},
                                                                                    {"lbs", "lbf"}}};
  for (const auto& [word, symbol] : words)
    for (std::size_t at = changed.find(word); at != std::string::npos; at = changed.find(word, at + symbol.size()))
      changed.replace(at, word.size(), symbol);
  if (changed == "g's" || changed == "gs") return "g";
  if (changed == "degrees" || changed == "degree") return "deg";
  return is_known(changed) ? changed : label;
}

}  // namespace kalfem
