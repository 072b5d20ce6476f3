// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// A file could not be written because of the machine, not because of the input: the disk or the quota is full, the
/// file would exceed a size limit, or the device fails.
class WriteFailure : public InvalidInput {
public:
  using InvalidInput::InvalidInput;
};

/// Room that a file needs [bytes].
struct NeededSpace {
  std::uintmax_t bytes = 0;
  bool at_least = false;  ///< the whole size is not known: what was written up to now
};

/// Throws what the system's error `code` means for writing `path`: WriteFailure for those of the machine, with the
/// space that is needed and that is available, InvalidInput for a place that cannot be written.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, int code, std::optional<NeededSpace> needed = {});

/// Replaces the file so that a reader sees the old bytes or all of the new ones, never a part: writes a temporary file
/// in the same folder (made if it is missing), brings it to the disk and renames it. Removes the temporary file on
/// failure. What stands at `path` and is no file (a pipe, a terminal) is written to directly. Throws WriteFailure where
/// the disk takes no more, InvalidInput where the folder or the file cannot be written.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Throws InvalidInput where `write_file_atomically` could not write: a folder stands at `path`, or the folder that it
/// would stand in cannot be made or written. For use before a long computation; writes nothing.
void require_writable(const std::filesystem::path& path);

/// Ending of the temporary files. A process that is killed leaves one.
inline constexpr std::string_view temporary_ending = ".kalfem-tmp";

/// Waits until a file's bytes, or a folder's entries, have reached the disk. Some file systems report a full disk only
/// here. Throws like write_file_atomically; folders on file systems that cannot do it are passed over.
void bring_to_disk(const std::filesystem::path& path);

}  // namespace kalfem
