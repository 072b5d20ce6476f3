#pragma once

#include <stdexcept>
#include <string>
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

}  // namespace kalfem
