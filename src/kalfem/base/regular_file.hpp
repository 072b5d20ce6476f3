// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace kalfem {

/// A regular file, open for reading. Everything that kalfem reads is opened here, or checked by require_regular_file()
/// before a library opens it by its name: a pipe would keep the command waiting, a device may have no end.
class RegularFile {
public:
  /// Opens the file without waiting. Throws InvalidInput where nothing stands there, where it is a folder, a pipe, a
  /// socket or a device, and where it may not be read; the message names which.
  explicit RegularFile(const std::filesystem::path& path);
  RegularFile(const RegularFile&) = delete;
  RegularFile& operator=(const RegularFile&) = delete;
  ~RegularFile();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] std::uintmax_t size() const { return size_; }  ///< when it was opened [bytes]

private:
  int descriptor_ = -1;
  std::uintmax_t size_ = 0;
};

/// Throws InvalidInput as RegularFile does.
void require_regular_file(const std::filesystem::path& path);

/// The content of a file, or its first `most` bytes. Throws InvalidInput as RegularFile does, and where reading fails.
std::string read_bytes(const std::filesystem::path& path, std::uintmax_t most = UINTMAX_MAX);

/// The content of a file of our own, such as summary.json. Empty where it is absent or cannot be read.
std::string bytes_if_readable(const std::filesystem::path& path);

}  // namespace kalfem
