// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/validation/validation.hpp"

namespace kalfem {

struct CaseStudy;

/// A part of a record that the estimates are tried on: it is not used to find them.
struct ValidationPlan : ValidationPart {
  std::string file;  ///< that holds the record
};

/// Whether the case has what a validation needs. Problems go to `issues` with their place.
void check_validation(const CaseStudy& study, IssueList& issues);

/// Reads the validation part of a case: another part of its own record, or another record, whose inputs are measured
/// in the same file or in files that the case names. Throws InvalidInput as read_measured_record() does, and if the
/// part overlaps the one that is estimated from.
ValidationPlan make_validation_plan(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
