// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record_preparation.hpp"

#include <algorithm>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/records/free_response.hpp"
#include "kalfem/records/record_splice.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// From the release up to the end of the rest, of which the filter sees the motion and the margin.
void take_until_rest(PreparedRecord& prepared, const FreeResponsePart& part, const Rest& rest) {
  Record& record = prepared.record;
  const double end = record.time(rest.last), middle = record.time((rest.motion_end + rest.last) / 2);
  record = cut(std::move(record), prepared.free_response->release + part.delay, end);
  Index last = 0;  // what disturbs the end of the rest does not count
  for (Index k = 0; k < record.samples() && record.time(k) <= middle; ++k)
    if ((record.values.col(k).array().abs() > part.threshold).any()) last = k;
  record.used = std::min(record.samples(), last + 1 + static_cast<Index>(part.margin * record.sample_rate));
  prepared.preparation.push_back("released at " + shortest(prepared.free_response->release) + " s, at rest from " +
                                 shortest(rest.motion_end_time) + " s; values are relative to the rest position");
}

/// From the release up to the record's end.
void take_without_rest(PreparedRecord& prepared, const FreeResponsePart& part, const RestGuess& guess) {
  Record& record = prepared.record;
  auto& deviation = prepared.free_response->deviation = guess.deviation;
  for (std::size_t j = 0; j < part.rest_deviation.size(); ++j)
    deviation[static_cast<Index>(j)] = part.rest_deviation[j].value_or(deviation[static_cast<Index>(j)]);
  const double end = record.end();
  record = cut(std::move(record), prepared.free_response->release + part.delay, end);
  prepared.preparation.push_back("released at " + shortest(prepared.free_response->release) +
                                 " s, still moving at the end; values are relative to the middle of the last swing, "
                                 "and the rest position is estimated");
}

}  // namespace

void repair_splice(PreparedRecord& prepared) {
  const auto splice = find_splice(prepared.record);
  if (!splice) return;
  prepared.record = mend(prepared.record, *splice);
  prepared.preparation.push_back(to_string(*splice));
}

void take_free_response(PreparedRecord& prepared, const FreeResponsePart& part) {
  Record& record = prepared.record;
  const auto times = find_free_response(record);
  if (!times)
    throw InvalidInput("the record has no release: it does not start with the structure held",
                       "a free response begins with a release",
                       "take the whole record, or one that starts before the release");
  const auto guess = times->rest ? RestGuess{times->rest->position, {}} : guess_rest(record, times->release.sample);
  prepared.free_response = {times->release.time, {}, guess.position, {}};
  record.values.colwise() -= guess.position;
  if (!times->rest) return take_without_rest(prepared, part, guess);
  prepared.free_response->rest = times->rest->motion_end_time;
  take_until_rest(prepared, part, *times->rest);
}

}  // namespace kalfem
