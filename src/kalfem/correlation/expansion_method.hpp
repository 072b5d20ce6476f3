// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace kalfem {

/// How a measured shape is carried on to all degrees of freedom of a model.
enum class ExpansionMethod {
  model,   ///< the model's mode, mixed with the others as the entries ask for: the least variance of all
  serep,   ///< the combination of the paired modes that fits the entries best [OCa89]
  dynamic  ///< (K - omega^2 M) u = P^T f at the measured frequency, forces at the sensors alone; exact there [Kid73]
};

/// "model", "serep", "dynamic".
constexpr std::string_view word_of(ExpansionMethod method) {
  constexpr std::string_view words[] = {"model", "serep", "dynamic"};
  return words[static_cast<int>(method)];
}

}  // namespace kalfem
