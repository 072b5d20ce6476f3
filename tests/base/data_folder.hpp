// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/places.hpp"

namespace kalfem {

/// Where measured records and industrial models are: $KALFEM_DATA, or shared/data beside the project. They are no part
/// of it: tests that use them skip with a word where they are absent.
inline std::filesystem::path data_folder(const std::string& name = "") {
  const char* variable = std::getenv("KALFEM_DATA");
  const std::filesystem::path root =
      variable ? variable : std::filesystem::path(test::source_folder()) / "../shared/data";
  return root / name;
}

}  // namespace kalfem
