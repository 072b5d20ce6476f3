// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kalfem/steps/simulation/outcome.hpp"

namespace kalfem {

/// Name of the file that SimulationCheckpoint keeps in the folder of the results. It is removed once the run has ended.
inline constexpr const char* simulation_name = "simulation.checkpoint";

/// A hash of all that a simulation depends on: the version, the case with all its defaults but for `estimate`, the
/// matrices of the structure, the names of the reported quantities, and the excitation at every sample, which comes
/// from files too.
std::string simulation_fingerprint(const Study& study);

/// Keeps the finished simulation of a run in a file, bit for bit. A run that was killed later takes it from there and
/// ends with the same results.
class SimulationCheckpoint {
public:
  /// An empty `folder` keeps nothing.
  SimulationCheckpoint(const std::filesystem::path& folder, const Study& study);

  /// Nothing if there is no file, or if it is damaged, belongs to another case, or to one whose files have changed.
  [[nodiscard]] std::optional<SimulationOutcome> read() const;
  /// Does nothing for a simulation that takes less time than it is worth to keep it. Throws as write_file_atomically().
  void write(const SimulationOutcome& simulation) const;

private:
  std::filesystem::path file_;
  std::string fingerprint_;
};

}  // namespace kalfem
