#include "kalfem/study/record_source.hpp"

#include <cmath>
#include <limits>

#include "kalfem/records/free_response.hpp"
#include "kalfem/records/record_splice.hpp"

namespace kalfem {
namespace {

using description::Observed;
using Eigen::Index;

void check_finite(const TimeSeries& series, const description::Record& record) {
  if (record.skip_missing || record.repair_splice || series.values.allFinite()) return;
  IssueList issues;
  for (Index j = 0; j < series.values.cols(); ++j)
    for (Index k = 0; k < series.samples(); ++k)
      if (!std::isfinite(series.values(k, j))) {
        issues.add({record.file.value.string(), 0},
                   "channel '" + series.channels[static_cast<std::size_t>(j)].name + "' is not a number at " +
                       shortest(series.time(k)) + " s",
                   "the filter needs a number at every sample", "set record.skip_missing: true to skip such samples");
        break;
      }
  issues.raise();
}

/// The samples between two times of the file.
TimeSeries cut(const TimeSeries& series, double from, double to) {
  const auto first =
      std::max<Index>(0, static_cast<Index>(std::ceil((from - series.start) * series.sample_rate - 1e-6)));
  const auto last = std::min<Index>(series.samples() - 1,
                                    static_cast<Index>(std::floor((to - series.start) * series.sample_rate + 1e-6)));
  if (last <= first)
    throw InvalidInput("the record has no samples between " + shortest(from) + " s and " + shortest(to) + " s",
                       "the record runs from " + shortest(series.start) + " s to " +
                           shortest(series.time(series.samples() - 1)) + " s",
                       "correct record.start and record.end");
  TimeSeries part{series.sample_rate, series.time(first), series.channels, {}};
  part.values = series.values.middleRows(first, last - first + 1);
  return part;
}

/// Puts back the samples that are missing at a splice, as missing.
void repair_splice(MeasuredRecord& record) {
  const auto splice = find_splice(record.series);
  if (!splice) return;
  record.series = mend(record.series, *splice);
  record.preparation.push_back(to_string(*splice));
}

SourceLocation location_of(const description::Sensor& sensor) {
  return std::visit([](const auto& observed) { return observed.points.location; }, sensor.observed);
}

/// Channels that tell nothing: without a number, or of one value, as a dead sensor gives them.
void check_channels(const TimeSeries& series, const description::Case& given) {
  IssueList issues;
  const std::string part = " (" + std::to_string(series.samples()) + " samples from " + shortest(series.start) +
                           " s to " + shortest(series.time(series.samples() - 1)) + " s)";
  for (Index j = 0; j < series.values.cols(); ++j) {
    const auto& [name, sensor] = given.sensors[static_cast<std::size_t>(j)];
    const std::string channel = "sensors." + name + ": channel '" + sensor.channel.value_or(name) + "' ";
    const Eigen::ArrayXd values = series.values.col(j).array();
    const auto finite = values.isFinite();
    const double infinity = std::numeric_limits<double>::infinity();
    const double lowest = finite.select(values, infinity).minCoeff();
    if (!finite.any())
      issues.add(location_of(sensor), channel + "has no number in the record" + part,
                 "there is no data to estimate from", "remove the sensor or choose another channel");
    else if (lowest == finite.select(values, -infinity).maxCoeff() && !sensor.accept_constant)
      issues.add(location_of(sensor),
                 channel + "has the value " + shortest(lowest) + " " +
                     series.channels[static_cast<std::size_t>(j)].unit + " throughout the record" + part,
                 "a dead sensor would make the filter believe that nothing moves",
                 "remove the sensor or use a part of the record in which it works; if the value is a real measurement, "
                 "set accept_constant: true");
  }
  issues.raise();
}

/// About its rest position, from the release up to the end of the rest.
void take_until_rest(MeasuredRecord& record, const description::FreeResponse& asked, const Rest& rest) {
  TimeSeries& series = record.series;
  const double end = series.time(rest.last), middle = series.time((rest.motion_end + rest.last) / 2);
  series = cut(series, record.free_response->release + asked.delay, end);
  Index last = 0;  // what disturbs the end of the rest does not count
  for (Index k = 0; k < series.samples() && series.time(k) <= middle; ++k)
    if ((series.values.row(k).array().abs() > asked.threshold).any()) last = k;
  record.used = std::min(series.samples(), last + 1 + static_cast<Index>(asked.margin * series.sample_rate));
  record.preparation.push_back("released at " + shortest(record.free_response->release) + " s, at rest from " +
                               shortest(rest.motion_end_time) + " s; values are relative to the rest position");
}

/// About the middle of its last swing, from the release up to the record's end.
void take_without_rest(MeasuredRecord& record, const description::Case& given, const RestGuess& guess) {
  TimeSeries& series = record.series;
  const auto& asked = *given.record->free_response;
  record.free_response->deviation = guess.deviation;
  for (std::size_t j = 0; j < given.sensors.size(); ++j)
    if (asked.rest_std &&
        std::holds_alternative<Observed<ObservedQuantity::displacement>>(given.sensors[j].second.observed))
      record.free_response->deviation[static_cast<Index>(j)] = *asked.rest_std;
  series = cut(series, record.free_response->release + asked.delay, series.time(series.samples() - 1));
  record.used = series.samples();
  record.preparation.push_back("released at " + shortest(record.free_response->release) +
                               " s, still moving at the end; values are relative to the middle of the last swing, and "
                               "the rest position is estimated");
}

void take_free_response(MeasuredRecord& record, const description::Case& given) {
  TimeSeries& series = record.series;
  const auto times = find_free_response(series);
  if (!times)
    throw InvalidInput("the record has no release: it does not start with the structure held",
                       "record.free_response needs a release",
                       "remove record.free_response, or use a record that starts before the release");
  const auto guess = times->rest ? RestGuess{times->rest->position, {}} : guess_rest(series, times->release.sample);
  record.free_response = {times->release.time, {}, guess.position, {}};
  series.values.rowwise() -= guess.position.transpose();
  if (!times->rest) return take_without_rest(record, given, guess);
  record.free_response->rest = times->rest->motion_end_time;
  take_until_rest(record, *given.record->free_response, *times->rest);
}

/// The column of each sensor.
std::vector<WantedChannel> wanted_channels(const description::Case& given) {
  std::vector<WantedChannel> wanted;
  for (const auto& [name, sensor] : given.sensors) {
    const auto quantity = std::visit([](const auto& observed) { return observed.quantity; }, sensor.observed);
    wanted.push_back({.column = sensor.channel.value_or(name),
                      .owner = "sensors." + name,
                      .unit = unit_of(quantity),
                      .rotational_unit = rotational_unit_of(quantity),
                      .unit_key = "sensors." + name + ".unit",
                      .unit_given = sensor.unit.value.empty() ? given.record->unit : sensor.unit});
  }
  return wanted;
}

MeasuredRecord read_prepared(const description::Case& given) {
  const auto& asked = *given.record;
  MeasuredRecord record;
  record.series =
      read_record_file(asked.file.value, wanted_channels(given),
                       {.sample_rate = asked.sample_rate, .dataset = asked.group, .missing = asked.skip_missing});
  for (std::size_t j = 0; j < given.sensors.size(); ++j) record.series.channels[j].name = given.sensors[j].first;
  check_finite(record.series, asked);
  if (asked.repair_splice) repair_splice(record);
  record.series = cut(record.series, asked.start.value_or(record.series.start),
                      asked.end.value_or(record.series.time(record.series.samples() - 1)));
  check_channels(record.series, given);
  record.used = record.series.samples();
  if (asked.free_response) take_free_response(record, given);
  return record;
}

}  // namespace

MeasuredRecord read_measured_record(const description::Case& given) {
  try {
    return read_prepared(given);
  } catch (const InvalidInput& error) {
    IssueList issues;
    issues.add(error, given.record->file.location);
    throw InvalidInput(issues.issues());
  }
}

}  // namespace kalfem
