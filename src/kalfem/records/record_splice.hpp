// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// What counts as a splice, and how much around it is not trusted. Lengths in samples up to `rate`; of a faster record
/// they are as many times longer as its sampling rate is higher, because it is the motion that a fit must follow.
struct SpliceOptions {
  double rate = 500.0;         ///< [Hz]
  double noise_ratio = 5.0;    ///< the noise must change at least by this factor (either way) in half of the channels
  Eigen::Index shortest = 30;  ///< samples that each part has at least
  Eigen::Index before = 15;    ///< samples of the smooth fit on the one side
  Eigen::Index after = 30;     ///< and on the other
  int degree = 4;              ///< of the smooth fit
  Eigen::Index largest = 20;   ///< largest number of missing samples that is looked for
  Eigen::Index blanked = 2;    ///< samples on either side that are replaced by NaN, with the splice itself
};

/// What one channel says about a splice.
struct SpliceEvidence {
  std::string channel;
  double noise_before = 0.0, noise_after = 0.0;  ///< standard deviation of white noise with those third differences
  double missing = 0.0;                          ///< samples that are missing, from jump and velocity of this channel
  double weight = 0.0;  ///< 1 / standard deviation of that number, from the scatter about the fit; 0: it cannot tell
};

/// A place where two recordings with different filters, and so with different delays, were put together.
struct Splice {
  Eigen::Index sample = 0;    ///< first sample of the second part
  double time = 0.0;          ///< its time in the record as it was [s]
  double missing = 0.0;       ///< samples missing before it, as estimated
  Eigen::Index inserted = 0;  ///< samples to insert: `missing`, rounded
  Eigen::Index blanked = 0;   ///< samples on either side that are not trusted
  std::vector<SpliceEvidence> evidence;
};

/// Looks for the one strongest splice: a sample at which the noise level changes and all channels jump by the same
/// *time*, y(t) -> y(t + D), as if samples were left out between.
///
/// The noise of a channel is what its third differences show. The change point maximises the likelihood of two levels
/// of log-power, summed over the channels; it is then moved to the largest second difference nearby. The shift D of a
/// channel minimises the misfit of one polynomial to both sides, the second one moved by D; the record's D is the
/// weighted median over the channels. Samples that are not finite are left out.
///
/// Nothing is returned where the noise does not change by `noise_ratio` in half of the channels, where no second
/// difference stands out of the noise by six standard deviations, where D rounds to no or a negative number of samples,
/// or where the channels do not agree on it. Channels that stand still at the splice say nothing.
/// Throws InvalidInput on options out of range and on a sampling rate that is not positive.
std::optional<Splice> find_splice(const Record& record, const SpliceOptions& options = {});

/// The record with the missing samples inserted and the untrusted ones blanked, both as NaN; times of the first part
/// stay as they are. Throws InvalidInput where the splice lies outside the record.
Record mend(const Record& record, const Splice& splice);

/// What was found and done, in words with its evidence; one line a channel.
std::string to_string(const Splice& splice);

}  // namespace kalfem
