#include <algorithm>

#include "kalfem/formats/gmsh/gmsh_builder.hpp"

namespace kalfem {

NumberLookup::NumberLookup(const std::vector<std::int64_t>& numbers) {
  if (numbers.empty()) return;
  const auto [lowest, highest] = std::ranges::minmax(numbers);
  lowest_ = lowest;
  // Unsigned, as the difference of two 64-bit numbers may not fit into a signed one.
  const std::uint64_t span = static_cast<std::uint64_t>(highest) - static_cast<std::uint64_t>(lowest);
  if (span / 4 <= numbers.size())
    fill_table(numbers, span);
  else
    sort_numbers(numbers);
}

void NumberLookup::fill_table(const std::vector<std::int64_t>& numbers, std::uint64_t span) {
  table_.assign(static_cast<std::size_t>(span) + 1, -1);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Eigen::Index& entry = table_[static_cast<std::uint64_t>(numbers[i]) - static_cast<std::uint64_t>(lowest_)];
    if (entry < 0)
      entry = static_cast<Eigen::Index>(i);
    else
      repeated_.emplace_back(static_cast<Eigen::Index>(i), entry);
  }
}

void NumberLookup::sort_numbers(const std::vector<std::int64_t>& numbers) {
  sorted_.reserve(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) sorted_.emplace_back(numbers[i], static_cast<Eigen::Index>(i));
  std::ranges::sort(sorted_);
  for (std::size_t i = 1; i < sorted_.size(); ++i)
    if (sorted_[i].first == sorted_[i - 1].first) repeated_.emplace_back(sorted_[i].second, sorted_[i - 1].second);
  std::ranges::sort(repeated_);
}

Eigen::Index NumberLookup::find(std::int64_t number) const {
  if (!table_.empty()) {
    const std::uint64_t position = static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(lowest_);
    return position < table_.size() ? table_[position] : -1;
  }
  const auto found = std::ranges::lower_bound(sorted_, number, {}, &std::pair<std::int64_t, Eigen::Index>::first);
  return found != sorted_.end() && found->first == number ? found->second : -1;
}

}  // namespace kalfem
