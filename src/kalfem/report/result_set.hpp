// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/output_folder.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/steps/result_series.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// summary.json: all SI; keys only if the step ran; null if unknown; never NaN. `run` is run_identity().
/// Of `timing`, total_s covers every other part and never falls below their sum: the steps run one after another, and
/// each part is elapsed time, for any number of threads. estimate_split_s divides the time of the filter; `output` may
/// pass in a thread beside `predict` and `update`.
nlohmann::ordered_json summarise(const Study& study, const StudyResults& results);

/// Takes the times that were measured out of summary.json, or a part of it: what stays is the same for the same run.
void drop_times(nlohmann::ordered_json& json);

/// Visits every series of the results in the order in which they are written.
void visit_results(const Study& study, const StudyResults& results, const SeriesVisitor& visit);

/// The text of summary.json of a run whose files have these names and that took so long [s].
std::string summary_text(nlohmann::ordered_json summary, const std::vector<std::string>& files, double total_seconds);

/// Writes every time series with names, units and sampling rate into an HDF5 file:
/// /time, /measurements/<sensor>, /truth/<point>/<quantity>, /estimate/<point>/<quantity>{,_std},
/// /estimate/parameters/<name>{,_std}, /innovation/{value,deviation,nis}, /prediction/<point>/<quantity>,
/// /validation/time, /validation/<sensor>/{measured,simulated}, /predictive/time,
/// /predictive/<sensor>/{measured,lower,mean,upper}, /profile/<name>/{value,log_likelihood}.
/// /posterior/<name> and /sample_stats/{lp,log_likelihood} are chain x draw, as ArviZ's InferenceData asks; weighted
/// samples are drawn anew with equal weights. Dimensions have netCDF-4's names time, chain and draw. No file where
/// there are none. Throws InvalidInput where the file cannot be written, WriteFailure where the disk is full. `run`:
/// the identity that the file carries as the attribute `run` of its root, see run_identity().
void write_results(const std::string& path, const Study& study, const StudyResults& results, const std::string& run);

/// Writes the augmented model's superelements for other codes, in the formats that the case asks for:
/// <substructure>_reduced with the ending of the format (.mtx, .dmig, .op4, .h5), see write_superelement().
void write_superelements(const std::filesystem::path& folder, const Study& study);

/// report.html's content: the answer first, then convergence of the parameters, motion against the reference, the
/// identified connectors, the prediction, and whether the innovations are what they should be.
Page make_page(const Study& study, const StudyResults& results);

/// Relative names of the files in a folder, sorted.
struct ResultSet {
  std::vector<std::string> files;    ///< of this run
  std::vector<std::string> removed;  ///< of a former run, which this one did not write anew
  std::string summary = {};          ///< the text of summary.json
};

/// Writes report.html, summary.json, results.h5, case.resolved.yaml, case.identified.yaml if the run identified
/// something and is usable, case.proposed.yaml if its record asks for an edit that holds on it, the pictures and the
/// superelements, and switches the folder to them in one step: of a former run nothing is left, files of others stay.
/// Each of the first five carries run_identity(); `files` of summary.json lists them all. `run` runs since the start:
/// timing.total_s. Throws as OutputFolder does, and leaves the former set in its place then.
ResultSet write_result_set(OutputFolder& folder, const Study& study, const StudyResults& results, const Stopwatch& run);

/// Writes summary.json, case.resolved.yaml and case.identified.yaml of a run whose estimation has its first answer. The
/// whole set of a former run stays until this one is whole: then nothing is written. Throws as write_result_set().
void write_first_answer(OutputFolder& folder, const Study& study, const StudyResults& results, const Stopwatch& run);

/// Throws InvalidInput where a folder stands in the place of a file of the results: found before anything is computed.
void require_result_places(const std::filesystem::path& folder, const Study& study);

/// "report.html, summary.json, frame_simulated/ (40 files)": the names as a person wants to read them.
std::string listed(const std::vector<std::string>& names);

}  // namespace kalfem
