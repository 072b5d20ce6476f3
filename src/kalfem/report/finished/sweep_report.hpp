// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "kalfem/base/output_folder.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/report/finished/finished_run.hpp"
#include "kalfem/report/finished/sweep.hpp"

namespace kalfem {

/// A run with what its summary says; `found` is empty where the case cannot be run.
struct FinishedSweepRun {
  SweepRun run;
  std::optional<FinishedRun> found;
};
std::vector<FinishedSweepRun> finished_runs(const std::vector<SweepRun>& runs);

/// One row a run: values of the axes, seed, status, verdict, mean NIS, and of each parameter estimate, standard
/// deviation and truth. SI; empty where unknown.
std::string sweep_csv(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs);

/// One text or one number a run. SI; not a number where unknown.
struct SweepArrays {
  struct Texts {
    std::string path;
    std::vector<std::string> values;
  };
  struct Numbers {
    std::string path;
    Eigen::VectorXd values;
    std::string unit = {};
  };
  std::vector<Texts> texts;      ///< /axes/<key>, /status, /verdict
  std::vector<Numbers> numbers;  ///< /seed, /mean_nis, /parameters/<name>/{estimate,std,true}
};
SweepArrays sweep_arrays(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs);

/// Statistics for people, one row a combination: how many runs are usable; then of each parameter the mean and the
/// spread of its estimates, the mean of the deviations that the runs state, and how often the 95 % interval holds the
/// truth. Of combinations with one run the estimate itself.
std::vector<Table> sweep_tables(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs);

/// The files of a sweep in a folder that this process alone uses (FolderLock).
/// `runs.jsonl` takes the runs as they are finished, a line of JSON each; its first line names the sweep, and a sweep
/// that was killed goes on from there. `sweep.csv` and `sweep.h5` come at the end.
class SweepFolder {
public:
  /// Reads the runs of a sweep of the same identity; anything else in runs.jsonl gives way to this sweep. A last line
  /// that is cut short is dropped, and so are lines that were damaged since. Throws as FolderLock, require_writable()
  /// and write_file_atomically().
  SweepFolder(const std::filesystem::path& folder, const CaseSweep& sweep);

  [[nodiscard]] const std::vector<SweepRun>& known() const { return known_; }
  /// Numbers of the lines of runs.jsonl that are not what was written; their runs are made again.
  [[nodiscard]] const std::vector<int>& damaged_lines() const { return damaged_lines_; }
  /// Brings the run to runs.jsonl. Throws WriteFailure where the disk takes no more.
  void add(const SweepRun& run);
  /// Writes all files, with all runs in their order: the same bytes, however the runs were distributed.
  void finish(const std::vector<FinishedSweepRun>& runs);

private:
  FolderLock lock_;
  std::filesystem::path folder_;
  SweepPlan plan_;
  std::string heading_;
  std::vector<SweepRun> known_;
  std::vector<int> damaged_lines_;
  std::ofstream stream_;
};

}  // namespace kalfem
