// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

namespace kalfem {

/// Fowler, Noll and Vo's hash FNV-1a of 64 bits: the same on every computer, as std::hash is not.
class Hash {
public:
  void add(std::string_view bytes) {
    for (const char c : bytes) state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  }
  /// The bits of a number.
  void add(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int shift = 0; shift < 64; shift += 8) state_ = (state_ ^ ((bits >> shift) & 0xFFU)) * 0x100000001B3U;
  }
  [[nodiscard]] std::uint64_t value() const { return state_; }

private:
  std::uint64_t state_ = 0xCBF29CE484222325U;
};

}  // namespace kalfem
