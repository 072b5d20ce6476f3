// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// A force f(x, v; p) [N] of deformation [m], rate [m/s] and parameters, with C's calling convention: what a library of
/// one's own or a compiler within another language (numba's cfunc) gives. It may be called from several threads at
/// once.
using CompiledForce = double (*)(double deformation, double rate, const double* parameters);

/// Parameters that a compiled law may have.
inline constexpr std::size_t most_compiled_parameters = 32;

/// A law of a compiled function, with tangents by central differences, five calls a point. `owner` keeps alive what
/// the function lives in. Throws InvalidInput for a null function or too many parameters.
ConnectorLawPtr compiled_law(std::string name, std::vector<LawQuantity> parameters, CompiledForce force,
                             std::shared_ptr<const void> owner = {});

}  // namespace kalfem
