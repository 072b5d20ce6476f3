// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <iostream>
#include <optional>
#include <random>

#include <fmt/format.h>

#include "calibration_runs.hpp"
#include "kalfem/api/structure_description.hpp"

// Mistakes of the size that engineers make, between a random structure and the model of it: one, or two at once.

namespace kalfem::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A mistake as it stands, and the reasons that name it.
struct Planted {
  std::string text;
  std::vector<std::string> codes;
  std::string subject;

  [[nodiscard]] bool is_named_by(const Reason& reason) const {
    const bool fits = std::ranges::find(codes, reason.code) != codes.end();
    return (fits && reason.subject.find(subject) != std::string::npos) ||
           (reason.code == "fixed_parameter" && reason.subject == subject);
  }
  /// Its reason, or one that says it is as likely.
  [[nodiscard]] bool is_told_by(const Reason& reason) const {
    return is_named_by(reason) || reason.text.find("'" + subject + "'") != std::string::npos;
  }
};

/// Puts mistakes between a record and its model, one of each subject.
class Planter {
public:
  Planter(RandomRecord given, std::uint64_t seed) : given_(std::move(given)), generator_(seed + 333) {}

  /// Draws until a mistake fits the structure.
  Planted plant() {
    while (true) {
      const int kind = static_cast<int>(uniform() * 8.0);
      auto planted = kind < 4 ? of_sensor(kind) : kind < 5 ? swapped() : kind < 6 ? of_excitation() : of_parameter();
      if (!planted || std::ranges::find(subjects_, planted->subject) != subjects_.end()) continue;
      subjects_.push_back(planted->subject);
      return *planted;
    }
  }

  [[nodiscard]] const RandomRecord& record() const { return given_; }

private:
  double uniform() { return std::uniform_real_distribution<double>(0.0, 1.0)(generator_); }
  std::size_t one_of(std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(uniform() * static_cast<double>(count)));
  }
  /// Off by 10 to 50 %.
  double wrong_factor() {
    const double size = 0.1 * std::pow(5.0, uniform());
    return uniform() < 0.5 ? 1.0 - size : 1.0 + size;
  }

  std::optional<Planted> of_sensor(int kind) {
    const Index row = static_cast<Index>(one_of(given_.options.sensors.size()));
    const std::string name = given_.options.sensors[static_cast<std::size_t>(row)].name;
    if (std::ranges::find(subjects_, name) != subjects_.end()) return std::nullopt;
    auto channel = given_.record.values.row(row);
    if (kind == 0) {
      channel *= -1.0;
      return Planted{name + " turned", {"sensor_sign"}, name};
    }
    if (kind == 1) {
      const double unit = std::array{1.0 / 9.80665, 1000.0, 0.001}[one_of(3)];
      channel *= unit;
      return Planted{
          fmt::format("{} in a unit {:.3g} times as large", name, unit), {"sensor_unit", "sensor_gain"}, name};
    }
    if (kind == 2) {
      const double gain = wrong_factor();
      channel *= gain;
      return Planted{fmt::format("{} times {:.3g}", name, gain), {"sensor_gain", "sensor_unit"}, name};
    }
    const Index late = 1 + static_cast<Index>(one_of(8));
    const Eigen::RowVectorXd recorded = channel;
    for (Index k = 0; k < recorded.size(); ++k) channel[k] = recorded[std::max<Index>(0, k - late)];
    return Planted{fmt::format("{} late by {} samples", name, late), {"sensor_delay"}, name};
  }

  std::optional<Planted> swapped() {
    const auto& sensors = given_.options.sensors;
    const std::size_t a = one_of(sensors.size()), b = one_of(sensors.size());
    const auto& channels = given_.record.channels;
    if (a >= b || channels[a].unit != channels[b].unit) return std::nullopt;
    given_.record.values.row(static_cast<Index>(a)).swap(given_.record.values.row(static_cast<Index>(b)));
    return Planted{sensors[a].name + " and " + sensors[b].name + " exchanged", {"sensors_swapped"}, sensors[a].name};
  }

  std::optional<Planted> of_excitation() {
    const auto& samples = given_.structure.description().samples;
    auto chosen = samples.begin();
    std::advance(chosen, one_of(samples.size()));
    const std::string name = chosen->first;
    if (std::ranges::find(subjects_, name) != subjects_.end()) return std::nullopt;
    Samples given = chosen->second;
    const double gain = uniform() < 0.5 ? -1.0 : wrong_factor();
    given.values *= gain;
    given_.structure.drive(name, given);
    return Planted{
        fmt::format("{} times {:.3g}", name, gain), {"excitation_sign", "excitation_gain", "excitation_unit"}, name};
  }

  /// A number of the model that is not estimated, but exponents and shapes.
  std::optional<Planted> of_parameter() {
    std::vector<std::string> fixed;
    for (const auto& name : given_.structure.parameters())
      if (std::ranges::find(given_.options.unknowns, name, &UnknownDescription::name) ==
              given_.options.unknowns.end() &&
          (name.ends_with(".mass") || name.ends_with(".stiffness") || name.ends_with(".density") ||
           name.ends_with(".youngs_modulus")) &&
          given_.structure.value(name) != 0.0)
        fixed.push_back(name);
    if (fixed.empty()) return std::nullopt;
    const std::string name = fixed[one_of(fixed.size())];
    if (std::ranges::find(subjects_, name) != subjects_.end()) return std::nullopt;
    const double factor = wrong_factor();
    given_.structure = given_.structure.at({{name, factor * given_.structure.value(name)}});
    return Planted{fmt::format("{} times {:.3g}", name, factor), {"fixed_parameter"}, name};
  }

  RandomRecord given_;
  std::mt19937_64 generator_;
  std::vector<std::string> subjects_;
};

