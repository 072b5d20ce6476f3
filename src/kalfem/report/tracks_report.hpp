// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kalfem/modal/mode_tracks.hpp"
#include "kalfem/page/page.hpp"

namespace kalfem {

/// Modes that were followed through records, with what they were followed by.
struct TrackedRecords {
  std::vector<std::string> names;  ///< of the records
  std::vector<ModalResult> results;
  std::vector<std::string> covariates;  ///< "temperature [degC]"
  Eigen::MatrixXd values;               ///< records x covariates
  std::vector<ModeTrack> tracks;
};

/// One row a mode: records that have it, frequency and damping at the mean covariates, scatter, slopes.
std::string tracks_text(const TrackedRecords& tracked);

/// The same for programs, with the frequency and damping of each record.
nlohmann::ordered_json tracks_json(const TrackedRecords& tracked);

/// The same as a page, with the frequencies over the records.
Page tracks_page(const TrackedRecords& tracked);

/// Writes tracks.json and tracks.csv (one row a record: covariates, then frequency, damping and their standard
/// deviations of each mode; empty where it was not found). Throws as write_file_atomically().
void write_tracks(const std::filesystem::path& folder, const TrackedRecords& tracked);

}  // namespace kalfem
