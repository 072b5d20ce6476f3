// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/frequency_response_description.hpp"
#include "kalfem/identification/structure.hpp"
#include "kalfem/updating/frf_set.hpp"

namespace kalfem {

class IssueList;
namespace description {
struct Case;
}

/// Frequency responses that a case asks for, with every name looked up.
struct FrequencyResponsePlan {
  Eigen::VectorXd frequencies;  ///< [Hz], ascending
  SourceLocation lines_at;      ///< where the case states them
  std::vector<FrfSet> sets;     ///< of each input, one for each quantity of its outputs
  description::ResponseModel model = description::ResponseModel::full;
  description::ResponseMethod method = description::ResponseMethod::modal;
  StructureParts parts;  ///< finite elements at full order; the inputs are the grounds that move
  std::vector<FiniteElementSubstructure> finite_elements;  ///< in the order of parts.finite_elements
  std::shared_ptr<const LinearModel> full;                 ///< of the parts, linear about rest
};

/// Problems go to `issues` with their place: unknown points and grounds, grounds at which nothing ends, connectors
/// without tangents at rest, and reduced models of structures without finite elements.
FrequencyResponsePlan make_frequency_response_plan(const description::Case& given, const StructureModel& structure,
                                                   IssueList& issues);

}  // namespace kalfem
