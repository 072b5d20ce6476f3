// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "kalfem/base/progress.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

struct SimulationOutcome;
struct UpdatingStep;

/// The verb of a run that takes every step that its case asks for.
inline constexpr std::string_view every_step = "everything";

struct RunOptions {
  Progress progress = {};             ///< of the whole run: "simulate (1 of 3): reference 3 of at most 7"
  std::filesystem::path folder = {};  ///< where long steps keep their checkpoints; empty: nowhere
  std::function<void(int number, const UpdatingStep&)> on_updating_step = {};
  /// Called with what the run found so far, judged, once its estimation has its first answer.
  std::function<void(const StudyResults&)> on_first_answer = {};
  std::function<SimulationOutcome()> simulation = {};  ///< gives that of this case where it is made already
  bool keep_finished = false;  ///< asked to stop, the run returns the steps that are finished; otherwise it throws
};

/// The simulated or the measured record, with the noise of each channel; the study or the results own it.
const Record& record_of(const Study& study, const StudyResults& results);

/// Runs the steps that the case asks for and the verb takes: every_step, or the name of one in run_steps(), with those
/// that it needs. An updating runs first, so the estimation and the prediction use the updated structure; inference and
/// placement start from the case's own. Throws std::invalid_argument where no step has that name.
///
/// Where the case says `estimate.free: auto`, `study` becomes that of the case with the numbers that were freed among
/// its unknowns: the results are its.
StudyResults run_study(Study& study, std::string_view verb, const RunOptions& options = {});
/// For studies that free nothing.
StudyResults run_study(const Study& study, std::string_view verb, const RunOptions& options = {});

}  // namespace kalfem
