// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/inference/inference_result.hpp"

namespace kalfem {

/// Numbers that are held fixed, and that the problem's estimation knows to a stated deviation (known_to), become
/// unknowns that the posterior integrates out: by the filter, within its state, where the likelihood is its own; gains
/// and delays of sensors, numbers of finite elements and all numbers of a simulation by samples, as the last of the
/// problem's parameters (InferenceProblem::marginalised). Problems go to `issues`: numbers of excitations, and gains
/// where `method: filter` has no samples.
void marginalise_stated_numbers(InferenceProblem& problem, IssueList& issues);

/// Takes the last parameters out of a result.
void drop_marginalised(std::size_t count, InferenceResult& result);

}  // namespace kalfem
