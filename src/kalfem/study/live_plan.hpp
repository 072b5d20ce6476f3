// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/live/online_steps.hpp"
#include "kalfem/records/channel_calibration.hpp"
#include "kalfem/study/mqtt_options.hpp"

namespace kalfem {

namespace description {
struct Case;
struct Excitation;
}  // namespace description

struct CaseStudy;
struct Study;

/// A channel of the stream, and what its values mean.
struct LiveChannel {
  std::string name;    ///< of the sensor or the input
  std::string column;  ///< in the stream
  std::string unit;    ///< SI
  std::string given;   ///< unit in which it comes, if the case states one
  ChannelCalibration calibration = {};
  bool is_input = false;
  std::optional<std::size_t> covariate = {};  ///< which one, where it is no sensor and no input
};

/// What `kalfem watch` does with a case, with every name looked up and every number in SI.
struct LivePlan {
  FilterProblem problem;
  std::vector<OnlineInput> inputs;
  std::vector<LiveChannel> channels;  ///< sensors, then inputs that come with the stream
  LiveOptions options;
  std::optional<double> start;  ///< time of the first sample [s]; if empty, that of the first one that comes
  double every = 1.0;           ///< between two lines of estimates [s]
  std::filesystem::path state;  ///< folder
  std::optional<int> port;      ///< lines are read from
  std::optional<MqttOptions> mqtt = {};
  std::optional<int> metrics = {};  ///< port that tells metrics and health
  std::optional<int> page = {};     ///< port of the page; it may be the same
};

/// The plan of a case with `live`. Throws InvalidInput without it, and for what only a whole record allows.
LivePlan make_live_plan(const Study& study);

/// The same while the study is made: problems go to `issues` with their place.
void check_live(const CaseStudy& study, IssueList& issues);

/// Whether the samples of a case come with a stream, so that there is no record to run over.
bool is_live(const Study& study);
/// Throws InvalidInput for such a case.
void require_no_stream(const Study& study);

/// Whether the excitation's samples come with the stream: it is a column, and the case is live.
bool comes_live(const description::Case& given, const description::Excitation& excitation);

}  // namespace kalfem
