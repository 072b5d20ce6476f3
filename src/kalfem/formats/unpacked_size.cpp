// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/unpacked_size.hpp"

#include <algorithm>
#include <limits>

#include "kalfem/base/regular_file.hpp"

namespace kalfem {

std::uintmax_t most_unpacked(std::uintmax_t file_bytes) {
  constexpr std::uintmax_t always = std::uintmax_t{64} << 20, times_the_file = 8;
  return always + times_the_file * std::min(file_bytes, std::numeric_limits<std::uintmax_t>::max() / 16);
}

UnpackedBudget::UnpackedBudget(const std::filesystem::path& file, const MeasuredFileOptions& options)
    : options_(options), most_(most_unpacked(RegularFile(file).size())) {}

bool UnpackedBudget::asks_for(std::string_view part) const {
  const std::string_view last = part.substr(part.rfind('/') + 1);
  return !last.empty() && std::ranges::any_of(options_.channels, [&](const std::string& channel) {
    return channel.find(last) != std::string::npos;
  });
}

std::uintmax_t UnpackedBudget::left(std::string_view part) const {
  if (options_.large || asks_for(part)) return std::numeric_limits<std::uintmax_t>::max();
  return most_ - std::min(most_, used_);
}

bool UnpackedBudget::take(std::string_view part, std::uintmax_t bytes) {
  if (bytes > left(part)) return false;
  used_ += options_.large || asks_for(part) ? 0 : bytes;
  return true;
}

std::string UnpackedBudget::refusal(std::uintmax_t bytes) const {
  constexpr std::uintmax_t megabyte = 1'000'000;
  return "is not read: it unpacks to " + std::to_string(bytes / megabyte) +
         " MB, and a file of this size is read up to " + std::to_string(most_ / megabyte) +
         " MB (name its channels in the case, or inspect --large)";
}

}  // namespace kalfem
