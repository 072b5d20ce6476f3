// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/modal_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/channel_preparation.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr Index most_rows = 600;  ///< of the Hankel matrix that are chosen without being asked for

void check_ranges(const ModalOptions& options, double sample_rate, IssueList& issues) {
  const auto refuse = [&](bool wrong, const std::string& what, const std::string& why, const std::string& fix) {
    if (wrong) issues.add({}, what, why, fix);
  };
  const auto& limits = options.stabilisation;
  refuse(options.block_rows < 0 || options.block_rows == 1, fmt::format("block_rows: {}", options.block_rows),
         "a Hankel matrix has at least two block rows", "give 2 or more, or 0 for a choice by the record");
  refuse(options.max_order < 0 || options.max_order > 1000, fmt::format("max_order: {}", options.max_order),
         "models have orders of 2 to 1000", "give about four times the expected number of modes, or 0");
  refuse(options.blocks < 10 || options.blocks > 10000, fmt::format("blocks: {}", options.blocks),
         "the scatter of fewer than 10 blocks tells no deviation; more than 10000 are of no use", "give 50 to 200");
  if (options.band)
    refuse(
        !(options.band->from >= 0.0 && options.band->from < options.band->to && options.band->to < 0.5 * sample_rate),
        fmt::format("band: {:g} to {:g} Hz", options.band->from, options.band->to),
        fmt::format("the record is sampled at {:g} Hz and holds frequencies up to {:g} Hz", sample_rate,
                    0.5 * sample_rate),
        "give two frequencies in ascending order below half the sampling rate");
  const auto fraction = [&](const char* name, double value) {
    refuse(!(value > 0.0 && value <= 1.0), fmt::format("stabilisation.{}: {:g}", name, value),
           "it is a fraction above 0 and up to 1", "");
  };
  fraction("frequency", limits.frequency);
  fraction("damping", limits.damping);
  fraction("largest_damping", limits.largest_damping);
  fraction("frequency_std", limits.frequency_std);
  fraction("damping_std", limits.damping_std);
  fraction("least_share", limits.least_share);
  refuse(!(limits.mac > 0.0 && limits.mac < 1.0), fmt::format("stabilisation.mac: {:g}", limits.mac),
         "it is a fraction between 0 and 1", "");
}

/// Channels that hold nothing to identify from.
void check_channels(const Record& record, IssueList& issues) {
  if (record.channels.size() < 2)
    issues.add({}, fmt::format("{} channel is given", record.channels.size()),
               "modes and their shapes are identified from two channels or more", "name more channels of the record");
  for (Index row = 0; row < record.values.rows(); ++row) {
    const auto& name = record.channels[static_cast<std::size_t>(row)].name;
    const auto values = record.values.row(row).array();
    if (const Index missing = (!values.isFinite()).count(); missing > 0)
      issues.add({}, fmt::format("the channel '{}' has {} missing sample{}", name, missing, missing == 1 ? "" : "s"),
                 "correlations need every sample", "cut the record to a part without gaps, or leave the channel out");
    else if (values.size() > 0 && (values == values[0]).all())
      issues.add({}, fmt::format("the channel '{}' is {:g} throughout", name, values[0]),
                 "a channel without motion tells nothing of modes", "leave it out, and look at its sensor");
  }
}

std::vector<Index> rows_of(const Record& record, const std::vector<std::string>& names, IssueList& issues) {
  std::vector<Index> rows;
  std::vector<std::string> known;
  for (const auto& channel : record.channels) known.push_back(channel.name);
  for (const auto& name : names) {
    const Index row = record.find(name);
    if (row < 0)
      issues.add({}, fmt::format("references: there is no channel '{}'{}", name, did_you_mean(name, known)),
                 "references are among the channels that are identified from", "");
    else if (std::ranges::find(rows, row) != rows.end())
      issues.add({}, fmt::format("references: '{}' is listed twice", name), "each channel counts once", "");
    else
      rows.push_back(row);
  }
  if (names.empty()) {
    rows.resize(record.channels.size());
    std::iota(rows.begin(), rows.end(), Index{0});
  }
  return rows;
}

