// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/mode_tracks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/modal/shape_measures.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Rows of the channels that all records have, by record.
std::vector<std::vector<Index>> common_rows(const std::vector<ModalResult>& records) {
  std::vector<std::vector<Index>> rows(records.size());
  for (const auto& name : records.front().channels) {
    std::vector<Index> found;
    for (const auto& record : records)
      if (const auto at = std::ranges::find(record.channels, name); at != record.channels.end())
        found.push_back(at - record.channels.begin());
    if (found.size() < records.size()) continue;
    for (std::size_t i = 0; i < records.size(); ++i) rows[i].push_back(found[i]);
  }
  return rows;
}

void check(const std::vector<ModalResult>& records, const std::vector<std::vector<Index>>& rows,
           const MatrixXd& covariates) {
  IssueList issues;
  if (rows.front().empty())
    issues.add({}, "the records have no channel in common", "a mode is recognised by its shape",
               "give records of the same sensors");
  if (covariates.cols() > 0 && covariates.rows() != std::ssize(records))
    issues.add({}, fmt::format("{} rows of covariates for {} records", covariates.rows(), records.size()),
               "each record has its own", "give one row a record, in the order of the records");
  else if (!covariates.allFinite())
    issues.add({}, "a covariate is not finite", "frequencies are followed over it", "");
  issues.raise();
}

/// A pair of a track and a mode of the next record.
struct Candidate {
  std::size_t track, mode;
  double gain;
};

class Tracker {
public:
  Tracker(const std::vector<ModalResult>& records, std::vector<std::vector<Index>> rows, const TrackOptions& options)
      : records_(records), rows_(std::move(rows)), options_(options) {}

  std::vector<ModeTrack> run() {
    for (std::size_t record = 0; record < records_.size(); ++record) follow(record);
    std::ranges::sort(tracks_, {}, [&](const ModeTrack& track) {
      const std::size_t last = last_of(track);
      return records_[last].modes[*track.modes[last]].frequency;
    });
    return std::move(tracks_);
  }

private:
  [[nodiscard]] static std::size_t last_of(const ModeTrack& track) {
    std::size_t last = track.modes.size();
    while (!track.modes[last - 1]) --last;
    return last - 1;
  }

  /// Nothing where two modes are not the same; otherwise the more, the nearer they are.
  [[nodiscard]] std::optional<double> agreement(const ModeTrack& track, std::size_t record, std::size_t mode) const {
    const std::size_t last = last_of(track);
    const auto &before = records_[last].modes[*track.modes[last]], &now = records_[record].modes[mode];
    const double moved = std::abs(now.frequency / before.frequency - 1.0) / options_.frequency;
    const double alike = mac(before.shape(rows_[last]), now.shape(rows_[record]));
    if (moved > 1.0 || (rows_[record].size() > 1 && alike < options_.mac)) return {};
    return alike - moved;
  }

  void follow(std::size_t record) {
    std::vector<Candidate> candidates;
    for (std::size_t t = 0; t < tracks_.size(); ++t)
      for (std::size_t m = 0; m < records_[record].modes.size(); ++m)
        if (const auto gain = agreement(tracks_[t], record, m)) candidates.push_back({t, m, *gain});
    std::ranges::stable_sort(candidates, std::ranges::greater(), &Candidate::gain);
    for (auto& track : tracks_) track.modes.emplace_back();
    std::vector<bool> taken(records_[record].modes.size());
    for (const auto& [track, mode, gain] : candidates) {
      if (tracks_[track].modes.back() || taken[mode]) continue;
      tracks_[track].modes.back() = mode;
      taken[mode] = true;
    }
    for (std::size_t m = 0; m < taken.size(); ++m)
      if (!taken[m]) {
        ModeTrack begun;
        begun.modes.resize(record + 1);
        begun.modes.back() = m;
        tracks_.push_back(std::move(begun));
      }
  }

  const std::vector<ModalResult>& records_;
  std::vector<std::vector<Index>> rows_;
  TrackOptions options_;
  std::vector<ModeTrack> tracks_;
};

/// Mean, slopes and spread over the records that have the mode; the covariates that do not vary there are no reason to
/// refuse the others.
template <class Get>
TrackTrend trend_of(const ModeTrack& track, const std::vector<ModalResult>& records, const MatrixXd& covariates,
                    const Get& member_of) {
  std::vector<PopulationMember> members;
  std::vector<Index> rows;
  for (std::size_t i = 0; i < track.modes.size(); ++i)
    if (track.modes[i]) {
      members.push_back(member_of(records[i].modes[*track.modes[i]]));
      rows.push_back(static_cast<Index>(i));
    }
  const MatrixXd there = covariates.cols() > 0 ? MatrixXd(covariates(rows, Eigen::all)) : MatrixXd(rows.size(), 0);
  try {
    return population_trend(members, there);
  } catch (const InvalidInput&) {  // too few records, or all at one temperature
    return {};
  }
}

}  // namespace

std::vector<ModeTrack> track_modes(const std::vector<ModalResult>& records, const MatrixXd& covariates,
                                   const TrackOptions& options) {
  if (records.size() < 2)
    throw InvalidInput(fmt::format("{} given", records.empty() ? "no record" : "one record"),
                       "modes are followed from record to record", "give two records or more");
  auto rows = common_rows(records);
  check(records, rows, covariates);
  auto tracks = Tracker(records, std::move(rows), options).run();
  for (auto& track : tracks) {
    track.frequency = trend_of(track, records, covariates, [](const IdentifiedMode& mode) {
      return PopulationMember{mode.frequency, mode.frequency_std()};
    });
    track.damping = trend_of(track, records, covariates, [](const IdentifiedMode& mode) {
      return PopulationMember{mode.damping, mode.damping_std()};
    });
  }
  return tracks;
}

}  // namespace kalfem
