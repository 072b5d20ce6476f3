// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/api/estimate.hpp"
#include "kalfem/live/filter_problem.hpp"

namespace kalfem {

/// The caller's options as a problem of identification/, with the filter's model. Looks up every name. `sample_rate`:
/// of the record [Hz]. Throws InvalidInput with every argument that is wrong.
FilterProblem make_filter_problem(const Structure& structure, double sample_rate, const EstimateOptions& options);

/// Adds an issue for each unknown that is a number of the measurement: they are found by estimate() alone.
void refuse_measurement_unknowns(const std::vector<UnknownDescription>& unknowns, IssueList& issues);

/// Unit of a description's output, in SI.
std::string unit_of(const OutputDescription& output);

/// Adds the issues of what `work` throws, each behind `place`.
template <class Work>
void collect(const std::string& place, IssueList& issues, const Work& work) try {
  work();
} catch (const InvalidInput& error) {
  for (const auto& issue : error.issues()) issues.add({}, place + issue.what, issue.why, issue.fix);
}

}  // namespace kalfem
