#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace kalfem::abaqus {

/// Finds positions by numbers of a deck: a table where the numbers are dense, else a hash table.
class LabelIndex {
public:
  /// Room for so many numbers up to the largest.
  void prepare(std::size_t count, std::int64_t largest) {
    is_table_ = largest >= 0 && static_cast<std::uint64_t>(largest) < 8 * static_cast<std::uint64_t>(count) + 1024;
    if (is_table_)
      table_.assign(static_cast<std::size_t>(largest) + 1, -1);
    else
      map_.reserve(count);
  }
  /// Position of a number, -1 where there is none.
  [[nodiscard]] std::int64_t find(std::int64_t label) const {
    if (is_table_)
      return label >= 0 && static_cast<std::size_t>(label) < table_.size() ? table_[static_cast<std::size_t>(label)]
                                                                           : -1;
    const auto entry = map_.find(label);
    return entry == map_.end() ? -1 : entry->second;
  }
  /// The number must be one that prepare() was told of, and new.
  void add(std::int64_t label, std::int64_t position) {
    if (is_table_)
      table_[static_cast<std::size_t>(label)] = static_cast<std::int32_t>(position);
    else
      map_.emplace(label, position);
  }

private:
  bool is_table_ = false;
  std::vector<std::int32_t> table_;
  std::unordered_map<std::int64_t, std::int64_t> map_;
};

}  // namespace kalfem::abaqus
