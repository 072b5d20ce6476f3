// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/records/record.hpp"

namespace kalfem {

/// The record at a lower sampling rate [Hz], from its first sample on. An anti-alias filter without phase, a sinc with
/// a Kaiser window, passes frequencies up to 0.4 of the new rate unchanged and takes away 100 dB from half of it on
/// [Kai74]. Any ratio of the rates is possible. The ends are reflected (signal_continuation.hpp). A new sample is
/// missing where missing ones had more than a fiftieth of its weights.
///
/// White noise becomes smaller: its variance falls to 0.9 of the ratio of the rates, and the correlation of
/// neighbours is 0.12.
///
/// Throws InvalidInput where the new rate is higher than the old one: samples that were not measured say nothing.
Record resampled(const Record& record, double sample_rate);

}  // namespace kalfem
