// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

/// Computes the posterior by the plan's method, whose search begins at `start`: samples, moments, evidence, diagnostics
/// and warnings of the outcome. Throws InvalidInput where no start has a likelihood, and Interrupted.
void sample_posterior(const InferencePlan& plan, const Posterior& posterior, const Eigen::VectorXd& start, int threads,
                      const Progress& progress, InferenceOutcome& outcome);

/// Moments and correlation of the outcome's samples.
void summarise_posterior(InferenceOutcome& outcome);

}  // namespace kalfem
