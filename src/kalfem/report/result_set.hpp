#pragma once

#include <string>
#include <vector>

#include "kalfem/base/output_folder.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Relative names of the files in a folder, sorted.
struct ResultSet {
  std::vector<std::string> files;    ///< of this run
  std::vector<std::string> removed;  ///< of a former run, which this one did not write anew
};

/// Writes report.html, summary.json, results.h5, case.resolved.yaml, the pictures and the superelements, and switches
/// the folder to them in one step: of a former run nothing is left, files of others stay. Each of the four carries
/// run_identity(); `files` of summary.json lists them all. `run` runs since the start: timing.total_s.
/// Throws as OutputFolder does, and leaves the former set in its place then.
ResultSet write_result_set(OutputFolder& folder, const Study& study, const StudyResults& results, const Stopwatch& run);

/// Throws InvalidInput where a folder stands in the place of a file of the results: found before anything is computed.
void require_result_places(const std::filesystem::path& folder, const Study& study);

/// "report.html, summary.json, frame_simulated/ (40 files)": the names as a person wants to read them.
std::string listed(const std::vector<std::string>& names);

}  // namespace kalfem