/// Filtered to the band, at a sampling rate of 2.5 times its upper end.
Record in_band(Record record, const FrequencyBand& band) {
  PreparedRecord prepared{.record = std::move(record)};
  const double wanted = 2.5 * band.to;
  ChannelPreparation asked{.trend = true, .high_pass = band.from};
  if (wanted < 0.9 * prepared.record.sample_rate) asked.sample_rate = wanted;
  prepare_channels(prepared, asked);
  return std::move(prepared.record);
}

/// Frequency below which a twentieth of the variance of a signal lies, by its first samples [Hz].
double low_frequency(const Eigen::VectorXd& signal, double sample_rate) {
  const CumulativeSpectrum spectrum(signal, sample_rate);
  double below = 0.0, above = 0.5 * sample_rate;
  const double wanted = 0.05 * spectrum.mean_square_below(above);
  for (int halving = 0; halving < 20; ++halving) {
    const double middle = 0.5 * (below + above);
    (spectrum.mean_square_below(middle) < wanted ? below : above) = middle;
  }
  return above;
}

/// Block rows whose lags reach over a period of the lowest frequencies that the references show.
Index rows_for_lowest(const ModalSetup& setup) {
  constexpr Index enough = 1 << 17;
  double lowest = 0.5 * setup.record.sample_rate;
  for (const Index row : setup.references)
    lowest = std::min(
        lowest, low_frequency(setup.record.values.row(row).head(std::min(enough, setup.record.samples())).transpose(),
                              setup.record.sample_rate));
  return static_cast<Index>(std::ceil(0.5 * setup.record.sample_rate / lowest));
}

void choose_sizes(ModalSetup& setup, const ModalOptions& options) {
  const Index channels = setup.record.values.rows(), references = static_cast<Index>(setup.references.size());
  setup.blocks = options.blocks;
  setup.max_order = options.max_order > 0 ? options.max_order : std::clamp<Index>(4 * channels, 30, 100);
  setup.max_order += setup.max_order % 2;
  const Index least =
      std::max((setup.max_order + references - 1) / references, (setup.max_order + channels - 1) / channels + 1);
  if (options.block_rows > 0) {
    setup.block_rows = options.block_rows;
    const Index possible = std::min((setup.block_rows - 1) * channels, setup.block_rows * references);
    setup.max_order = std::min(setup.max_order, possible - possible % 2);
  } else {
    const Index lowest = rows_for_lowest(setup), most = most_rows / channels;
    setup.block_rows = std::max({least, std::min(std::max(lowest, (3 * least + 1) / 2), most), Index{2}});
    if (lowest > 2 * setup.block_rows)
      setup.remarks.push_back(
          fmt::format("The lags reach over {:.0f} % of a period of the lowest frequencies: state the band of the "
                      "modes, so that the "
                      "record is resampled.",
                      100.0 * static_cast<double>(setup.block_rows) / static_cast<double>(lowest)));
  }
  if (setup.block_rows < least && options.max_order > setup.max_order)
    setup.remarks.push_back(fmt::format("Orders end at {}: the Hankel matrix of {} block rows has no more.",
                                        setup.max_order, setup.block_rows));
}

}  // namespace

ModalSetup make_modal_setup(const Record& given, const ModalOptions& options) {
  IssueList issues;
  check_ranges(options, given.sample_rate, issues);
  ModalSetup setup;
  setup.record = options.channels.empty() ? given : select_channels(given, options.channels);
  check_channels(setup.record, issues);
  setup.references = rows_of(setup.record, options.references, issues);
  issues.raise();
  if (options.band) setup.record = in_band(std::move(setup.record), *options.band);
  setup.record.values.colwise() -= setup.record.values.rowwise().mean().eval();
  choose_sizes(setup, options);
  const Index lags = 2 * setup.block_rows - 1, least = lags + 10 * std::max(setup.blocks, lags);
  if (setup.record.samples() < least)
    throw InvalidInput(
        fmt::format("the record has {} samples{}", setup.record.samples(),
                    options.band ? fmt::format(" at {:g} Hz", setup.record.sample_rate) : ""),
        fmt::format("correlations over {} lags with their scatter over {} blocks need {}", lags, setup.blocks, least),
        "give a longer record, fewer `block_rows` or fewer `blocks`");
  setup.scale = (setup.record.values.rowwise().squaredNorm() / static_cast<double>(setup.record.samples())).cwiseSqrt();
  return setup;
}

}  // namespace kalfem
