// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/tracks_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

/// Two digits of what the interval leaves open.
int place_of(const PopulationEstimate& told) { return last_place(0.25 * (told.interval[1] - told.interval[0])); }

std::string with_interval(const PopulationEstimate& told, double factor = 1.0) {
  const PopulationEstimate shown{factor * told.median, {factor * told.interval[0], factor * told.interval[1]}};
  const int place = place_of(shown);
  return fmt::format("{} ({} to {})", rounded_at(place, shown.median), rounded_at(place, shown.interval[0]),
                     rounded_at(place, shown.interval[1]));
}

/// The mode of a record that the track passes; null where it was not found.
const IdentifiedMode* mode_of(const TrackedRecords& tracked, const ModeTrack& track, std::size_t record) {
  return track.modes[record] ? &tracked.results[record].modes[*track.modes[record]] : nullptr;
}

Table track_table(const TrackedRecords& tracked) {
  Table table{.title = "Modes followed through " + counted(std::ssize(tracked.results), "record") +
                       ", medians and 95 % intervals" +
                       (tracked.covariates.empty() ? "" : "; at the mean of the covariates"),
              .columns = {"mode", "records", "frequency [Hz]", "scatter [%]", "damping [%]"}};
  for (const auto& name : tracked.covariates) table.columns.push_back("% of f per " + name);
  for (std::size_t i = 0; i < tracked.tracks.size(); ++i) {
    const auto& track = tracked.tracks[i];
    const auto found = std::ranges::count_if(track.modes, [](const auto& mode) { return mode.has_value(); });
    std::vector<std::string> row(table.columns.size(), "-");
    row[0] = std::to_string(i + 1);
    row[1] = std::to_string(found);
    if (const auto& f = track.frequency) {
      const double per_cent_of = 100.0 / f->mean.median;
      row[2] = with_interval(f->mean);
      row[3] = with_interval(f->spread, per_cent_of);
      for (std::size_t k = 0; k < f->slopes.size(); ++k) row[5 + k] = with_interval(f->slopes[k], per_cent_of);
    }
    if (track.damping) row[4] = with_interval(track.damping->mean, 100.0);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Json told_json(const PopulationEstimate& told) {
  return {{"median", number(told.median)}, {"interval", told.interval}};
}

Json trend_json(const TrackTrend& trend) {
  if (!trend) return nullptr;
  Json json{{"mean", told_json(trend->mean)}, {"spread", told_json(trend->spread)}, {"slopes", Json::array()}};
  for (const auto& slope : trend->slopes) json["slopes"].push_back(told_json(slope));
  return json;
}

std::string tracks_csv(const TrackedRecords& tracked) {
  std::string text = "record";
  for (const auto& name : tracked.covariates) text += "," + name;
  for (std::size_t m = 1; m <= tracked.tracks.size(); ++m)
    text += fmt::format(",f{0} [Hz],f{0}_std [Hz],zeta{0},zeta{0}_std", m);
  text += "\n";
  for (std::size_t i = 0; i < tracked.results.size(); ++i) {
    text += std::to_string(i + 1);
    for (Index k = 0; k < tracked.values.cols(); ++k) text += "," + shortest(tracked.values(static_cast<Index>(i), k));
    for (const auto& track : tracked.tracks)
      if (const auto* mode = mode_of(tracked, track, i))
        text += fmt::format(",{},{},{},{}", shortest(mode->frequency), shortest(mode->frequency_std()),
                            shortest(mode->damping), shortest(mode->damping_std()));
      else
        text += ",,,,";
    text += "\n";
  }
  return text;
}

/// Frequencies over the records, in per cent of their mean, with 95 % bands.
Chart frequency_chart(const TrackedRecords& tracked) {
  Chart chart{.title = "Frequencies over the records", .x_label = "record", .y_label = "off the mean [%]"};
  for (std::size_t i = 1; i <= tracked.results.size(); ++i) chart.x.push_back(static_cast<double>(i));
  for (std::size_t m = 0; m < tracked.tracks.size(); ++m) {
    const auto& track = tracked.tracks[m];
    if (!track.frequency) continue;
    Series series{.label = fmt::format("mode {}, {} Hz", m + 1, four_digits(track.frequency->mean.median))};
    for (std::size_t i = 0; i < tracked.results.size(); ++i) {
      const auto* mode = mode_of(tracked, track, i);
      const double nan = std::numeric_limits<double>::quiet_NaN();
      const double off = mode ? 100.0 * (mode->frequency / track.frequency->mean.median - 1.0) : nan;
      const double half =
          mode ? 100.0 * mode->coverage_factor() * mode->frequency_std() / track.frequency->mean.median : nan;
      series.y.push_back(off);
      series.lower.push_back(off - half);
      series.upper.push_back(off + half);
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::string tracks_text(const TrackedRecords& tracked) {
  if (tracked.tracks.empty()) return "No mode was found in any record.\n";
  const Table table = without_empty_columns(track_table(tracked));
  return table.title + "\n" + to_text(table);
}

Json tracks_json(const TrackedRecords& tracked) {
  Json json{{"kalfem", version}, {"records", tracked.names}, {"covariates", Json::object()}, {"tracks", Json::array()}};
  for (std::size_t k = 0; k < tracked.covariates.size(); ++k)
    for (const double value : tracked.values.col(static_cast<Index>(k)))
      json["covariates"][tracked.covariates[k]].push_back(number(value));
  for (const auto& track : tracked.tracks) {
    Json modes = Json::array();
    for (std::size_t i = 0; i < tracked.results.size(); ++i) {
      modes.push_back(nullptr);
      if (const auto* mode = mode_of(tracked, track, i))
        modes.back() = {{"mode", *track.modes[i] + 1},
                        {"frequency_hz", number(mode->frequency)},
                        {"frequency_std_hz", number(mode->frequency_std())},
                        {"damping", number(mode->damping)},
                        {"damping_std", number(mode->damping_std())}};
    }
    json["tracks"].push_back({{"frequency_hz", trend_json(track.frequency)},
                              {"damping", trend_json(track.damping)},
                              {"records", std::move(modes)}});
  }
  return json;
}

Page tracks_page(const TrackedRecords& tracked) {
  Page page{.title = counted(std::ssize(tracked.results), "record"),
            .subtitle = "Modes followed from record to record",
            .summary = counted(std::ssize(tracked.tracks), "mode") + "."};
  Section section{.heading = "Modes",
                  .text =
                      "Scatter is the standard deviation of the true values beside the covariates: what the "
                      "records' own deviations explain is not in it."};
  section.items.emplace_back(without_empty_columns(track_table(tracked)));
  if (auto chart = frequency_chart(tracked); !chart.series.empty()) section.items.emplace_back(std::move(chart));
  page.sections.push_back(std::move(section));
  return page;
}

void write_tracks(const std::filesystem::path& folder, const TrackedRecords& tracked) {
  write_file_atomically(folder / "tracks.json",
                        tracks_json(tracked).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  write_file_atomically(folder / "tracks.csv", tracks_csv(tracked));
}

}  // namespace kalfem
