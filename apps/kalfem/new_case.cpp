// SPDX-License-Identifier: Apache-2.0
#include "new_case.hpp"

#include <algorithm>
#include <filesystem>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "verbs.hpp"

namespace kalfem::command {

namespace fs = std::filesystem;

std::vector<std::string> starter_kinds() {
  std::vector<std::string> kinds;
  for (const auto& file : starter_files())
    if (std::ranges::find(kinds, file.kind) == kinds.end()) kinds.emplace_back(file.kind);
  return kinds;
}

ExitCode new_case(const std::string& kind, const fs::path& folder) {
  const std::string schema_name = "kalfem.schema.json";
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& file : starter_files())
    if (file.kind == kind) files.emplace_back(file.name, file.text);
  files.emplace_back(schema_name, case_file_schema());
  IssueList issues;
  for (const auto& [name, text] : files)
    if (std::error_code ignored; fs::exists(folder / name, ignored))
      issues.add({}, (folder / name).string() + " is there already", "`kalfem new` replaces no file",
                 "give another folder");
  issues.raise();
  for (const auto& [name, text] : files) write_file_atomically(folder / name, text);
  print("Written to {}:", folder.string());
  for (const auto& [name, text] : files) print(" {}", name);
  print("\nNext: kalfem run {}\n", (folder / "case.yaml").string());
  return done;
}

}  // namespace kalfem::command
