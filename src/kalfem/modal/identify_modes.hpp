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

/// Modes of a structure from frequency responses to known forces, or to motions of its base: the poly-reference
/// least-squares complex frequency-domain method (p-LSCF, "PolyMAX") [GVVP03, PVGL04] for every degree up to
/// `max_order` (default 120) over the number of inputs, stabilisation as of the subspace method, then a modal model
/// with all stable poles, fitted to all responses by least squares, which gives frequencies, dampings, shapes and their
/// covariances. `channels` are the outputs; `band` the lines that are used; `references`, `block_rows` and `blocks`
/// have no meaning here.
///
/// Standard deviations come from the scatter of the responses about the fit; given deviations weigh the lines. Throws
/// InvalidInput with everything that is wrong: sizes that do not fit, values that are not finite, fewer than two
/// outputs or 32 lines, an output without motion, options out of their ranges.
ModalResult identify_modes(const FrfMatrix& responses, const ModalOptions& options = {});

}  // namespace kalfem
