// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "kalfem/study/study.hpp"

namespace kalfem {

/// A file that a case reads, as `sha256sum` knows it.
struct DataFile {
  std::filesystem::path path;
  std::uintmax_t bytes = 0;
  std::string sha256;  ///< 64 hexadecimal digits; empty where the file cannot be read any more
};

/// The files that the case names, each once, in its order.
std::vector<DataFile> data_files(const Study& study);

/// SHA-256 of a file's bytes (FIPS 180-4), in hexadecimal digits; empty where it cannot be read.
std::string sha256_of(const std::filesystem::path& file);

}  // namespace kalfem
