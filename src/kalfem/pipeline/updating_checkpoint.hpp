#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/updating/gauss_newton.hpp"

namespace kalfem {

/// Name of the file that UpdatingCheckpoint keeps in the folder of the results. It goes when these are complete: a run
/// that is killed between its last stage and its results finds it again.
inline constexpr const char* checkpoint_name = "update.checkpoint.json";

/// Where an updating stands between two stages, in a small file: a run that was killed goes on from there.
class UpdatingCheckpoint {
public:
  /// `folder` empty: nothing is kept. `fingerprint`: of everything that the course of the updating depends on.
  UpdatingCheckpoint(const std::filesystem::path& folder, std::string fingerprint, Eigen::Index parameters);

  struct Content {
    GaussNewtonState state;
    std::vector<UpdatingStep> trace;
  };
  /// Nothing where there is no file, it is of another case, or it is damaged.
  [[nodiscard]] std::optional<Content> read() const;
  void write(const Content& content) const;

private:
  std::filesystem::path file_;
  std::string fingerprint_;
  Eigen::Index parameters_;
};

/// Of the case with all its defaults, the version of the program, and the residual at the first values, which stands
/// for everything in the files that the case names.
std::string fingerprint_of(const Study& study, double first_residual);

}  // namespace kalfem
