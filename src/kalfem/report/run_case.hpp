#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A number that a case estimated or updated.
struct CaseValue {
  std::string name, unit;
  double mean = 0.0, std = 0.0;
  double std_robust = 0.0;  ///< holds where the model is not exact; not a number if there is none
};

/// What a run of a case file gives, beside the files that it writes.
struct CaseResult {
  std::vector<CaseValue> estimated;   ///< the filter's unknowns at the record's end
  std::vector<CaseValue> updated;     ///< the refined parameters
  double mean_nis = 0.0;              ///< after settling, 0 where nothing was estimated
  std::vector<std::string> files;     ///< in the folder: summary.json, results.h5, report.html, ...
  std::vector<std::string> warnings;  ///< of the case and of the results
  Verdict verdict;                    ///< whether the numbers agree with each other and with what was stated about them
  std::string failure;                ///< in words, where the numbers are not usable

  [[nodiscard]] bool usable() const { return failure.empty(); }
};

/// Runs every step that a case file declares and writes the results into a folder, as `kalfem run` does. Throws
/// InvalidInput with every problem of the case, by file and line, and WriteFailure (a std::runtime_error) where the
/// results cannot be written.
CaseResult run_case(const std::filesystem::path& case_file, const std::filesystem::path& folder,
                    const Progress& progress = {});

}  // namespace kalfem
