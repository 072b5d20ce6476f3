// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace kalfem::test {

/// A small case without a mistake, which runs in a fraction of a second.
struct BaseCase {
  std::string name, text;
};

inline void PrintTo(const BaseCase& base, std::ostream* out) { *out << base.name; }

/// Cases that hold every section of a case file between them. They name files of write_case_files().
std::vector<BaseCase> base_cases();

/// Records, tables and a mesh that the cases read.
void write_case_files(const std::filesystem::path& folder);

}  // namespace kalfem::test
