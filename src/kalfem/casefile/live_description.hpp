// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/live/online_options.hpp"

/// A stream in the place of a record as the case file states it, see description.hpp.
namespace kalfem::description {

/// A channel of the stream that parameters depend on.
struct Covariate {
  Name channel;          ///< in the stream
  double effect = 0.01;  ///< prior deviation: relative change of a parameter per unit of the channel
};

struct Alarms {
  ChangeOptions options = {};  ///< without its covariates
  Named<Located<Covariate>> covariates = {};
};

struct Live {
  double sample_rate = 0.0;     ///< [Hz]
  Located<std::string> unit;    ///< of the channels; if empty, SI
  std::optional<double> start;  ///< time of the first sample [s]; if empty, that of the first one that comes
  double horizon = 2.0;         ///< by so much later than another channel may a channel come [s]
  int input_delay = 8;          ///< samples by which the filter stays behind its inputs
  int window = 2000;            ///< samples of the verdict
  bool gated = true;            ///< sensors that lie are left out
  GateOptions gates = {};
  double every = 1.0;                          ///< of the stream, between two lines of estimates [s]
  std::filesystem::path state;                 ///< folder of the state; if empty, beside the case
  std::optional<Located<Alarms>> alarms = {};  ///< on changes of the unknowns
  std::optional<int> port;                     ///< of TCP, on the loopback; if empty, standard input
};

}  // namespace kalfem::description
