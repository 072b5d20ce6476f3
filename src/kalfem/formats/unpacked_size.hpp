// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// Bytes that the content of a compressed file of this size may take in memory before it must be asked for:
/// 64 MiB + 8 x the file. Measured samples pack to a half or a third; a file of zeros packs to a thousandth.
std::uintmax_t most_unpacked(std::uintmax_t file_bytes);

/// What is read of a measured file.
struct MeasuredFileOptions {
  std::vector<std::string> channels = {};  ///< asked for by name, and read whatever their size; empty: all
  bool large = false;                      ///< also parts that unpack to more than most_unpacked()
};

/// Counts what the parts of one compressed file unpack to, as numbers of 8 bytes, before they are read.
class UnpackedBudget {
public:
  UnpackedBudget(const std::filesystem::path& file, const MeasuredFileOptions& options);

  /// Whether a channel that is asked for may stand in a part of this name, such as "/run/acc" or "run".
  [[nodiscard]] bool asks_for(std::string_view part) const;
  /// Whether the values of the part matter: it is asked for, or all are.
  [[nodiscard]] bool wants(std::string_view part) const { return options_.channels.empty() || asks_for(part); }
  /// Bytes that a part may unpack to now.
  [[nodiscard]] std::uintmax_t left(std::string_view part) const;
  /// Counts a part. False, and nothing is counted, where it goes over what is left.
  [[nodiscard]] bool take(std::string_view part, std::uintmax_t bytes);
  /// Why a part was not read: "... unpacks to 1600 MB, ...".
  [[nodiscard]] std::string refusal(std::uintmax_t bytes) const;

private:
  MeasuredFileOptions options_;
  std::uintmax_t most_, used_ = 0;
};

}  // namespace kalfem
