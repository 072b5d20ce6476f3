// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// A section of the case, or a result that the making of a study derives from sections. It is unsound as soon as a
/// problem was found in it, or in something that it needs.
enum class StudyItem {
  // sections, by their keys; `other_keys` stands for keys that a case does not have
  version,
  title,
  substructures,
  connectors,
  joints,
  component,
  damping,
  excitation,
  sensors,
  simulate,
  record,
  live,
  estimate,
  validate,
  predict,
  update,
  modifications,
  infer,
  place,
  statics,
  frequency_response,
  report,
  other_keys,
  // results
  agreement_of_sections,
  joint_names,
  elements,
  parts,
  joined_nodes,
  names,
  model,
  placed_sensors,
  record_noise,
  signals,
  pictures,
  parameters,
  comparisons,
  modified_frequencies,
  augmented_model,
  filter,
  driven_substructure,
  driven_comparisons,
  validation,
  alternatives,
  inference,
  placement,
  static_analysis,
  responses,
  stream
};
using StudyItems = std::vector<StudyItem>;

/// The section with that key; other_keys where a case has no such key.
StudyItem section_with_key(const std::string& key);

/// One step of the making of a study.
struct MakingStep {
  StudyItem result;              ///< unsound after a problem; a step that only checks a section names that section
  StudyItems needs;              ///< the step runs only if all of these are sound
  std::vector<std::string> key;  ///< of the case: the place of problems that do not state theirs
};

/// Runs the steps of the making of a study and collects their problems. A step is skipped if something that it needs is
/// unsound. So independent problems are told together, and no problem is told that only follows from another.
class MakingSteps {
public:
  /// `found_by_reader`: the problems that the reader of the case file found.
  MakingSteps(const CaseSource& source, const IssueList& found_by_reader);

  /// Runs `make` if the step's needs are sound. `make` adds its problems to the list or throws InvalidInput. They make
  /// unsound the step's result and the sections at whose lines they stand.
  void run(const MakingStep& step, const std::function<void(IssueList&)>& make);

  [[nodiscard]] bool is_sound(StudyItem item) const { return !unsound_.contains(item); }
  /// Whether the reader of the case file found no problem in this section.
  [[nodiscard]] bool was_read(StudyItem section) const { return !not_read_.contains(section); }
  [[nodiscard]] const IssueList& issues() const { return issues_; }

private:
  [[nodiscard]] std::set<StudyItem> sections_of(const IssueList& issues) const;

  CaseSource source_;
  IssueList issues_;
  std::set<StudyItem> not_read_, unsound_;
};

}  // namespace kalfem
