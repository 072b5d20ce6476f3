// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/case_control.hpp"

#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem::nastran {
namespace {

/// Words of a line in capitals, parted by blanks, commas and '='; a bracket belongs to the word before it.
std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  std::string text = upper_case(line.substr(0, line.find('$')));
  for (std::size_t at = text.find(" ("); at != std::string::npos; at = text.find(" (")) text.erase(at, 1);
  for (std::size_t at = 0; at < text.size();) {
    at = text.find_first_not_of(" \t\r,=", at);
    if (at == std::string::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t\r,=", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

/// "NAME" or "2.0*NAME".
std::pair<double, std::string> scaled_name(const std::string& word) {
  const std::size_t star = word.find('*');
  if (star == std::string::npos) return {1.0, word};
  return {parse_real(std::string_view(word).substr(0, star)).value_or(1.0), word.substr(star + 1)};
}

std::optional<Id> set_number(const std::vector<std::string>& words) {
  const auto number = words.size() > 1 ? parse_integer(words[1]) : std::nullopt;
  return number && *number > 0 && *number <= 2'147'483'647 ? std::optional(static_cast<Id>(*number)) : std::nullopt;
}

MatrixChoice matrices_of(const std::vector<std::string>& words) {
  MatrixChoice list;
  for (std::size_t i = 1; i < words.size(); ++i) list.push_back(scaled_name(words[i]));
  return list;
}

/// A command and what stands in its brackets: "TEMP(LOAD)".
struct Command {
  std::string name, option;

  explicit Command(const std::string& word) : name(word.substr(0, word.find('('))) {
    if (name.size() < word.size()) option = word.substr(name.size() + 1);
    if (const auto end = option.find(')'); end != std::string::npos) option.resize(end);
  }
  /// Commands may be shortened to four letters.
  [[nodiscard]] bool is(std::string_view full) const { return name.size() >= 4 && full.starts_with(name); }
};

/// TEMPERATURE(INITIAL, MATERIAL, LOAD or BOTH); both without brackets.
void read_temperature(const std::string& option, std::optional<Id> set, Subcase& subcase) {
  const bool both = option.empty() || option.starts_with("BOTH");
  if (option.starts_with("INIT")) subcase.initial_temperature = set;
  if (both || option.starts_with("MATE")) subcase.material_temperature = set;
  if (both || option.starts_with("LOAD")) subcase.thermal_load = set;
}

constexpr auto solution_names = std::to_array<std::pair<std::string_view, int>>({{"SESTATIC", 101},
                                                                                 {"SEMODES", 103},
                                                                                 {"SEBUCKL", 105},
                                                                                 {"NLSTATIC", 106},
                                                                                 {"SEDCEIG", 107},
                                                                                 {"SEDFREQ", 108},
                                                                                 {"SEDTRAN", 109},
                                                                                 {"SEMCEIG", 110},
                                                                                 {"SEMFREQ", 111},
                                                                                 {"SEMTRAN", 112},
                                                                                 {"NLTRAN", 129},
                                                                                 {"SEFLUTTR", 145},
                                                                                 {"DESOPT", 200}});

}  // namespace

void CaseControl::read(std::string_view line, const Place& place) {
  const auto words = words_of(line);
  if (words.empty()) return;
  const Command command(words.front());
  if (command.name == "SOL" && words.size() > 1) solution = words[1], solution_where = place;
  if (command.name == "SUBCASE" || command.name == "SUBCOM" || command.name == "SYM" || command.name == "SYMCOM")
    return begin_subcase(words, place);
  if (command.name == "LOAD")
    present_subcase().load = set_number(words);
  else if (command.name == "SPC")
    present_subcase().spc = set_number(words);
  else if (command.name == "MPC")
    present_subcase().mpc = set_number(words);
  else if (command.is("METHOD"))
    present_subcase().method = set_number(words);
  else if (command.is("DEFORM"))
    present_subcase().deform = set_number(words);
  else if (command.is("TEMPERATURE"))
    read_temperature(command.option, set_number(words), present_subcase());
  else if (command.is("STATSUB") && (command.option.empty() || command.option.starts_with("PREL")))
    present_subcase().preload = set_number(words), present_subcase().preload_where = place;
  else if (command.name == "K2GG")
    present_subcase().stiffness = matrices_of(words);
  else if (command.name == "M2GG")
    present_subcase().mass = matrices_of(words);
  else if (command.name == "B2GG")
    present_subcase().damping = matrices_of(words);
  else
    for (const char* known : {"K2PP", "M2PP", "B2PP", "K42GG", "TFL", "NSM"})
      if (command.name == known) unused.emplace_back(command.name, place);
}

// Commands above all subcases stand in one of their own, which the first SUBCASE takes over and each further one begins
// with.
void CaseControl::begin_subcase(const std::vector<std::string>& words, const Place& place) {
  if (++subcases_ == 1) above_ = subcases.empty() ? Subcase{} : subcases.front(), subcases.clear();
  subcases.push_back(above_);
  const auto number = words.size() > 1 ? parse_integer(words[1]) : std::nullopt;
  subcases.back().number = number.value_or(subcases_);
  subcases.back().where = place;
  subcases.back().combines = words.front().ends_with("COM");
}

Subcase& CaseControl::present_subcase() {
  if (subcases.empty()) subcases.emplace_back();
  return subcases.back();
}

bool CaseControl::choose(std::optional<std::int64_t> number) {
  const Subcase* taken = number ? find(*number) : nullptr;
  const bool found = !number || taken != nullptr;
  if (taken == nullptr && !subcases.empty()) {
    const auto modal = std::ranges::find_if(subcases, [](const Subcase& each) { return each.method.has_value(); });
    taken = modal == subcases.end() ? &subcases.front() : &*modal;
  }
  if (taken != nullptr) chosen = *taken;
  spc = chosen.spc, mpc = chosen.mpc;
  stiffness = chosen.stiffness, mass = chosen.mass, damping = chosen.damping;
  material_temperature = chosen.material_temperature;
  const Subcase* carried = preload();
  if (!material_temperature && carried) material_temperature = carried->material_temperature;
  if (!material_temperature) material_temperature = chosen.initial_temperature;
  return found;
}

const Subcase* CaseControl::find(std::int64_t number) const {
  const auto found = std::ranges::find(subcases, number, &Subcase::number);
  return found == subcases.end() ? nullptr : &*found;
}

const Subcase* CaseControl::preload() const {
  return chosen.preload && solution_number() != 105 ? find(*chosen.preload) : nullptr;
}

int CaseControl::solution_number() const {
  if (const auto number = parse_integer(solution)) return static_cast<int>(*number);
  for (const auto& [name, number] : solution_names)
    if (solution.starts_with(name)) return number;
  return 0;
}

namespace {

/// Whether a line of the text, apart from blanks before it, begins with this word in any case.
bool has_line_with(std::string_view text, std::string_view word) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const auto line = trimmed(text.substr(at, end - at));
    if (line.size() >= word.size() && upper_case(line.substr(0, word.size())) == word) return true;
    at = end + 1;
  }
  return false;
}

}  // namespace

bool has_case_control(std::string_view text) { return has_line_with(text, "CEND") || has_line_with(text, "BEGIN"); }

bool begins_bulk(std::string_view line) {
  const auto words = words_of(trimmed(line));
  return !words.empty() && words[0] == "BEGIN" && (words.size() == 1 || words[1] == "BULK") &&
         (words.size() < 3 || !(words[2] == "SUPER" || words[2] == "AUXMODEL" || words[2].starts_with("ARB")));
}

}  // namespace kalfem::nastran
