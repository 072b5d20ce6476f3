// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// A key of the case with the values that it takes, in YAML.
struct SweepAxis {
  std::string key;
  std::vector<std::string> values;
};

/// Many runs of one case: every combination of the axes' values, each with every realisation of the noise.
struct SweepPlan {
  std::filesystem::path case_file;
  std::vector<CaseChange> changes = {};  ///< of every run
  std::vector<SweepAxis> axes = {};      ///< the last one changes fastest
  int seeds = 0;  ///< of the noise of a simulated record: simulate.seed is 1 ... `seeds`; 0: the case's own

  [[nodiscard]] std::size_t combinations() const;
  [[nodiscard]] std::size_t size() const;  ///< runs
  /// The axes' values of a combination.
  [[nodiscard]] std::vector<std::string> values(std::size_t combination) const;
};

/// What one run gave.
struct SweepRun {
  std::size_t number = 0;           ///< from 0: seeds change fastest
  std::vector<std::string> values;  ///< of the axes
  std::optional<int> seed;
  std::string summary;  ///< the text of summary.json without times and files; empty where the case cannot be run
  std::string refused;  ///< why it cannot
};

/// The run as JSON on one line, without the line's end: so it stands in runs.jsonl, and so it comes from a worker
/// elsewhere. Its last key, `check`, is a hash of what stands before it.
std::string to_line(const SweepRun& run);
/// The run of such a line; nothing where the line is cut short, or is not what was written.
std::optional<SweepRun> sweep_run_of(const std::string& line);

/// How the runs are made on threads of this process.
struct SweepOptions {
  int threads = 0;                                        ///< runs at a time; 0: one a processor core
  std::vector<SweepRun> known = {};                       ///< of an earlier sweep of this identity: not made again
  std::function<void(const SweepRun&)> on_run = nullptr;  ///< called once for each run that is made, one at a time
  Progress progress = {};                                 ///< "run 17 of 100"
};

/// A sweep that is ready to run. Each run is that of `kalfem run` with the same changes, to the last bit, whoever makes
/// it. A combination is read once for all its seeds, and a reference simulated once for all combinations that share it:
/// those that differ in `estimate`.
class CaseSweep {
public:
  /// Reads the case with the first combination. Throws InvalidInput where that cannot be run, where an axis has no
  /// values or a key is given twice, and for seeds of a case that does not simulate its record.
  explicit CaseSweep(SweepPlan plan);
  ~CaseSweep();
  CaseSweep(const CaseSweep&) = delete;
  CaseSweep& operator=(const CaseSweep&) = delete;

  [[nodiscard]] const SweepPlan& plan() const;
  /// 16 hexadecimal digits: a hash of the version, the plan, the case with all its defaults, and its data files. Two
  /// processes whose sweeps have the same identity make the same runs.
  [[nodiscard]] const std::string& identity() const;

  /// Makes one run; any number, in any order, on several threads side by side. The last combinations are kept, so a
  /// worker takes runs whose numbers follow each other. Of a combination that cannot be run it says why. Throws
  /// InvalidInput where the sweep has no such run.
  [[nodiscard]] SweepRun run_one(std::size_t number);

  /// Makes the runs that are not known, on threads. All runs in the order of their numbers.
  [[nodiscard]] std::vector<SweepRun> run(const SweepOptions& options = {});

private:
  class Combinations;
  std::unique_ptr<Combinations> combinations_;
};

}  // namespace kalfem
