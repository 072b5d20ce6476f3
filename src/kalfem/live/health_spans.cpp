// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/health_spans.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {
namespace {

constexpr double between_looks = 1.0;     ///< [s]
constexpr std::size_t most_reasons = 50;  ///< of a bin; further ones are left out
constexpr long per_bin = 60;              ///< seconds of a minute, minutes of an hour
constexpr long hours_of_a_day = 24;

/// A bin at the end of others, of which the latest `most` are kept.
void push(auto& bins, const auto& bin, long most) {
  bins.push_back(bin);
  if (std::ssize(bins) > most) bins.pop_front();
}

}  // namespace

void HealthSpans::Bin::see(const std::string& code, const std::string& subject, long more) {
  for (auto& seen : reasons)
    if (seen.code == code && seen.subject == subject) {
      seen.looks += more;
      return;
    }
  if (reasons.size() < most_reasons) reasons.push_back({code, subject, more});
}

void HealthSpans::Bin::add(const Bin& other) {
  looks += other.looks;
  for (std::size_t i = 0; i < conditions.size(); ++i) conditions[i] += other.conditions[i];
  nis += other.nis;
  samples += other.samples;
  channels += other.channels;
  for (const auto& seen : other.reasons) see(seen.code, seen.subject, seen.looks);
}

HealthSpans::HealthSpans(double step) : step_(step), per_look_(std::max(1L, std::lround(between_looks / step))) {}

bool HealthSpans::add(double nis, long channels) {
  if (channels > 0 && std::isfinite(nis)) {
    second_.nis += nis;
    second_.channels += channels;
    ++second_.samples;
  }
  return ++samples_ >= per_look_;
}

void HealthSpans::look(FilterCondition condition, const Verdict& verdict) {
  samples_ = 0;
  second_.looks = 1;
  ++second_.conditions[static_cast<std::size_t>(condition)];
  for (const auto& reason : verdict.reasons()) second_.see(reason.code, reason.subject, 1);
  push(seconds_, second_, per_bin);
  minute_.add(second_);
  second_ = {};
  if (minute_.looks < per_bin) return;
  push(minutes_, minute_, per_bin);
  hour_.add(minute_);
  minute_ = {};
  if (hour_.looks < per_bin * per_bin) return;
  push(hours_, hour_, hours_of_a_day);
  hour_ = {};
}

SpanHealth HealthSpans::of(HealthSpan span) const {
  Bin all;
  const auto& bins = span == HealthSpan::minute ? seconds_ : span == HealthSpan::hour ? minutes_ : hours_;
  for (const auto& bin : bins) all.add(bin);
  if (span != HealthSpan::minute) all.add(minute_);
  if (span == HealthSpan::day) all.add(hour_);
  const auto share = [&](long looks) { return all.looks > 0 ? double(looks) / double(all.looks) : 0.0; };
  constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
  SpanHealth health{.duration = double(all.looks * per_look_) * step_,
                    .mean_nis = all.samples > 0 ? all.nis / double(all.samples) : not_a_number,
                    .expected_nis = all.samples > 0 ? double(all.channels) / double(all.samples) : not_a_number};
  std::ranges::transform(all.conditions, health.shares.begin(), share);
  for (const auto& seen : all.reasons) health.reasons.push_back({seen.code, seen.subject, share(seen.looks)});
  std::ranges::stable_sort(health.reasons, std::ranges::greater(), &ReasonShare::share);
  return health;
}

}  // namespace kalfem
