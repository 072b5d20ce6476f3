// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/system/laws/expression_tape.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/yaml/editor_schema.hpp"
#include "kalfem/yaml/json_schema.hpp"
#include "law_schema.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

void print_laws() {
  for (const auto& law : law_library()) {
    print("{}: {}\n  {}\n", law.name, law.meaning, law.equation);
    Table table{"", {"parameter", "unit", "default", "meaning"}, {}, {}};
    for (const auto& quantity : law.parameters)
      table.rows.push_back({quantity.name, quantity.unit, four_digits(quantity.default_value), quantity.meaning});
    for (const auto& state : law.states) table.rows.push_back({"(state) " + state.name, state.unit, "", state.meaning});
    print("{}\n", table.rows.empty() ? "" : to_text(table));
  }
  Table functions{"", {"function", "meaning"}, {}, {}};
  for (const auto& function : expression_functions()) functions.rows.push_back({function.name, function.meaning});
  print(
      "In expressions: x (deformation), v (rate), a (relative acceleration, not in rates of states), "
      "f (force, in rates of states),\nparameters, states, signals, `let`; + - * / ^, < <= > >= == !=, && ||, "
      "condition ? b : c;\n"
      "constants _pi and _e; functions:\n{}\n",
      to_text(functions));
}

/// The document with one of its sections only.
nlohmann::ordered_json section_of(nlohmann::ordered_json document, const std::string& topic) {
  auto& sections = document.at("properties");
  std::vector<std::string> names;
  for (const auto& [name, section] : sections.items()) names.push_back(name);
  if (std::ranges::find(names, topic) == names.end())
    throw InvalidInput("the case file has no section '" + topic + "'" + did_you_mean(topic, names),
                       fmt::format("its sections are {}", fmt::join(names, ", ")), "");
  for (const auto& name : names)
    if (name != topic) sections.erase(name);
  return document;
}

nlohmann::ordered_json whole_document() {
  return whole_json_schema(description::case_schema().json_schema(), "kalfem case file");
}

}  // namespace

std::string case_file_schema() {
  nlohmann::ordered_json schema = editor_schema(whole_document());
  add_laws(schema);
  return schema.dump(2) + "\n";
}

ExitCode schema(bool as_json, bool laws, const std::string& topic) {
  if (laws)
    print_laws();
  else if (as_json)
    print_text(case_file_schema());
  else
    print("{}\n", reference_text(topic.empty() ? whole_document() : section_of(whole_document(), topic)));
  return done;
}

}  // namespace kalfem::command
