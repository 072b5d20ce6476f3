// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/records/channel_statistics.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// A file of a test bench and what its channels say by themselves.
struct Inspection {
  std::string file;
  MeasuredFile content;
  std::vector<ChannelStatistics> channels;  ///< one a channel of the content
};

Inspection inspect(std::string file, MeasuredFile content);

/// What is odd about a channel, a sentence each: dead, clipped, held, missing samples, gaps, jitter, drift.
std::vector<std::string> findings_of(const MeasuredChannel& channel, const ChannelStatistics& statistics);

/// The dominant frequencies [Hz], the strongest first; "-" where there is none.
std::string frequencies_text(const ChannelStatistics& statistics);

/// "12 +x": node and direction, as far as they are known.
std::string place_text(const MeasuredPlace& place);

/// Tables of channels, functions and shapes, then the findings and what was skipped.
std::string inspection_text(const Inspection& inspection);

/// The same for programs. Numbers that are not known are null.
nlohmann::ordered_json inspection_json(const Inspection& inspection);

/// The same as a page, with the course of each channel.
Page inspection_page(const std::vector<Inspection>& inspections);

}  // namespace kalfem
