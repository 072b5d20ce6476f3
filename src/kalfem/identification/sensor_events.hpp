// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// What is wrong with a record, or missing in it.
enum class EventKind {
  missing,    ///< single samples without a number
  dropout,    ///< a stretch without a number
  dead,       ///< constant, or noise only, until the end of the record
  stuck,      ///< constant for a while
  saturated,  ///< held at the channel's extremes while the structure moves beyond them
  outliers,   ///< single samples far from their prediction
  jump,       ///< an unknown of the model changes at once, see find_parameter_jump()
  drift       ///< an unknown of the model changes slowly
};

std::string to_string(EventKind kind);

/// Part of a channel that the estimates do not rest on, or only partly.
struct SensorEvent {
  EventKind kind = EventKind::missing;
  std::string channel = {};                ///< empty: every channel; of a change of the model the unknown
  double from = 0.0, to = 0.0;             ///< first and last sample of it [s]
  Eigen::Index count = 0;                  ///< samples
  std::string text = {};                   ///< one sentence
  std::vector<Eigen::Index> samples = {};  ///< of the channel; empty where they hold no number anyway

  /// Whether it is the model that changes: every sensor measures what it should.
  [[nodiscard]] bool is_change() const { return kind == EventKind::jump || kind == EventKind::drift; }

  /// Whether the sensor does not measure what it should. The filter allows for missing samples exactly.
  [[nodiscard]] bool is_fault() const {
    return kind != EventKind::missing && kind != EventKind::dropout && !is_change();
  }
};

/// Samples without a number: stretches of all channels or of one that are far longer than its other gaps ("dropout"),
/// and the rest, one event a channel. A channel that is slower than the record lacks what its own rate would give.
std::vector<SensorEvent> missing_samples(const Record& record);

/// Stretches of at least twenty samples, and far longer than others of the channel, in which every sample has the same
/// value although another channel moves: candidates for a sensor that is dead or stuck. One that holds to the last
/// sample of the channel ends with the record.
std::vector<HeldOutSamples> constant_stretches(const Record& record);

/// Whether the prediction of the samples that were held out contradicts them: it moves by more than two deviations, or
/// lies as far away.
bool contradicted(const EstimationResult& result, const HeldOutSamples& stretch);

/// Channels that follow their prediction up to a time and then until the end of the record show noise that has nothing
/// to do with it and is less than half as large. The time is the most likely one of such a change.
std::vector<HeldOutSamples> silent_stretches(const Record& measured, const EstimationResult& result);

/// Runs of three and more samples at the extremes of a channel, where these are at least three and the prediction lies
/// beyond them.
std::vector<HeldOutSamples> saturated_samples(const Record& measured, const EstimationResult& result);

/// Whether a few samples, at least one of them by more than ten deviations, lie far from predictions that otherwise
/// hold, from sample `first` on. A model that is wrong is off for many samples in succession, which is no such case.
bool shows_outliers(const EstimationResult& result, Eigen::Index first);

/// Events of the samples that a run set aside. `measured`: the channels of the run as recorded.
std::vector<SensorEvent> events_of(const Record& measured, const EstimationResult& result,
                                   const std::vector<HeldOutSamples>& held_out, double limit);

/// The record without the samples of these events.
Record without(Record record, const std::vector<SensorEvent>& events);

}  // namespace kalfem
