// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/record_check.hpp"

#include <fmt/format.h>

#include <cmath>

#include "kalfem/page/words.hpp"
#include "kalfem/records/channel_statistics.hpp"
#include "kalfem/report/inspection.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {
namespace {

constexpr double odd_size = 3.0;           ///< ratio of the record to the model, or of the model to the record
constexpr double clear_correlation = 0.5;  ///< record and model move alike, or oppositely

/// A row of the prepared record as a channel of a file.
MeasuredChannel channel_of_record(const Record& record, Eigen::Index j) {
  const auto& channel = record.channels[static_cast<std::size_t>(j)];
  return {.name = channel.name,
          .unit = channel.unit,
          .start = record.start,
          .interval = 1.0 / record.sample_rate,
          .values = record.values.row(j).transpose()};
}

void add_findings(const std::string& name, const ChannelExpectation& expected, std::vector<std::string>& findings) {
  if (!(expected.rms > 0.0)) {
    findings.push_back(name + ": in the model nothing moves there: are its point and the excitation right?");
    return;
  }
  if (expected.correlation < -clear_correlation)
    findings.push_back(fmt::format("{}: the model moves the other way (correlation {}): is its sign right?", name,
                                   four_digits(expected.correlation)));
  if (expected.ratio > odd_size || expected.ratio < 1.0 / odd_size)
    findings.push_back(
        fmt::format("{}: its rms is {} times that of the model: are its unit and the excitation's right?", name,
                    four_digits(expected.ratio)));
}

}  // namespace

RecordCheck check_record(const Study& study, const RecordExpectation& expectation) {
  const Record& record = study.record->record;
  RecordCheck check{
      {"Channels of the record beside the model of the case, from rest",
       {"sensor", "unit", "offset", "rms", "peak", "frequencies [Hz]", "rms of the model", "ratio", "correlation"},
       {},
       {}},
      {}};
  for (Eigen::Index j = 0; j < record.values.rows(); ++j) {
    const MeasuredChannel channel = channel_of_record(record, j);
    const ChannelStatistics found = statistics_of(channel);
    std::vector<std::string> row = {channel.name,
                                    channel.unit,
                                    four_digits(found.offset),
                                    four_digits(found.rms),
                                    four_digits(found.peak),
                                    frequencies_text(found)};
    for (const auto& words : findings_of(channel, found)) check.findings.push_back(channel.name + ": " + words);
    if (expectation.channels.empty()) {
      row.insert(row.end(), {"-", "-", "-"});
    } else {
      const auto& expected = expectation.channels[static_cast<std::size_t>(j)];
      row.insert(row.end(), {four_digits(expected.rms), expected.rms > 0.0 ? four_digits(expected.ratio) : "-",
                             expected.rms > 0.0 ? four_digits(expected.correlation) : "-"});
      add_findings(channel.name, expected, check.findings);
    }
    check.table.rows.push_back(std::move(row));
  }
  if (expectation.channels.empty()) check.findings.push_back("No expectation of the model: " + expectation.reason);
  return check;
}

}  // namespace kalfem
