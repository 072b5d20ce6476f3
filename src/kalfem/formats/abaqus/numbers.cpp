#include "kalfem/formats/abaqus/numbers.hpp"

#include "kalfem/formats/abaqus/fields.hpp"

namespace kalfem::abaqus {

double number_or(const DataLine& line, std::size_t field, double otherwise, const std::string& what,
                 Problems& problems) {
  if (line.field(field).empty()) return otherwise;
  return number_at(line, field, what, problems).value_or(otherwise);
}

std::optional<double> number_at(const DataLine& line, std::size_t field, const std::string& what, Problems& problems) {
  const auto& text = line.field(field);
  const auto value = to_number(text);
  if (!value)
    problems.add(line.where, text.empty() ? "there is no " + what : "'" + shown(text) + "' is no number",
                 text.empty() ? "it has no default" : "it should be " + what, "mend the line");
  return value;
}

std::vector<double> all_numbers(const Block& block, std::size_t first_line, const std::string& what,
                                Problems& problems) {
  std::vector<double> values;
  for (std::size_t i = first_line; i < block.lines.size(); ++i)
    for (std::size_t field = 0; field < block.lines[i].fields.size(); ++field)
      values.push_back(number_or(block.lines[i], field, 0.0, what, problems));
  return values;
}

std::optional<double> number_parameter(const Keyword& keyword, std::string_view parameter, Problems& problems) {
  if (!keyword.has(parameter)) return {};
  const auto value = to_number(keyword.get(parameter));
  if (!value)
    problems.add(keyword.where, std::string(parameter) + "=" + shown(keyword.get(parameter)) + " is no number",
                 keyword.title + " takes a number there", "mend it");
  return value;
}

const DataLine& line_of(const Block& block, std::size_t index) {
  static const DataLine none;
  return index < block.lines.size() ? block.lines[index] : none;
}

}  // namespace kalfem::abaqus
