// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "kalfem/base/text.hpp"

namespace kalfem {
namespace {

/// A message stays readable: so many problems are told in full, each of them within so many bytes.
constexpr std::size_t most_told = 15, longest_part = 400, longest_name = 100;

std::string join(const std::vector<Issue>& issues) {
  std::string text;
  for (std::size_t i = 0; i < std::min(issues.size(), most_told); ++i)
    text += (text.empty() ? "" : "\n") + to_string(issues[i]);
  if (issues.size() > most_told)
    text += "\nand " + std::to_string(issues.size() - most_told) + " more problems; correct these first";
  return text;
}

/// The text in one line, its control characters shown, cut where it is too long, never inside a UTF-8 sequence.
std::string in_one_line(const std::string& text) {
  std::string line = terminal_safe(text, LineBreaks::escaped);
  if (line.size() <= longest_part) return line;
  std::size_t end = longest_part;
  while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0U) == 0x80U) --end;
  return line.substr(0, end) + " ...";
}

/// Levenshtein distance: insertions, deletions and substitutions each cost one.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, substituted}));
    }
  }
  return row.back();
}

}  // namespace

std::string to_string(const Issue& issue) {
  std::string text;
  if (!issue.location.file.empty()) {
    text += issue.location.file;
    if (issue.location.line > 0) text += ":" + std::to_string(issue.location.line);
    text += ": ";
  }
  text += in_one_line(issue.what);
  if (!issue.why.empty()) text += ": " + in_one_line(issue.why);
  if (!issue.fix.empty()) text += "; " + in_one_line(issue.fix);
  return terminal_safe(text, LineBreaks::escaped);
}

InvalidInput::InvalidInput(std::vector<Issue> issues) : std::runtime_error(join(issues)), issues_(std::move(issues)) {}

void IssueList::add(const InvalidInput& error, const SourceLocation& where_unknown) {
  for (auto issue : error.issues()) {
    if (issue.location.file.empty()) issue.location = where_unknown;
    issues_.push_back(std::move(issue));
  }
}

void IssueList::raise() const {
  if (!issues_.empty()) throw InvalidInput(issues_);
}

// Accepts at most a third of the letters wrong, and at least one. The difference of lengths is a lower bound of the
// distance, so names of very different length are skipped before the quadratic computation.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& known) {
  if (name.size() > longest_name || std::ranges::find(known, name) != known.end()) return "";
  const std::string* nearest = nullptr;
  std::size_t distance = 1 + std::max<std::size_t>(1, name.size() / 3);
  for (const auto& candidate : known) {
    const std::size_t longer = std::max(name.size(), candidate.size()),
                      shorter = std::min(name.size(), candidate.size());
    if (longer - shorter >= distance) continue;
    const std::size_t d = edit_distance(name, candidate);
    if (d < distance) {
      distance = d;
      nearest = &candidate;
    }
  }
  return nearest ? " (did you mean '" + *nearest + "'?)" : "";
}

void add_at(const SourceLocation& place, const InvalidInput& error, IssueList& issues) {
  for (const auto& [location, what, why, fix] : error.issues()) {
    const bool has_line = location.line > 0;
    const bool of_other_file = !has_line && !location.file.empty() && location.file != place.file;
    issues.add(has_line ? location : place, of_other_file ? location.file + ": " + what : what, why, fix);
  }
}

}  // namespace kalfem
