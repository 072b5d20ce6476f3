// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "kalfem/formats/mapped_file.hpp"

namespace kalfem {

/// The content of a text file without a leading byte-order mark, UTF-16 as UTF-8. It stays on the disk; only
/// UTF-16 is copied into memory.
class MappedText {
public:
  /// Throws InvalidInput where the file cannot be read.
  explicit MappedText(const std::filesystem::path& path);
  MappedText(const MappedText&) = delete;
  MappedText& operator=(const MappedText&) = delete;

  [[nodiscard]] std::string_view view() const { return view_; }
  /// Gives the memory before a place in view() back to the system, see MappedFile.
  void release_before(const char* place) const {
    if (converted_.empty()) file_.release_before(place);
  }

private:
  MappedFile file_;
  std::string converted_;  ///< of UTF-16
  std::string_view view_;
};

}  // namespace kalfem
