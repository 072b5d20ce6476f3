#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// Named values in file order.
template <class T>
using Named = std::vector<std::pair<std::string, T>>;

/// A value and where the user gave it, for problems that show only when everything is put together. Library programs
/// leave the place empty.
template <class T>
struct Located {
  T value{};
  SourceLocation location{};
  std::string path{};

  /// An issue about the value, with its place.
  [[nodiscard]] Issue issue(const std::string& what, std::string why = {}, std::string fix = {}) const {
    return {location, path + ": " + what, std::move(why), std::move(fix)};
  }
  /// Equal values; the place does not matter.
  bool operator==(const Located& other) const { return value == other.value; }
};

/// A name that is looked up later.
using Name = Located<std::string>;

/// Adds problems to `issues`: those that know no line, such as those of an .h5 file, at `place`.
void add_at(const SourceLocation& place, const InvalidInput& error, IssueList& issues);

}  // namespace kalfem
