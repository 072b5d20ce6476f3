#include "kalfem/formats/abaqus/keyword.hpp"

#include <algorithm>

#include "kalfem/formats/abaqus/fields.hpp"

namespace kalfem::abaqus {

namespace {

std::string joined_capitals(std::string_view text) {
  std::string result = upper_case(text);
  std::erase_if(result, [](char c) { return c == ' ' || c == '\t'; });
  return result;
}

/// Capitals with single blanks.
std::string title_of(std::string_view text) {
  std::string result;
  for (const char c : upper_case(trimmed_field(text)))
    if (c != ' ' && c != '\t')
      result += c;
    else if (!result.empty() && result.back() != ' ')
      result += ' ';
  return shown(result);
}

/// The next part up to a comma outside of quotation marks; steps over it.
std::string_view take_part(std::string_view& rest) {
  bool quoted = false;
  std::size_t end = 0;
  for (; end < rest.size() && (quoted || rest[end] != ','); ++end)
    if (rest[end] == '"') quoted = !quoted;
  const auto part = rest.substr(0, end);
  rest.remove_prefix(std::min(rest.size(), end + 1));
  return part;
}

std::string_view unquoted(std::string_view value) {
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"') return value.substr(1, value.size() - 2);
  return value;
}

}  // namespace

bool Keyword::has(std::string_view parameter) const {
  return std::ranges::any_of(parameters, [&](const auto& entry) { return entry.first == parameter; });
}

std::string Keyword::get(std::string_view parameter) const {
  for (const auto& [known, value] : parameters)
    if (known == parameter) return value;
  return {};
}

std::string Keyword::word(std::string_view parameter) const { return joined_capitals(get(parameter)); }

Keyword parse_keyword(std::string_view line, const Where& where) {
  Keyword keyword;
  keyword.where = where;
  line.remove_prefix(1);
  const auto name = take_part(line);
  keyword.name = joined_capitals(name);
  keyword.title = "*" + title_of(name);
  while (!line.empty()) {
    const auto part = take_part(line);
    const auto equals = part.find('=');
    const std::string parameter = joined_capitals(part.substr(0, equals));
    if (parameter.empty()) continue;
    const auto value =
        equals == std::string_view::npos ? std::string_view{} : unquoted(trimmed_field(part.substr(equals + 1)));
    keyword.parameters.emplace_back(parameter, value);
  }
  return keyword;
}

}  // namespace kalfem::abaqus
