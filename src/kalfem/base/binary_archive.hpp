// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace kalfem {

/// Thrown if the bytes are not those of an archive.
struct DamagedArchive {};

/// Appends values to a text, bit by bit as the processor holds them: for files that stay on one machine.
class ArchiveWriter {
public:
  /// `about`: bytes that are expected.
  explicit ArchiveWriter(std::size_t about = 0) { bytes_.reserve(about); }

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void operator()(const T& value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void operator()(const std::string& text) { list(text); }
  template <class T>
  void list(const T& values) {
    (*this)(static_cast<std::int64_t>(values.size()));
    append(values.data(), static_cast<std::size_t>(values.size()));
  }
  template <class T, int Columns>
  void operator()(const Eigen::Matrix<T, Eigen::Dynamic, Columns>& matrix) {
    (*this)(static_cast<std::int64_t>(matrix.cols()));
    (*this)(static_cast<std::int64_t>(matrix.rows()));
    append(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  template <class T, class Allocator>
  requires std::is_arithmetic_v<T>
  void operator()(const std::vector<T, Allocator>& values) { list(values); }
  void operator()(const std::deque<double>& values) {
    each(values, [&](double value) { (*this)(value); });
  }
  template <class T>
  void operator()(const std::optional<T>& value) {
    (*this)(value.has_value());
    if (value) (*this)(*value);
  }
  /// A value that may be missing; `of_value` writes it.
  void maybe(const auto& value, const auto& of_value) {
    (*this)(value.has_value());
    if (value) of_value(*value);
  }
  /// The length of a list; `of_item` writes each item.
  void each(const auto& values, const auto& of_item) {
    (*this)(static_cast<std::int64_t>(values.size()));
    for (const auto& value : values) of_item(value);
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

private:
  template <class T>
  void append(const T* values, std::size_t count) {
    if (count > 0) bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }

  std::string bytes_;
};

/// Reads what an ArchiveWriter wrote, in the same order. Throws DamagedArchive where the bytes do not suffice.
class ArchiveReader {
public:
  explicit ArchiveReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void operator()(T& value) { take(&value, 1); }
  void operator()(std::string& text) {
    text.resize(count(1));
    take(text.data(), text.size());
  }
  template <class T, class Allocator>
  requires std::is_arithmetic_v<T>
  void operator()(std::vector<T, Allocator>& values) {
    values.resize(count(sizeof(T)));
    take(values.data(), values.size());
  }
  void operator()(std::deque<double>& values) {
    each(values, [&](double& value) { (*this)(value); });
  }
  template <class T, int Columns>
  void operator()(Eigen::Matrix<T, Eigen::Dynamic, Columns>& matrix) {
    const std::size_t columns = count(0), rows = count(columns * sizeof(T));
    matrix.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
    take(matrix.data(), rows * columns);
  }
  template <class T>
  void operator()(std::optional<T>& value) {
    bool there = false;
    (*this)(there);
    value.reset();
    if (there) (*this)(value.emplace());
  }
  void maybe(auto& value, const auto& of_value) {
    bool there = false;
    (*this)(there);
    value.reset();
    if (there) of_value(value.emplace());
  }
  void each(auto& values, const auto& of_item) {
    values.resize(count(1));
    for (auto& value : values) of_item(value);
  }
  [[nodiscard]] bool at_end() const { return bytes_.empty(); }

private:
  /// A number of values that the rest can hold, each of at least so many bytes.
  std::size_t count(std::size_t bytes_each) {
    std::int64_t number = 0;
    take(&number, 1);
    if (number < 0 || static_cast<std::size_t>(number) > most / std::max<std::size_t>(1, bytes_each) ||
        static_cast<std::size_t>(number) * bytes_each > bytes_.size())
      throw DamagedArchive();
    return static_cast<std::size_t>(number);
  }

  template <class T>
  void take(T* values, std::size_t number) {
    if (number * sizeof(T) > bytes_.size()) throw DamagedArchive();
    if (number > 0) std::memcpy(values, bytes_.data(), number * sizeof(T));
    bytes_.remove_prefix(number * sizeof(T));
  }

  static constexpr std::size_t most = std::size_t{1} << 48U;
  std::string_view bytes_;
};

}  // namespace kalfem
