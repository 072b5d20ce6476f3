// SPDX-License-Identifier: Apache-2.0
#include "base/places.hpp"

namespace kalfem::test {

const std::string& source_folder() {
  static const std::string folder = KALFEM_SOURCE_DIR;
  return folder;
}

const std::string& command_file() {
  static const std::string file = KALFEM_COMMAND;
  return file;
}

}  // namespace kalfem::test
