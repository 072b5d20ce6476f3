#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

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

}  // namespace kalfem
