#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/time_series.hpp"

namespace kalfem {

/// The named columns of a table on disk, in that order: .csv (also .txt, .dat, .tsv), .lvm, .h5 (also .hdf5; `dataset`
/// is samples x channels with an attribute or a number as channel name "0", "1", ..., or a group with a dataset a
/// channel). Throws InvalidInput where the file, a channel or the sampling rate is missing.
TimeSeries read_record_file(const std::filesystem::path& file, const std::vector<std::string>& channels,
                            std::optional<double> sample_rate, const std::string& dataset);

}  // namespace kalfem
