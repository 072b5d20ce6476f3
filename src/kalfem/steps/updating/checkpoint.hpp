// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/gauss_newton.hpp"

namespace kalfem {

/// Name of the file that UpdatingCheckpoint keeps in the folder of the results. It is removed once the results are
/// complete, so a run that was killed after its last iteration still finds it.
inline constexpr const char* checkpoint_name = "update.checkpoint.json";

/// Keeps the state of an updating in a small file after each iteration. A run that was killed continues from there.
class UpdatingCheckpoint {
public:
  /// An empty `folder` keeps nothing. `fingerprint` identifies everything on which the updating depends.
  UpdatingCheckpoint(const std::filesystem::path& folder, std::string fingerprint, Eigen::Index parameters);

  struct Content {
    GaussNewtonState state;
    std::vector<UpdatingStep> trace;
  };
  /// Returns nothing if there is no file, or if it is damaged or belongs to another case.
  [[nodiscard]] std::optional<Content> read() const;
  void write(const Content& content) const;

private:
  std::filesystem::path file_;
  std::string fingerprint_;
  Eigen::Index parameters_;
};

/// Fingerprint of the case with all its defaults, the version of the program, and a value at the start: of the residual
/// or of the likelihood. This value stands for the contents of the files that the case names.
std::string fingerprint_of(const Study& study, double first_value);

}  // namespace kalfem
