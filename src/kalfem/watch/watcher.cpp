// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/watcher.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/unit_labels.hpp"
#include "kalfem/watch/change_lines.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_told = 100;  ///< names that are told once each

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json numbers(const PresentParameter& now) {
  return {{"estimate", number(now.mean)}, {"std", number(now.std)}, {"unit", now.unit}};
}

Json told_of(const SpanHealth& health) {
  Json told{{"seconds", health.duration}, {"shares", Json::object()}};
  using enum FilterCondition;
  for (const auto condition : {warming_up, consistent, suspicious, unusable, silent})
    if (health.share(condition) > 0.0) told["shares"][to_string(condition)] = health.share(condition);
  told["nis"] = number(health.mean_nis);
  told["expected_nis"] = number(health.expected_nis);
  auto& reasons = told["reasons"] = Json::array();
  for (const auto& [code, subject, share] : health.reasons)
    reasons.push_back({{"code", code}, {"subject", subject}, {"share", share}});
  return told;
}

Json numbers(const PresentEstimate& now) { return {{"mean", number(now.mean)}, {"std", number(now.std)}}; }

/// From the unit of the stream to SI.
double factor_of(const StreamBlock& block, const LiveChannel& channel) {
  const std::string unit = channel.given.empty() ? understood_unit(block.unit) : channel.given;
  return unit.empty() ? 1.0 : parse_unit_as(unit, channel.unit).factor;
}

}  // namespace

Watcher::Watcher(LivePlan plan, Say say, std::function<void(const std::string&)> complain)
    : plan_(std::move(plan)),
      say_(std::move(say)),
      complain_(std::move(complain)),
      queue_(plan_.problem, plan_.inputs, plan_.options),
      clock_(1.0 / loop().step(), plan_.channels.size(), plan_.options.horizon, *plan_.options.longest_gap),
      every_(std::max(1L, std::lround(plan_.every / loop().step()))) {
  if (plan_.start) begin_at(*plan_.start);
  queue_.steps().after_each_sample([this] { after_sample(); });
}

void Watcher::take(std::string_view line) {
  ++lines_;
  try {
    std::vector<std::pair<const StreamBlock*, const LiveChannel*>> known;
    const auto blocks = reader_.read(line);
    for (const auto& block : blocks)
      if (const auto* channel = channel_of(block); channel && !block.values.empty())
        known.emplace_back(&block, channel);
    // Covariates first: the other channels move the filter, which then asks for them.
    for (const auto& [block, channel] : known)
      if (channel->covariate) take_covariate(*block, *channel);
    for (const auto& [block, channel] : known)
      if (!channel->covariate) take_block(*block, *channel);
  } catch (const InvalidInput& error) {
    ++bad_lines_;
    complain_("line " + std::to_string(lines_) + ": " + error.what());
  }
}

/// The channel of a column; null where the case has none, which is told once.
const LiveChannel* Watcher::channel_of(const StreamBlock& block) {
  const auto found = std::ranges::find(plan_.channels, block.column, &LiveChannel::column);
  if (found != plan_.channels.end()) return &*found;
  if (unknown_columns_.size() < most_told && unknown_columns_.insert(block.column).second) {
    std::vector<std::string> known;
    for (const auto& channel : plan_.channels) known.push_back(channel.column);
    complain_("line " + std::to_string(lines_) + ": the case has no channel '" + block.column + "'" +
              did_you_mean(block.column, known) + "; it is left out from now on");
  }
  return nullptr;
}

/// From the unit of the stream to SI. Nothing where that is no unit of the channel, which is told once.
std::optional<double> Watcher::known_factor(const StreamBlock& block, const LiveChannel& channel) try {
  return factor_of(block, channel);
} catch (const InvalidInput& error) {
  ++bad_lines_;
  if (wrong_units_.size() < most_told && wrong_units_.insert(block.column + " [" + block.unit + "]").second)
    complain_("line " + std::to_string(lines_) + ": '" + block.column + "' comes in '" + block.unit +
              "': " + error.what() + "; what comes in it is left out");
  return {};
}

