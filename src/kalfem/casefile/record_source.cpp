#include "kalfem/casefile/record_source.hpp"

#include <cmath>

#include "kalfem/casefile/record_file.hpp"
#include "kalfem/formats/free_response.hpp"
#include "kalfem/formats/record_splice.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

void check_finite(const TimeSeries& series, const description::Record& record) {
  if (record.skip_missing || record.repair_splice || series.values.allFinite()) return;
  IssueList issues;
  for (Index j = 0; j < series.values.cols(); ++j)
    for (Index k = 0; k < series.samples(); ++k)
      if (!std::isfinite(series.values(k, j))) {
        issues.add({record.file.string(), 0},
                   "channel '" + series.channels[static_cast<std::size_t>(j)].name + "' is not a number at " +
                       shortest(series.time(k)) + " s",
                   "the filter needs numbers", "set record.skip_missing: true to pass over such samples");
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
    throw InvalidInput(
        "the record has no samples between " + shortest(from) + " s and " + shortest(to) + " s",
        "it runs from " + shortest(series.start) + " s to " + shortest(series.time(series.samples() - 1)) + " s",
        "mend record.start and record.end");
  TimeSeries part{series.sample_rate, series.time(first), series.channels, {}};
  part.values = series.values.middleRows(first, last - first + 1);
  return part;
}

/// Puts back the samples that are missing at a splice, as missing.
void repair_splice(MeasuredRecord& record) {
  const auto splice = find_splice(record.series);
  if (!splice) return;
  record.series = mend(record.series, *splice);
  record.preparation.push_back(describe(*splice));
}

/// From the release on, about the rest position, up to the end of the rest.
void take_free_response(MeasuredRecord& record, const description::FreeResponse& asked) {
  TimeSeries& series = record.series;
  const auto release = find_release(series);
  if (!release)
    throw InvalidInput("the record shows no release: it does not begin with a hold that ends",
                       "record.free_response asks for "
                       "one",
                       "take record.free_response out, or give a record that begins before the release");
  const auto rest = find_rest(series, release->sample);
  if (!rest)
    throw InvalidInput("the structure does not come to rest in the record",
                       "record.free_response takes it about its rest "
                       "position",
                       "give a longer record, or take record.free_response out");
  series.values.rowwise() -= rest->position.transpose();
  const double end = series.time(rest->last);
  series = cut(series, release->time + asked.delay, end);
  Index last = 0;
  for (Index k = 0; k < series.samples(); ++k)
    if ((series.values.row(k).array().abs() > asked.threshold).any()) last = k;
  record.used = std::min(series.samples(), last + 1 + static_cast<Index>(asked.margin * series.sample_rate));
  record.preparation.push_back("released at " + shortest(release->time) + " s, at rest from " +
                               shortest(rest->motion_end_time) + " s; taken about the rest position");
}

}  // namespace

MeasuredRecord read_measured_record(const description::Case& given) {
  const auto& asked = *given.record;
  std::vector<std::string> channels;
  for (const auto& [name, sensor] : given.sensors) channels.push_back(sensor.channel.value_or(name));
  MeasuredRecord record;
  record.series = read_record_file(asked.file, channels, asked.sample_rate, asked.group);
  if (!asked.unit.empty()) record.series.values *= parse_unit(asked.unit).factor;
  for (std::size_t j = 0; j < channels.size(); ++j) record.series.channels[j].name = given.sensors[j].first;
  check_finite(record.series, asked);
  if (asked.repair_splice) repair_splice(record);
  record.series = cut(record.series, asked.start.value_or(record.series.start),
                      asked.end.value_or(record.series.time(record.series.samples() - 1)));
  record.used = record.series.samples();
  if (asked.free_response) take_free_response(record, *asked.free_response);
  return record;
}

}  // namespace kalfem
