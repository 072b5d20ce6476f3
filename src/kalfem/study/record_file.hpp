#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/time_series.hpp"
#include "kalfem/study/channel_unit.hpp"

namespace kalfem {

/// What a case says of a record file beside its columns.
struct RecordFileOptions {
  std::optional<double> sample_rate = {};  ///< [Hz], where the file does not say it
  std::string dataset = {};                ///< of an HDF5 file
  bool missing = false;                    ///< samples may be missing: they become NaN
};

/// The wanted columns of a table on disk, in that order and in SI: .csv (also .txt, .dat, .tsv), .lvm, .h5 (also .hdf5;
/// `dataset` is samples x channels with an attribute or a number as channel name "0", "1", ...). Units are those of the
/// case, of the columns' titles, of Y_Unit_Label, or of the dataset's attribute `unit` (one for all columns, or one
/// each). Throws InvalidInput where the file, a channel or the sampling rate is missing and where units do not fit.
TimeSeries read_record_file(const std::filesystem::path& file, const std::vector<WantedChannel>& wanted,
                            const RecordFileOptions& options);

}  // namespace kalfem
