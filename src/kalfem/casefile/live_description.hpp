// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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

struct Mqtt {
  std::string broker = "localhost";
  std::optional<int> port = {};            ///< empty: 1883, with TLS 8883
  std::string client;                      ///< name by which the broker keeps the session; empty: after the case
  std::vector<std::string> topics = {};    ///< filters of what is read
  std::string publish;                     ///< topic under which estimates go out; empty: they do not
  std::filesystem::path login;             ///< user and password, a line each
  std::filesystem::path authority;         ///< certificates for TLS
  std::filesystem::path certificate, key;  ///< of the client
};

struct Live {
  double sample_rate = 0.0;     ///< [Hz]
  Located<std::string> unit;    ///< of the channels; if empty, SI
  std::optional<double> start;  ///< time of the first sample [s]; if empty, that of the first one that comes
  double horizon = 2.0;         ///< by so much later than another channel may a channel come [s]
  int input_delay = 8;          ///< samples by which the filter stays behind its inputs
  int window = 2000;            ///< samples of the verdict
  int lag = 0;                  ///< samples by which the smoothed estimates stay behind the filter
  bool gated = true;            ///< sensors that lie are left out
  GateOptions gates = {};
  double every = 1.0;                          ///< of the stream, between two lines of estimates [s]
  std::filesystem::path state;                 ///< folder of the state; if empty, beside the case
  std::optional<Located<Alarms>> alarms = {};  ///< on changes of the unknowns
  std::optional<Located<Mqtt>> mqtt = {};
  std::optional<int> metrics = {};  ///< TCP port on the loopback that tells metrics and health
  std::optional<int> page = {};     ///< TCP port on the loopback of the page that shows estimates as they come
  std::optional<int> port;          ///< of TCP, on the loopback; if empty, standard input
};

}  // namespace kalfem::description
