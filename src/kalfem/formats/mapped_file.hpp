// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace kalfem {

/// The bytes of a file as they lie on the disk, which the system brings into memory where they are looked at: files
/// larger than the memory can be read from front to back.
class MappedFile {
public:
  /// Throws InvalidInput where the file cannot be read, as RegularFile does.
  explicit MappedFile(const std::filesystem::path& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  [[nodiscard]] std::string_view bytes() const { return {static_cast<const char*>(address_), size_}; }
  /// Lets the system take back the memory of what stands before a place in bytes(); it is read again where it is looked
  /// at again.
  void release_before(const char* place) const;

private:
  void* address_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace kalfem
