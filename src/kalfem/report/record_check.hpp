// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/record/record_expectation.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What the channels of a case's measured record are, beside what its model expects of them.
struct RecordCheck {
  Table table;
  std::vector<std::string> findings;  ///< what is odd about a channel by itself, and against the model; a sentence each
};

RecordCheck check_record(const Study& study, const RecordExpectation& expectation);

}  // namespace kalfem
