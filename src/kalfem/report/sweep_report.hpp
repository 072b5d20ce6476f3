#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include "kalfem/report/finished_run.hpp"
#include "kalfem/report/page.hpp"
#include "kalfem/report/sweep.hpp"

namespace kalfem {

/// The runs of a sweep as they are finished, a line of JSON each: the values of the axes, the seed, and summary.json
/// without its times. The first line names the sweep. A sweep that was killed goes on from here.
class SweepLog {
public:
  /// Reads the runs of a sweep of the same identity; anything else in the file gives way to this sweep. A last line
  /// that is cut short is dropped. Throws as write_file_atomically().
  SweepLog(std::filesystem::path file, const Sweep& sweep);

  [[nodiscard]] const std::vector<SweepRun>& known() const { return known_; }
  /// Brings the run to the file. Throws WriteFailure where the disk takes no more.
  void add(const SweepRun& run);
  /// Replaces the file by all runs in their order: the same bytes, however the runs were distributed.
  void finish(const std::vector<SweepRun>& runs);

private:
  std::filesystem::path file_;
  std::string heading_;
  std::vector<SweepRun> known_;
  std::ofstream stream_;
};

/// A run with what its summary says; `found` is empty where the case cannot be run.
struct FinishedSweepRun {
  SweepRun run;
  std::optional<FinishedRun> found;
};
std::vector<FinishedSweepRun> finished_runs(const std::vector<SweepRun>& runs);

/// One row a run: values of the axes, seed, status, verdict, mean NIS, and of each parameter estimate, standard
/// deviation and truth. SI; empty where unknown.
std::string sweep_csv(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs);

/// The same as arrays over the runs: /axes/<key>, /seed, /status, /mean_nis, /parameters/<name>/{estimate,std,true}.
/// Throws as Hdf5File does.
void write_sweep_arrays(const std::filesystem::path& file, const SweepPlan& plan,
                        const std::vector<FinishedSweepRun>& runs);

/// Statistics for people, one row a combination: how many runs are usable; then of each parameter the mean and the
/// spread of its estimates, the mean of the deviations that the runs state, and how often the 95 % interval holds the
/// truth. Of combinations with one run the estimate itself.
std::vector<Table> sweep_tables(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs);

}  // namespace kalfem
