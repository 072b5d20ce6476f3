// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "base/places.hpp"
#include "base/scratch_folder.hpp"

/// Runs the command as a user does, and reads what it left.
namespace kalfem::test {

struct Outcome {
  int code = -1;
  std::string output, errors;
};

inline std::string read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

inline Outcome run_command(const std::string& arguments, const std::filesystem::path& folder) {
  const auto out = folder / "stdout.txt", err = folder / "stderr.txt";
  const std::string line = command_file() + " " + arguments + " >" + out.string() + " 2>" + err.string();
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(out), read(err)};
}

inline nlohmann::json read_summary(const std::filesystem::path& folder) {
  return nlohmann::json::parse(read(folder / "summary.json"));
}

inline std::string example(const std::string& name) { return source_folder() + "/examples/" + name; }

}  // namespace kalfem::test
