#pragma once

#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem::abaqus {

/// A place in one of a deck's files.
struct Where {
  int file = 0;  ///< in the order of their first opening
  int line = 0;  ///< 1-based
};

/// The files of a deck and the problems found in them; the twentieth ends the reading.
class Problems {
public:
  int add_file(const std::string& name);
  [[nodiscard]] const std::string& file(int index) const { return files_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] SourceLocation location(const Where& where) const { return {file(where.file), where.line}; }

  /// Notes a problem and goes on, unless there are too many.
  void add(const Where& where, std::string what, std::string why = {}, std::string fix = {});
  /// Notes a problem and stops here.
  [[noreturn]] void fail(const Where& where, std::string what, std::string why = {}, std::string fix = {});
  /// Throws InvalidInput when there was any.
  void raise() const { issues_.raise(); }
  [[nodiscard]] bool empty() const { return issues_.empty(); }

private:
  std::vector<std::string> files_;
  IssueList issues_;
};

}  // namespace kalfem::abaqus
