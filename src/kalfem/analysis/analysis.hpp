// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/api/estimate.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/api/update.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// What a case file says, as the library's own structure, record and options, so that a program goes on from there:
///     const Analysis analysis = read_case("case.yaml");
///     const auto result = estimate(analysis.structure, *analysis.record, *analysis.estimate);
/// gives the parameters, innovations and likelihood of `kalfem run case.yaml`, bit for bit.
struct Analysis {
  std::string title = {};
  Structure structure = {};                      ///< with the signals of its inputs
  std::optional<Record> record = {};             ///< of the sensors, in SI: measured and prepared, or simulated
  std::optional<EstimateOptions> estimate = {};  ///< where the case has `estimate`
  std::optional<UpdateOptions> update = {};      ///< where it has `update`; the structure stays at its own values
  std::vector<std::string> left_out = {};        ///< sections of the case that are not here: `report`, `predict`, ...
};

/// How a case is read.
struct ReadCaseOptions {
  /// Keys of the case with other values, see RunCaseOptions.
  std::vector<std::pair<std::string, std::optional<std::string>>> set = {};
  bool record = true;      ///< make the record, by a simulation where the case says so; without it `estimate` is empty
  Progress progress = {};  ///< of reductions and of the simulation
};

/// Reads a case file with all the files that it names, and simulates its record where it says so. Throws InvalidInput
/// with every problem of the case, by file and line, and with every key of `estimate`, `update` and `excitation` that
/// the options of the library cannot express, by its name.
Analysis read_case(const std::filesystem::path& file, const ReadCaseOptions& options = {});

/// A case as text, and the records that it reads from files beside it, by their names.
struct CaseText {
  std::string yaml;
  std::vector<std::pair<std::string, Record>> files = {};
};

/// The other direction: the case that says what the analysis does, so that read_case() gives the same again. Numbers
/// have all their digits, files absolute paths. Samples in memory go to files: the record to "NAME.csv", those of an
/// input to "NAME.INPUT.csv". Throws InvalidInput with all that a case cannot say, by its name: laws and signals that
/// are classes or functions of a program, matrices of lumped substructures, finite elements that were not read with a
/// case, online inputs, virtual sensors, comparisons of other things than natural frequencies.
CaseText to_case(const Analysis& analysis, const std::string& name = "case");

/// The same, written as `file` with its records beside it. Throws WriteFailure (a std::runtime_error) too.
void write_case(const Analysis& analysis, const std::filesystem::path& file);

}  // namespace kalfem