struct Tally {
  int runs = 0, visible = 0, silent = 0, first = 0, told = 0, all = 0, false_second = 0;
};

void look(int seed, int mistakes, Tally& tally) {
  Planter planter(random_record(static_cast<std::uint64_t>(seed)), static_cast<std::uint64_t>(seed));
  std::vector<Planted> planted;
  for (int i = 0; i < mistakes; ++i) planted.push_back(planter.plant());
  const auto& given = planter.record();
  const auto found = estimate(given.structure, given.record, given.options);
  double worst = 0.0;
  for (std::size_t i = 0; i < given.truth.size(); ++i) {
    const auto& each = found.parameters[i];
    worst = std::max(worst,
                     std::abs(each.mean - given.truth[i]) * 3.92 / (each.interval_95.upper - each.interval_95.lower));
  }
  auto reasons = found.verdict.reasons();
  const bool consistent = found.verdict.state() == VerdictState::consistent;
  if (reasons.size() > 3) reasons.resize(3);
  const auto named = std::ranges::count_if(planted, [&](const auto& each) {
    return std::ranges::any_of(reasons, [&](const auto& reason) { return each.is_named_by(reason); });
  });
  const auto of_first = [&](auto is) {
    return !reasons.empty() &&
           std::ranges::any_of(planted, [&](const auto& each) { return (each.*is)(reasons.front()); });
  };
  const bool first = of_first(&Planted::is_named_by), told = of_first(&Planted::is_told_by);
  const bool second = reasons.size() > 1 && std::isinf(reasons[1].weight);
  ++tally.runs;
  tally.visible += consistent ? 0 : 1;
  tally.silent += consistent && worst > 4.0 ? 1 : 0;
  tally.first += first ? 1 : 0;
  tally.told += told ? 1 : 0;
  tally.all += named == mistakes ? 1 : 0;
  tally.false_second += mistakes == 1 && second ? 1 : 0;
  const bool good = named == mistakes && first && !(mistakes == 1 && second);
  if (good) return;
  std::string text;
  for (const auto& each : planted) text += (text.empty() ? "" : " and ") + each.text;
  std::cout << fmt::format("{} {}: {}; {}, worst {:.3g}\n", seed, given.kind, text, to_string(found.verdict.state()),
                           worst);
  for (const auto& reason : reasons)
    std::cout << "    " << reason.code << " " << reason.subject << ": " << reason.text << "\n";
  if (found.diagnosis) {
    const auto& tested = found.diagnosis->tested;
    for (std::size_t i = 0; i < std::min<std::size_t>(tested.size(), 6); ++i)
      std::cout << fmt::format("        {} {}: {:.4g}, gain {:.5g}, NIS {:.3g}\n", tested[i].code, tested[i].subject,
                               tested[i].value, tested[i].gain, tested[i].mean_nis);
  }
  std::cout << std::flush;
}

Tally tally_of(int mistakes) {
  const int first = number("KALFEM_FIRST", 1), count = number("KALFEM_COUNT", 200);
  Tally tally;
  for (int seed = first; seed < first + count; ++seed) look(seed, mistakes, tally);
  std::cout << fmt::format(
                   "{} runs, {} not consistent, {} consistent and off by more than 4 deviations; of those that are not "
                   "consistent the first reason names a mistake in {}, says that it is as likely in {}, all mistakes "
                   "are among the first three "
                   "reasons in {}; a second cause of a single mistake in {}\n",
                   tally.runs, tally.visible, tally.silent, tally.first, tally.told, tally.all, tally.false_second)
            << std::flush;
  return tally;
}

// A sign, a unit, a gain, a delay, two exchanged sensors, an excitation, a mass or a stiffness.
TEST(PlantedMistakes, AreNamedFirst) {
  const auto tally = tally_of(1);
  EXPECT_EQ(tally.silent, 0);
  EXPECT_GE(tally.told, 0.9 * tally.visible);
}

TEST(PlantedMistakes, TwoAtOnceAreBothNamed) {
  const auto tally = tally_of(2);
  EXPECT_EQ(tally.silent, 0);
  EXPECT_GE(tally.all, 0.7 * tally.visible);
}

}  // namespace
}  // namespace kalfem::calibration
