// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/pipeline/inference_outcome.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// The Bayesian inference for summary.json. SI; null where a number is unknown or not finite.
nlohmann::ordered_json inference_summary(const InferenceOutcome& outcome);

/// Sentences and tables as a person reads them on a terminal.
std::string console_inference(const InferenceOutcome& outcome);

/// The same on the page, with a corner plot, profile likelihoods and predictive bands.
Section inference_section(const InferenceOutcome& outcome);

}  // namespace kalfem
