// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/vibration/frequency_responses.hpp"

namespace kalfem {

class IssueList;
namespace description {
struct Case;
}

/// Frequency responses that a case asks for, with every name looked up.
struct FrequencyResponsePlan : FrequencyResponseProblem {
  SourceLocation lines_at;  ///< where the case states the frequencies
};

/// Problems go to `issues` with their place: unknown points and grounds, grounds at which nothing ends, connectors
/// without tangents at rest, and reduced models of structures without finite elements.
FrequencyResponsePlan make_frequency_response_plan(const description::Case& given, const StructureModel& structure,
                                                   IssueList& issues);

}  // namespace kalfem