void Watcher::begin_at(double time) {
  origin_ = time;
  if (auto* monitor = queue_.steps().monitor()) monitor->set_origin(time);
  for (const auto& early : std::exchange(early_, {}))
    queue_.push_covariate(early.covariate, early.time - time, early.value);
}

/// Its values may be any time apart. They wait for the first sample of a sensor or an input, which times count from.
void Watcher::take_covariate(const StreamBlock& block, const LiveChannel& channel) {
  constexpr std::size_t most_waiting = 100'000;
  const double interval = block.interval > 0.0 ? block.interval : loop().step();
  for (std::size_t i = 0; i < block.values.size(); ++i) {
    const double time = block.time + static_cast<double>(i) * interval;
    if (origin_)
      queue_.push_covariate(*channel.covariate, time - *origin_, block.values[i]);
    else if (early_.size() < most_waiting)
      early_.push_back({*channel.covariate, time, block.values[i]});
  }
}

void Watcher::take_block(const StreamBlock& block, const LiveChannel& channel) {
  const double rate = 1.0 / loop().step();
  if (block.interval > 0.0 && std::abs(block.interval * rate - 1.0) > 1e-3 && block.values.size() > 1)
    throw InvalidInput("the values of '" + channel.column + "' are " + shortest(block.interval) + " s apart",
                       "the case states a sampling rate of " + shortest(rate) + " Hz",
                       "correct live.sample_rate, or resample the channel");
  const auto factor = known_factor(block, channel);
  if (!factor) return;
  const auto& [gain, offset, delay, drift] = channel.calibration;  // a live case has no drift
  const double begin = block.time - delay;
  if (!origin_) begin_at(begin);
  const auto time = placed(begin, std::ssize(block.values), channel);
  if (!time) return;
  VectorXd values(std::ssize(block.values));
  for (Index i = 0; i < values.size(); ++i)
    values[i] = (block.values[static_cast<std::size_t>(i)] * *factor - offset) / gain;
  if (!channel.is_input) {
    queue_.push(channel.name, *time, values);
    return;
  }
  for (Index i = 0; i < values.size(); ++i)  // a missing sample of an input is left out: the last value is held
    if (std::isfinite(values[i]))
      queue_.push(channel.name, *time + static_cast<double>(i) / rate, values.segment(i, 1));
}

/// Time of the filter of a block that begins at a time of the stream; nothing where it cannot be used.
std::optional<double> Watcher::placed(double time, std::ptrdiff_t count, const LiveChannel& channel) {
  constexpr std::size_t most_waiting = 1000;
  const auto number = static_cast<std::size_t>(&channel - plan_.channels.data());
  const auto found = clock_.place(number, time - *origin_, count, queue_.newest());
  if (found.jump != 0.0) begin_at(*origin_ + found.jump);
  if (!found.words.empty()) {
    complain_("line " + std::to_string(lines_) + ": '" + channel.column + "': " + found.words);
    if (clock_events_.size() < most_waiting) clock_events_.push_back({loop().time(), channel.name, found.words});
  }
  if (!found.time) ++bad_lines_;
  return found.time;
}

void Watcher::after_sample() {
  tell_changes();
  if (loop().sample() % every_ == 0) tell();
}

/// Alarms and days of the trend that are new.
void Watcher::tell_changes() {
  const auto* changes = monitor();
  if (!changes) return;
  const auto fresh = std::min<std::int64_t>(changes->alarms_given() - told_alarms_, std::ssize(changes->alarms()));
  for (auto alarm = changes->alarms().end() - fresh; alarm != changes->alarms().end(); ++alarm)
    say_(MessageKind::alarm, alarm_line(*alarm, *changes, origin()));
  told_alarms_ = changes->alarms_given();
  if (changes->days().empty() || !(changes->days().back().start > told_day_)) return;
  told_day_ = changes->days().back().start;
  say_(MessageKind::trend, trend_line(changes->days().back(), *changes));
}

