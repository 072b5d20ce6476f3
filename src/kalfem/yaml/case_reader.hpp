#pragma once

#include <string>

#include "kalfem/yaml/form.hpp"
#include "kalfem/yaml/yaml_reader.hpp"

namespace kalfem {

/// Throws InvalidInput with the issues in the order of the lines, those of other files behind; does nothing when there
/// are none.
void raise_in_line_order(const IssueList& issues);

/// Reads the text of a case file in the given form. `file` names it in messages, and paths are relative to its folder.
/// Problems go to `issues`; what has one keeps its default.
template <class T>
T read_case_text(const std::string& text, const std::string& file, const Form<T>& form, IssueList& issues,
                 const Environment& environment = process_environment()) {
  Reading reading{file, std::filesystem::path(file).parent_path(), {}};
  T value{};
  try {
    const YamlNodePtr root = parse_yaml(text, file, environment, reading.issues);
    form.read(Cursor(reading, root, "", root->line), value);
  } catch (const InvalidInput& error) {
    reading.issues.add(error, {file, 1});
  }
  for (const auto& [location, what, why, fix] : reading.issues.issues()) issues.add(location, what, why, fix);
  return value;
}

/// As above, but throws InvalidInput with every problem that was found.
template <class T>
T read_case_text(const std::string& text, const std::string& file, const Form<T>& form,
                 const Environment& environment = process_environment()) {
  IssueList issues;
  T value = read_case_text(text, file, form, issues, environment);
  raise_in_line_order(issues);
  return value;
}

/// Reads a case file; see read_case_text().
template <class T>
T read_case(const std::string& file, const Form<T>& form, const Environment& environment = process_environment()) {
  return read_case_text(read_text_file(file), file, form, environment);
}

}  // namespace kalfem
