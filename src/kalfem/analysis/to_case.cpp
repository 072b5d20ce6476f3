// SPDX-License-Identifier: Apache-2.0
#include "kalfem/analysis/case_sections.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/formats/tables/csv.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// The same names, each with what a case says where it says nothing.
template <class T>
Named<T> defaults_of(const Named<T>& given) {
  Named<T> defaults;
  for (const auto& [name, value] : given) defaults.emplace_back(name, T{});
  return defaults;
}

YamlNodePtr names_of(const YamlNodePtr& section) {
  std::vector<YamlEntry> entries;
  for (const auto& entry : section->entries) entries.push_back({entry.key, 0, yaml_map({})});
  return yaml_map(std::move(entries));
}

/// The document without the keys whose values are the defaults.
std::string without_defaults(const d::Case& given) {
  static const auto schema = d::case_schema();
  d::Case defaults;
  defaults.version = 0;
  defaults.substructures = defaults_of(given.substructures);
  defaults.connectors = defaults_of(given.connectors);
  defaults.excitation = defaults_of(given.excitation);
  defaults.sensors = defaults_of(given.sensors);
  if (given.record) defaults.record.emplace();
  if (given.estimate) defaults.estimate.emplace();
  if (given.update) defaults.update.emplace();
  const YamlNodePtr written = schema.write(given);
  std::vector<YamlEntry> kept;
  for (const std::string key : {"substructures", "connectors", "excitation", "sensors"})
    if (const auto* section = written->find(key)) kept.push_back({key, 0, names_of(section->value)});
  for (const std::string key : {"record", "estimate", "update"})
    if (written->find(key)) kept.push_back({key, 0, yaml_map({})});
  return to_yaml(*as_given(written, schema.write(defaults), yaml_map(std::move(kept))));
}

}  // namespace

std::string CaseInMaking::add_file(const std::string& ending, const Record& record) {
  files.emplace_back(name + ending + ".csv", record);
  return files.back().first;
}

void CaseInMaking::refuse(const std::string& what, const std::string& why, const std::string& fix) {
  issues.add({}, "to_case: " + what, why, fix);
}

CaseText to_case(const Analysis& analysis, const std::string& name) {
  CaseInMaking making{.name = name, .given = {}};
  making.given.title = analysis.title;
  describe_structure(analysis.structure, making);
  if (analysis.estimate) describe_estimation(analysis, making);
  if (analysis.update) describe_updating(*analysis.update, making);
  making.issues.raise();
  return {without_defaults(making.given), std::move(making.files)};
}

void write_case(const Analysis& analysis, const std::filesystem::path& file) {
  const CaseText text = to_case(analysis, file.stem().string());
  for (const auto& [name, record] : text.files) write_csv(file.parent_path() / name, record);
  write_file_atomically(file, text.yaml);
}

}  // namespace kalfem
