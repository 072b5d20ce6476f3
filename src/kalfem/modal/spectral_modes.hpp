// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/modal/modal_result.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// A second opinion on each mode, by frequency-domain decomposition [BZA01]: near the mode, at most three half-power
/// bandwidths away, the highest peak of the first singular value of the cross-spectral matrix at which the first
/// singular vector agrees with the identified shape (MAC of 0.8 and more); nothing where there is none. Spectra are
/// Welch's of half-overlapping Hann-windowed segments, whose lines lie a quarter to half of the mode's bandwidth apart;
/// segments are of 256 samples to a tenth of the record. `scale`: root mean square of each channel, whose unit it
/// becomes.
std::vector<std::optional<SpectralMode>> spectral_modes(const Record& record, const Eigen::VectorXd& scale,
                                                        const std::vector<IdentifiedMode>& modes);

}  // namespace kalfem
