// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "kalfem/records/frequency_response.hpp"
#include "kalfem/records/spectrum.hpp"

namespace kalfem {

struct FrfEstimateOptions {
  H1Options spectra = {};
  FrfEstimator estimator = FrfEstimator::h1;
};

/// Frequency responses of outputs y to several inputs f, from averages over the segments of one or more records
/// [BP10, 7.4]: with S_ff = sum f f^H, S_yf = sum y f^H,
///     H1 = S_yf S_ff^-1,   H2 = S_yy / S_fy (one input),
///     Hv: y = H f from the eigenvector of the smallest eigenvalue of the spectra of [f; y], one output at a time, each
///     signal in units of its root mean square.
/// Deviation of each part, by the multiple coherence gamma^2 = S_yf S_ff^-1 S_fy / S_yy and the effective averages n_d
/// of estimate_h1(): sigma_oi^2 = S_yy (1 - gamma^2) (S_ff^-1)_ii / (2 (n_d - inputs)); without more averages than
/// inputs the deviations are not known. Lines at which inputs have no power, or are one, are left out.
///
/// Throws InvalidInput as estimate_h1() does, without an input or output, for H2 of several inputs, with fewer averages
/// than inputs, and where inputs are one at nearly all lines.
FrfMatrix estimate_frfs(std::span<const Record> records, const std::vector<std::string>& inputs,
                        const std::vector<std::string>& outputs, const FrfEstimateOptions& options);

}  // namespace kalfem
