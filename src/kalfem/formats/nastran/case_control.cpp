#include "kalfem/formats/nastran/case_control.hpp"

#include <array>

#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem::nastran {
namespace {

/// Words of a line in capitals, parted by blanks, commas and '='.
std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  const std::string text = upper_case(line);
  for (std::size_t at = 0; at < text.size();) {
    at = text.find_first_not_of(" \t,=", at);
    if (at == std::string::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t,=", at), text.size());
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

/// TEMPERATURE, shortened to four letters or more, of materials.
bool chooses_material_temperature(const std::string& command) {
  const auto bracket = command.find('(');
  const std::string name = command.substr(0, bracket),
                    kind = bracket == std::string::npos ? "" : command.substr(bracket + 1);
  const bool of_materials = kind.empty() || kind.starts_with("MATE") || kind.starts_with("BOTH");
  return name.size() >= 4 && std::string_view("TEMPERATURE").starts_with(name) && of_materials;
}

}  // namespace

void CaseControl::read(std::string_view line, const Place& place) {
  const auto words = words_of(line);
  if (words.empty()) return;
  const std::string& command = words.front();
  if (command == "SUBCASE" || command == "SUBCOM") {
    if (++subcases_ == 2) more_subcases = true, second_subcase = place;
    begin_subcase(words, place);
  }
  if (command == "LOAD") present_subcase().load = set_number(words);
  if (command == "SPC") present_subcase().spc = set_number(words);
  if (subcases_ > 1) return;
  const auto matrices = [&](auto& list) {
    list.clear();
    for (std::size_t i = 1; i < words.size(); ++i) list.push_back(scaled_name(words[i]));
  };
  if (command == "SPC")
    spc = set_number(words);
  else if (command == "MPC")
    mpc = set_number(words);
  else if (chooses_material_temperature(command))
    material_temperature = set_number(words);
  else if (command == "K2GG")
    matrices(stiffness);
  else if (command == "M2GG")
    matrices(mass);
  else if (command == "B2GG")
    matrices(damping);
  else
    for (const char* known : {"K2PP", "M2PP", "B2PP", "K42GG", "TFL", "NSM"})
      if (command == known) unused.emplace_back(command, place);
}

// Commands above all subcases stand in one of their own, which the first SUBCASE takes over and each further one begins
// with.
void CaseControl::begin_subcase(const std::vector<std::string>& words, const Place& place) {
  if (subcases_ == 1) above_ = subcases.empty() ? Subcase{} : subcases.front(), subcases.clear();
  subcases.push_back(above_);
  const auto number = words.size() > 1 ? parse_integer(words[1]) : std::nullopt;
  subcases.back().number = number.value_or(subcases_);
  subcases.back().where = place;
}

CaseControl::Subcase& CaseControl::present_subcase() {
  if (subcases.empty()) subcases.emplace_back();
  return subcases.back();
}

bool begins_bulk(std::string_view line) {
  const auto words = words_of(trimmed(line));
  return !words.empty() && words[0] == "BEGIN" && (words.size() == 1 || words[1] == "BULK") &&
         (words.size() < 3 || !(words[2] == "SUPER" || words[2] == "AUXMODEL" || words[2].starts_with("ARB")));
}

}  // namespace kalfem::nastran
