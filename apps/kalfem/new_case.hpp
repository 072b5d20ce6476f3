// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

namespace kalfem::command {

/// A file of a case to start from.
struct StarterFile {
  std::string_view kind;  ///< "measured"
  std::string_view name, text;
};

/// Those of examples/start, by kind and name. The build puts them into the command (starter_files.cmake).
const std::vector<StarterFile>& starter_files();

}  // namespace kalfem::command
