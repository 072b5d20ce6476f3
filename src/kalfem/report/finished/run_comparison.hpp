// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/report/finished/finished_run.hpp"

namespace kalfem {

/// What several runs are to each other: answers to one question, or members of a population (nominally equal
/// structures, or campaigns at one) that each have data of their own.
enum class RunsAre { answers, members };

/// Finished runs side by side; the first one is what the others are compared with.
struct RunComparison {
  RunsAre are = RunsAre::answers;
  std::vector<FinishedRun> runs;
  std::vector<std::string> labels;    ///< one a run, no two the same
  std::string differences;            ///< in which sections the cases differ, a sentence; empty if in none
  std::vector<std::string> warnings;  ///< where answers rest on different data or truths, or members on the same data
};

/// Reads the results in two or more folders and looks for what keeps them from being compared. Throws InvalidInput
/// where there are fewer than two, and with every folder that cannot be read, see read_finished_run().
RunComparison compare_runs(const std::vector<std::filesystem::path>& folders, RunsAre are = RunsAre::answers);

/// One parameter in all runs.
struct ComparedParameter {
  std::string name, unit;
  std::optional<double> truth;
  std::vector<std::optional<FoundParameter>> runs;  ///< nothing for a run that does not identify it
};

/// Every parameter that some run identified, in the order in which the runs name them.
std::vector<ComparedParameter> compared_parameters(const RunComparison& comparison);

/// How far an estimate lies from another one in joint standard deviations, (a - b) / sqrt(s_a^2 + s_b^2), as if the two
/// rested on independent data. Nothing if a value is missing.
std::optional<double> joint_deviations(const FoundParameter& a, const FoundParameter& b);

using ErrorsOfRun = Named<NamedErrors> FinishedRun::*;

/// The errors of one kind: a name of point and quantity, "frame.p5, displacement", with one value a run.
Named<std::vector<std::optional<double>>> compared_errors(const RunComparison& comparison, ErrorsOfRun kind);

}  // namespace kalfem
