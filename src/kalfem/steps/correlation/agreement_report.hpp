// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/correlation/outcome.hpp"

namespace kalfem {

/// Each response with its FRAC, and how large and in which phase the model's is.
Table agreement_table(const CorrelatedResponses& compared);
nlohmann::ordered_json json_of(const std::vector<ResponseAgreement>& responses);

}  // namespace kalfem