void Watcher::recall(const Say& say) const {
  const auto* changes = monitor();
  if (!changes) return;
  for (const auto& alarm : changes->alarms()) say(MessageKind::alarm, alarm_line(alarm, *changes, origin()));
  for (const auto& day : changes->days()) say(MessageKind::trend, trend_line(day, *changes));
}

void Watcher::tell() {
  const auto& log = loop().log();
  Json line;
  line["t"] = number(time());
  line["condition"] = to_string(loop().condition());
  line["verdict"] = to_string(loop().verdict().state());
  auto& reasons = line["reasons"] = Json::array();
  for (const auto& reason : loop().verdict().reasons())
    reasons.push_back({{"code", reason.code}, {"subject", reason.subject}, {"text", reason.text}});
  line["health"] = {{"minute", told_of(loop().health(HealthSpan::minute))},
                    {"hour", told_of(loop().health(HealthSpan::hour))},
                    {"day", told_of(loop().health(HealthSpan::day))}};
  auto& parameters = line["parameters"] = Json::object();
  for (std::size_t i = 0; i < loop().unknowns(); ++i) {
    const auto now = loop().parameter(i);
    parameters[now.name] = numbers(now);
  }
  auto& outputs = line["outputs"] = Json::object();
  const auto names = loop().observed();
  const auto observed = loop().observe_all();
  for (std::size_t i = 0; i < names.size(); ++i) outputs[names[i]] = numbers(observed[i]);
  if (const auto earlier = loop().smoothed()) {
    auto& smoothed = line["smoothed"] = {
        {"t", number(origin() + earlier->time)}, {"parameters", Json::object()}, {"outputs", Json::object()}};
    for (const auto& each : earlier->parameters) smoothed["parameters"][each.name] = numbers(each);
    for (const auto& [name, each] : earlier->outputs) smoothed["outputs"][name] = numbers(each);
  }
  auto& events = line["events"] = Json::array();
  const auto fresh = std::min<std::int64_t>(log.total() - told_events_, std::ssize(log.events()));
  for (auto event = log.events().end() - fresh; event != log.events().end(); ++event)
    events.push_back({{"t", number(origin_.value_or(0.0) + event->time)},
                      {"kind", to_string(event->kind)},
                      {"channel", event->channel},
                      {"text", event->text}});
  told_events_ = log.total();
  for (const auto& event : std::exchange(clock_events_, {}))
    events.push_back(
        {{"t", number(origin() + event.time)}, {"kind", "clock"}, {"channel", event.channel}, {"text", event.text}});
  if (const auto* changes = monitor()) {
    line["changes"] = changes_now(*changes, origin());
    line["reference"] = {{"windows", std::min<long>(changes->windows(), changes->options().reference)},
                         {"of", changes->options().reference},
                         {"left_out", changes->windows_left_out()}};
  }
  line["samples"] = queue_.samples();
  line["late"] = queue_.dropped();
  line["bad_lines"] = bad_lines_;
  if (const auto& failure = loop().failure()) line["failure"] = failure->reason;
  say_(MessageKind::estimates, line.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void Watcher::transfer(auto& self, auto& archive) {
  archive(self.origin_);
  StreamClock::transfer(self.clock_, archive);
  archive.each(self.clock_events_, [&](auto& event) {
    archive(event.time);
    archive(event.channel);
    archive(event.text);
  });
  archive(self.lines_);
  archive(self.logged_);
  archive(self.bad_lines_);
  archive(self.told_events_);
  archive(self.told_alarms_);
  archive(self.told_day_);
  archive.each(self.early_, [&](auto& early) {
    archive(early.covariate);
    archive(early.time);
    archive(early.value);
  });
}

void Watcher::keep(ArchiveWriter& archive) const {
  reader_.keep(archive);
  queue_.keep(archive);
  transfer(*this, archive);
}

void Watcher::take_up(ArchiveReader& archive) {
  reader_.take_up(archive);
  queue_.take_up(archive);
  transfer(*this, archive);
}

}  // namespace kalfem
