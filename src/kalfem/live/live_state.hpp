// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// What a filter that is moved by its samples says of itself.
namespace kalfem {

/// Mean and standard deviation of a quantity now.
struct PresentEstimate {
  double mean = 0.0, std = 0.0;
};

/// An unknown now.
struct PresentParameter {
  std::string name, unit;
  double mean = 0.0, std = 0.0;
  double lower = 0.0, upper = 0.0;  ///< interval of 95 %
};

/// The estimate of an earlier sample from all samples so far.
struct SmoothedEstimate {
  double time = 0.0;  ///< of that sample, the first one at 0 [s]
  std::vector<PresentParameter> parameters;
  /// By the names of the filter's own estimates: motions, strains, unknown inputs and the outputs that were asked for.
  std::vector<std::pair<std::string, PresentEstimate>> outputs;

  /// Look-up by name; throw InvalidInput if there is none.
  [[nodiscard]] const PresentParameter& parameter(const std::string& name) const;
  [[nodiscard]] const PresentEstimate& output(const std::string& name) const;
};

/// Why and when a filter stopped.
struct FilterStop {
  double time = 0.0;   ///< [s]
  std::string reason;  ///< in words
};

enum class FilterCondition {
  warming_up,  ///< it has begun, or doubted itself, and gates nothing yet
  consistent,  ///< innovations are as the filter expects
  suspicious,  ///< they are not quite, or a sensor is left out
  unusable,    ///< its numbers cannot be relied on, or it has stopped
  silent       ///< no sensor gives values
};

std::string to_string(FilterCondition condition);

/// A span of the stream that ends now.
enum class HealthSpan { minute, hour, day };

/// A reason of the verdict, and the share of a span for which it stood.
struct ReasonShare {
  std::string code, subject;
  double share = 0.0;
};

/// How a filter has fared over a span, by one look a second.
struct SpanHealth {
  double duration = 0.0;                      ///< of the span as far as the filter has been there [s]
  std::array<double, 5> shares = {};          ///< of the time, by FilterCondition
  double mean_nis = 0.0, expected_nis = 0.0;  ///< not a number where no sensor gave a value
  std::vector<ReasonShare> reasons = {};      ///< the largest share first

  [[nodiscard]] double share(FilterCondition condition) const { return shares[static_cast<std::size_t>(condition)]; }
};

enum class FilterEventKind {
  spike,      ///< a single value is far off
  stuck,      ///< a sensor gives the same value while the structure moves
  saturated,  ///< the same at an end of its range
  dead,       ///< it gives noise alone while the structure moves
  off,        ///< it does not follow the prediction
  missing,    ///< it gives no value
  back,       ///< it is taken again
  inflated,   ///< the filter has widened its deviations
  restarted   ///< the filter has begun anew from its last consistent estimate
};

std::string to_string(FilterEventKind kind);

/// Something that a filter has noticed, and what it did.
struct FilterEvent {
  double time = 0.0;  ///< of the first sample that it concerns [s]
  FilterEventKind kind = FilterEventKind::spike;
  std::string channel = {};  ///< empty: the filter itself
  std::string text = {};     ///< one sentence
};

/// A parameter has changed since the reference windows. Relative to its initial value, or to its prior deviation where
/// that value is 0.
struct ParameterChange {
  std::string parameter;
  double change = 0.0, std = 0.0;
  double lower = 0.0, upper = 0.0;      ///< interval of 95 %
  double since = 0.0;                   ///< start of the window in which the latest step is most likely [s]
  double earliest = 0.0, latest = 0.0;  ///< it lies between these with 95 % [s]
  double statistic = 0.0;               ///< of the latest step when it was found, in deviations
};

enum class AlarmKind {
  raised,   ///< a parameter has changed by the level or more
  changed,  ///< one that had changed has changed again
  ended     ///< its change has fallen below the level less the hysteresis
};

std::string to_string(AlarmKind kind);

struct Alarm {
  std::int64_t number = 0;  ///< from 1 on
  AlarmKind kind = AlarmKind::raised;
  double time = 0.0;  ///< end of the window after which it was given [s]
  ParameterChange what = {};
  std::string text = {};  ///< one sentence
};

/// An unknown over one day, as a mean with its band of 95 %, in its unit.
struct DailyMean {
  double mean = 0.0, std = 0.0, lower = 0.0, upper = 0.0;
};
struct ParameterDay {
  double day = 0.0;  ///< its start [s]
  std::string parameter, unit;
  DailyMean measured;   ///< of the windows' estimates
  DailyMean corrected;  ///< as if the covariates had stayed as in the first window
  long windows = 0;     ///< that were used
};

}  // namespace kalfem
