// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/analysis/analysis.hpp"
#include "kalfem/casefile/description.hpp"

namespace kalfem {

/// A case under construction: its sections, the records of its files, and what it cannot say.
struct CaseInMaking {
  std::string name;  ///< of its file, without the ending
  description::Case given;
  std::vector<std::pair<std::string, Record>> files = {};
  IssueList issues = {};

  /// Keeps a record for a file beside the case. Returns the file's name.
  std::string add_file(const std::string& ending, const Record& record);
  /// Adds an issue: the case has no key for something that the analysis has.
  void refuse(const std::string& what, const std::string& why, const std::string& fix = {});
};

/// `substructures`, `connectors`, `excitation`, `damping`: those of the case that the structure was read from, at its
/// present values, and what was added since.
void describe_structure(const Structure& structure, CaseInMaking& making);

/// `sensors`, `record` and `estimate`.
void describe_estimation(const Analysis& analysis, CaseInMaking& making);

/// `update`.
void describe_updating(const UpdateOptions& options, CaseInMaking& making);

}  // namespace kalfem
