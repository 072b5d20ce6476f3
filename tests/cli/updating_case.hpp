// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "command.hpp"

/// What the tests of `kalfem update` share.
namespace kalfem::test {

inline std::filesystem::path written(const std::filesystem::path& folder, const std::string& text) {
  std::ofstream(folder / "case.yaml") << text;
  return folder / "case.yaml";
}

/// `text` with the first `from` in it changed to `to`; the text must hold it.
inline std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  if (place == std::string::npos) throw std::logic_error("the case does not hold: " + from);
  return text.replace(place, from.size(), to);
}

/// Runs `update` on the text and returns its summary; the run must end well.
inline nlohmann::json updated(const std::filesystem::path& folder, const std::string& text) {
  const auto outcome = run_command("update " + written(folder, text).string() + " --out " + folder.string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  return outcome.code == 0 ? read_summary(folder) : nlohmann::json{};
}

/// estimate / truth - 1 of a parameter of the summary.
inline double signed_error(const nlohmann::json& parameter) {
  return parameter.at("estimate").get<double>() / parameter.at("true").get<double>() - 1.0;
}

/// |estimate / truth - 1| of a parameter of the summary.
inline double relative_error(const nlohmann::json& parameter) { return std::abs(signed_error(parameter)); }

/// The chain of the examples, shorter and to less precision.
inline std::string short_chain() {
  return changed(changed(read(example("chain/update.yaml")), "duration: 20 s", "duration: 6 s"), "tolerance: 1e-4",
                 "tolerance: 1e-2");
}

}  // namespace kalfem::test
