#include "kalfem/base/located.hpp"

namespace kalfem {

void add_at(const SourceLocation& place, const InvalidInput& error, IssueList& issues) {
  for (const auto& [location, what, why, fix] : error.issues()) {
    const bool has_line = location.line > 0;
    const bool of_other_file = !has_line && !location.file.empty() && location.file != place.file;
    issues.add(has_line ? location : place, of_other_file ? location.file + ": " + what : what, why, fix);
  }
}

}  // namespace kalfem
