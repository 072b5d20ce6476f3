// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace kalfem {

/// Where in the user's input a problem stands; `line` is 1-based, 0 where a file has no lines.
struct SourceLocation {
  std::string file;
  int line = 0;
};

/// One problem that the user can mend: the fact, why it matters and what would be right.
struct Issue {
  SourceLocation location;
  std::string what;  ///< the fact, with the name and the value that was found
  std::string why;   ///< the requirement that it breaks (may be empty)
  std::string fix;   ///< what to write instead (may be empty)
};

/// "file:line: what: why; fix" in one line.
std::string to_string(const Issue& issue);

/// Input that the user can mend. Carries every problem that was found, not only the first.
class InvalidInput : public std::runtime_error {
public:
  explicit InvalidInput(std::vector<Issue> issues);
  explicit InvalidInput(Issue issue) : InvalidInput(std::vector<Issue>{std::move(issue)}) {}
  /// A problem without a place in a file: a precondition of a library function.
  InvalidInput(std::string what, std::string why, std::string fix)
      : InvalidInput(Issue{{}, std::move(what), std::move(why), std::move(fix)}) {}

  [[nodiscard]] const std::vector<Issue>& issues() const { return issues_; }

private:
  std::vector<Issue> issues_;
};

/// Collects problems so that they are reported together.
class IssueList {
public:
  void add(SourceLocation location, std::string what, std::string why = {}, std::string fix = {}) {
    issues_.push_back({std::move(location), std::move(what), std::move(why), std::move(fix)});
  }
  void add(const InvalidInput& error, const SourceLocation& where_unknown);
  [[nodiscard]] bool empty() const { return issues_.empty(); }
  [[nodiscard]] const std::vector<Issue>& issues() const { return issues_; }
  /// Throws InvalidInput with everything collected; does nothing when there is nothing.
  void raise() const;

private:
  std::vector<Issue> issues_;
};

/// The known name nearest to `name` by edit distance, as " (did you mean 'x'?)", or "" when none is near.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& known);

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
