// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/making_steps.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

StudyItem section_with_key(const std::string& key) {
  using enum StudyItem;
  static constexpr std::array<std::pair<std::string_view, StudyItem>, 22> sections{
      {{"kalfem", version},
       {"title", title},
       {"substructures", substructures},
       {"connectors", connectors},
       {"joints", joints},
       {"component", component},
       {"damping", damping},
       {"excitation", excitation},
       {"sensors", sensors},
       {"simulate", simulate},
       {"record", record},
       {"live", live},
       {"estimate", estimate},
       {"validate", validate},
       {"predict", predict},
       {"update", update},
       {"modifications", modifications},
       {"infer", infer},
       {"place", place},
       {"static", statics},
       {"frequency_response", frequency_response},
       {"report", report}}};
  const auto section = std::ranges::find(sections, key, [](const auto& entry) { return entry.first; });
  return section == sections.end() ? other_keys : section->second;
}

MakingSteps::MakingSteps(const CaseSource& source, const IssueList& found_by_reader)
    : source_(source), issues_(found_by_reader), not_read_(sections_of(found_by_reader)), unsound_(not_read_) {}

std::set<StudyItem> MakingSteps::sections_of(const IssueList& issues) const {
  std::set<StudyItem> sections;
  for (const auto& key : source_.sections_of(issues.issues())) sections.insert(section_with_key(key));
  return sections;
}

void MakingSteps::run(const MakingStep& step, const std::function<void(IssueList&)>& make) {
  if (!std::ranges::all_of(step.needs, [&](StudyItem item) { return is_sound(item); })) {
    unsound_.insert(step.result);
    return;
  }
  IssueList found, placed;
  try {
    make(found);
  } catch (const InvalidInput& error) {
    add_at(source_.at(step.key), error, found);
  }
  if (found.empty()) return;
  add_at(source_.at(step.key), InvalidInput(found.issues()), placed);
  unsound_.insert(step.result);
  unsound_.merge(sections_of(placed));
  for (const auto& [location, what, why, fix] : placed.issues()) issues_.add(location, what, why, fix);
}

}  // namespace kalfem
