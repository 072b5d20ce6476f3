#include "kalfem/yaml/case_reader.hpp"

#include <algorithm>
#include <limits>

namespace kalfem {

void raise_in_line_order(const IssueList& issues) {
  auto sorted = issues.issues();
  if (sorted.empty()) return;
  const std::string first_file = sorted.front().location.file;
  const auto place = [&](const Issue& issue) {
    const int line = issue.location.line > 0 ? issue.location.line : std::numeric_limits<int>::max();
    return std::pair(issue.location.file != first_file, line);
  };
  std::ranges::stable_sort(sorted, {}, place);
  throw InvalidInput(std::move(sorted));
}

}  // namespace kalfem
