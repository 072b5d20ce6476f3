// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matlab/matlab_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = std::filesystem::temp_directory_path() / ("kalfem-fuzz-" + std::to_string(getpid()) + ".mat");
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    kalfem::read_matlab_file(file);
  } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
  }
  std::filesystem::remove(file);
  return 0;
}
