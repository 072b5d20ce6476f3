#include "kalfem/casefile/case_reader.hpp"

namespace kalfem {

void raise_in_line_order(const IssueList& issues) {
  auto sorted = issues.issues();
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Issue& a, const Issue& b) { return a.location.line < b.location.line; });
  if (!sorted.empty()) throw InvalidInput(std::move(sorted));
}

}  // namespace kalfem
