// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/modal/modal_options.hpp"
#include "kalfem/modal/modal_result.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Modes of a structure from its response to unknown excitation that is about white over the band: covariance-driven
/// stochastic subspace identification [PDR99], models of every second order up to the largest, with standard
/// deviations of what they give from the scatter of the correlations over blocks of the record, to first order
/// [RPDR08, DM13]. Poles that hold over the orders are modes.
///
/// Channels are of one kind of quantity or of several; the identification scales each by its root mean square. Throws
/// InvalidInput with everything that is wrong: names that the record does not have, fewer than two channels, missing
/// samples, channels without motion, a record that is too short, options out of their ranges.
ModalResult identify_modes(const Record& record, const ModalOptions& options = {});

}  // namespace kalfem
