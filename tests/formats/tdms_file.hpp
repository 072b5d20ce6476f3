// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem::test {

/// The bytes of numbers of one type after the other.
template <class Stored>
std::string raw(const std::vector<double>& numbers, bool big_endian = false) {
  std::string bytes;
  for (const double number : numbers) {
    const auto stored = static_cast<Stored>(number);
    std::string one(sizeof stored, '\0');
    std::memcpy(one.data(), &stored, sizeof stored);
    if (big_endian != (std::endian::native == std::endian::big)) one.assign(one.rbegin(), one.rend());
    bytes += one;
  }
  return bytes;
}

/// Writes TDMS files part by part, sound and unsound ones.
class TdmsWriter {
public:
  static constexpr std::uint32_t metadata = 2, new_list = 4, raw_data = 8, interleaved = 32, big = 64, daqmx = 128;
  static constexpr std::uint32_t usual = metadata | new_list | raw_data;

  explicit TdmsWriter(bool big_endian = false) : big_(big_endian) {}

  template <class Stored>
  [[nodiscard]] std::string number(double value) const {
    return raw<Stored>({value}, big_);
  }
  [[nodiscard]] std::string word(std::uint32_t value) const { return number<std::uint32_t>(value); }
  [[nodiscard]] std::string text(std::string_view value) const {
    return word(static_cast<std::uint32_t>(value.size())) + std::string(value);
  }

  /// @name Properties
  ///@{
  [[nodiscard]] std::string property(std::string_view name, double value) const {
    return text(name) + word(10) + number<double>(value);
  }
  [[nodiscard]] std::string property(std::string_view name, std::string_view value) const {
    return text(name) + word(0x20) + text(value);
  }
  [[nodiscard]] std::string time(std::int64_t seconds, std::uint64_t fraction) const {
    std::string stamp(16, '\0');
    std::memcpy(stamp.data(), &fraction, 8);
    std::memcpy(stamp.data() + 8, &seconds, 8);
    if (big_) stamp.assign(stamp.rbegin(), stamp.rend());
    return stamp;
  }
  ///@}

  /// @name Objects
  ///@{
  [[nodiscard]] std::string object(std::string_view path, const std::string& index,
                                   const std::vector<std::string>& properties = {}) const {
    std::string whole = text(path) + index + word(static_cast<std::uint32_t>(properties.size()));
    for (const auto& each : properties) whole += each;
    return whole;
  }
  [[nodiscard]] std::string index(std::uint32_t type, double count) const {
    return word(20) + word(type) + word(1) + number<std::uint64_t>(count);
  }
  [[nodiscard]] std::string no_data() const { return word(0xffffffffu); }
  [[nodiscard]] std::string as_before() const { return word(0); }
  ///@}

  void segment(std::uint32_t flags, const std::vector<std::string>& objects, const std::string& data,
               bool unfinished = false) {
    std::string description;
    if (flags & metadata) {
      description = word(static_cast<std::uint32_t>(objects.size()));
      for (const auto& each : objects) description += each;
    }
    bytes += "TDSm" + raw<std::uint32_t>({double(flags | (big_ ? big : 0))}) + word(4713);
    bytes += unfinished ? std::string(8, '\xff') : number<std::uint64_t>(double(description.size() + data.size()));
    bytes += number<std::uint64_t>(double(description.size())) + description + data;
  }

  std::string bytes;

private:
  bool big_;
};

}  // namespace kalfem::test
