// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "kalfem/casefile/finite_element_description.hpp"
#include "kalfem/records/channel_preparation.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/ground_motion.hpp"

/// Signals, and connectors whose laws read them, as a case states them, see description.hpp.
namespace kalfem::description {

struct ExpressionState {
  std::string rate, unit = "-";
};

struct RandomSignal {
  Value rms;
  std::array<double, 2> band{};
  std::optional<double> duration;
  double fade_in = 0.5;
  std::uint64_t seed = 1;
};
struct Sine {
  Value amplitude;
  double frequency = 1.0, phase = 0.0, fade_in = 0.0;
};
struct SweptSine {
  Value amplitude;
  double from = 1.0, to = 30.0;
  std::optional<double> duration;
  Sweep kind = Sweep::linear;
  double fade_in = 0.0;
};
struct Impulse {
  Value amplitude;
  double start = 0.0, duration = 0.01;
  PulseShape shape = PulseShape::half_sine;
};
struct Road {
  char road_class = 'C';
  double speed = 20.0;
  std::array<double, 2> band{0.011, 2.83};
  std::optional<double> duration;
  double fade_in = 0.5;
  std::uint64_t seed = 1;
};
/// A channel of an input's file that measured the same as a sensor of the record: it tells how late the file is.
struct Alignment {
  Name channel, sensor;
};
struct FileSignal {
  std::filesystem::path file;
  Name channel;
  std::optional<double> sample_rate;
  Located<std::string> unit;  ///< if empty, the one in the column's title, otherwise SI
  double delay = 0.0;         ///< its clock is late by this [s]
  double clock_drift = 0.0;   ///< of its clock [s/s], see ClockLag
  std::optional<Alignment> align;
  double bridge_gaps = 0.0;  ///< longest gap that is filled [s]; 0: none may be
  ChannelPreparation prepare;
};
struct ChannelSignal {
  Name channel;
  std::optional<std::filesystem::path> file;  ///< if empty, that of the record
  std::optional<double> sample_rate;
  Located<std::string> unit;  ///< if empty, the one in the column's title, otherwise SI
  double bridge_gaps = 0.0;   ///< longest gap that is filled [s]; 0: none may be
  ChannelPreparation prepare;
};
struct Delayed {
  Name input;
  double delay = 0.0;
};
struct Trailing {
  Name input;
  double wheelbase = 0.0, speed = 0.0;
};
struct Constant {
  Value value;
};
struct Clock {};  ///< the time of the record itself
using Signal = std::variant<RandomSignal, Sine, SweptSine, Impulse, Road, FileSignal, Delayed, Trailing, Constant,
                            ChannelSignal, Clock>;

/// A signal that a law reads: a channel, a formula, the time, or an input (as a delay by nothing).
struct LawSignal {
  Signal signal;
  double scale = 1.0;
};
struct Connector {
  Name from, to;
  Located<std::string> law;
  Named<Value> parameters;
  std::string force;
  Named<ExpressionState> states;
  Named<std::string> let;
  Named<Located<LawSignal>> signals;
};

}  // namespace kalfem::description
