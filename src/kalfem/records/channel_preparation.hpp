// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/records/record_preparation.hpp"

namespace kalfem {

/// A part of a record, by times of the file [s]; where an end is not given, it is that of the record.
struct RecordPart {
  std::optional<double> from = {}, to = {};
};

/// What is done to the channels of a measured record, in this order. The default does nothing.
struct ChannelPreparation {
  std::optional<RecordPart> offset = {};   ///< each channel's mean over this part is subtracted
  bool trend = false;                      ///< the straight line of least squares is subtracted
  double high_pass = 0.0;                  ///< [Hz], zero_phase_filter.hpp; 0: none
  double low_pass = 0.0;                   ///< [Hz]; 0: none
  std::optional<double> sample_rate = {};  ///< [Hz], resampling.hpp
};

/// Prepares all channels alike and adds each step to the preparation in words. Missing samples stay missing and count
/// nowhere. Throws InvalidInput where the part of the offset holds no sample, where the limit of a filter is not
/// between 0 and half of the sampling rate, or the high-pass is not below the low-pass, and for a higher sampling rate.
void prepare_channels(PreparedRecord& prepared, const ChannelPreparation& asked);

}  // namespace kalfem
