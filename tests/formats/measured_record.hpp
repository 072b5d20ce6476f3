// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/data_folder.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/tables/csv.hpp"

namespace kalfem {

/// Six measured free responses of a half car that is lifted, held and let go, and what their owners say about them.
/// Absent on most machines: the tests that use them skip.
struct MeasuredRun {
  std::string key;
  double release_time = 0.0;  ///< by the owners' rule [s]
  Record record;
};

inline std::filesystem::path measured_runs_folder() { return data_folder("halfcar-rig"); }

inline std::vector<MeasuredRun> measured_runs() {
  const auto folder = measured_runs_folder();
  if (!std::filesystem::exists(folder / "halfcar_500Hz.h5")) return {};
  const auto file = Hdf5File::open((folder / "halfcar_500Hz.h5").string());
  // Release times of index.csv, which mixes text and numbers.
  const std::vector<std::pair<std::string, double>> releases = {
      {"Centre_p0000_m000_t1.1_r1", 0.3356}, {"Centre_p0000_m000_t1.1_r2", 0.3356}, {"Centre_p0000_m200_t5_r1", 0.3568},
      {"Centre_p1000_m000_t3_r1", 0.317},    {"LHS_p0000_m000_t16_r1", 0.3682},     {"LHS_p2000_m000_t20_r1", 0.2018}};
  std::vector<MeasuredRun> runs;
  for (const auto& [key, release] : releases) {
    MeasuredRun run{key, release, {}};
    run.record.sample_rate = 500.0;
    run.record.channels = {{"sprung_LH", "m"}, {"sprung_RH", "m"}, {"unsprung_LH", "m"}, {"unsprung_RH", "m"}};
    run.record.values = file.read_columns_as_rows("/" + key);
    runs.push_back(std::move(run));
  }
  return runs;
}

}  // namespace kalfem
