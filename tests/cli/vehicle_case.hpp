// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/places.hpp"
#include "command.hpp"

namespace kalfem::test {

/// Runs a verb on a case of the vehicle with variables set; the results are in folder/out.
inline Outcome run_vehicle(const std::string& verb, const std::string& case_file, const std::string& variables,
                           const std::filesystem::path& folder) {
  const std::string line = "env OPENBLAS_NUM_THREADS=1 " + variables + " " + command_file() + " " + verb + " " +
                           example(case_file) + " --out " + (folder / "out").string() + " >" +
                           (folder / "stdout.txt").string() + " 2>" + (folder / "stderr.txt").string();
  const int status = std::system(line.c_str());
  return {WEXITSTATUS(status), read(folder / "stdout.txt"), read(folder / "stderr.txt")};
}

}  // namespace kalfem::test
