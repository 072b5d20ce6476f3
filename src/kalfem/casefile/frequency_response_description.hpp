// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/updating/frf_set.hpp"
#include "kalfem/vibration/computed_response.hpp"

/// Frequency responses as the case file asks for them, see description.hpp.
namespace kalfem::description {

/// Lines between two frequencies, both included.
struct FrequencyBandLines {
  double from = 0.0, to = 0.0;  ///< [Hz]
  int lines = 400;
  bool logarithmic = false;  ///< evenly spaced by ratio
};
using FrequencyLines = std::variant<FrequencyBandLines, std::vector<double>>;

struct ResponseOutput {
  ResponseQuantity quantity = ResponseQuantity::acceleration;
  Name point;  ///< of strains a gauge
};

/// Frequency responses of the structure, linear about rest.
struct FrequencyResponses {
  Located<FrequencyLines> frequencies;
  std::vector<Name> inputs;  ///< points at which unit forces act, grounds that move
  std::vector<ResponseOutput> outputs;
  Located<ResponseModel> model;  ///< of the finite-element substructures
  ResponseMethod method = ResponseMethod::modal;
  std::optional<Name> substructure;  ///< alone; if empty, the whole structure
};

}  // namespace kalfem::description
