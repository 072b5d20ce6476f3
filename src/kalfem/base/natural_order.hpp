// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// Whether one name stands before another for a reader: runs of digits compare as numbers, so that k2 stands before
/// k10, everything else byte by byte. Names that differ only in leading zeros stand in the order of their bytes, which
/// makes this a strict order of all texts.
bool natural_less(std::string_view one, std::string_view other);

/// The names as tables, legends and lists show them where nothing else gives their order.
inline std::vector<std::string> in_natural_order(std::vector<std::string> names) {
  std::ranges::sort(names, natural_less);
  return names;
}

}  // namespace kalfem
