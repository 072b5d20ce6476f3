// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/formats/unpacked_size.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// The numeric datasets of an HDF5 file: one column a channel, and the numeric members of a table of records.
///
/// Samples stand along the rows; a dataset with more columns than rows is turned, unless times of its group say
/// otherwise. The rate is an attribute (sample_rate, fs, fs_Hz, dt) of the dataset or of a group around it, or a number
/// of that name in its group; a vector `t` or `time` of their length holds the times. The unit is the attribute `unit`.
/// A channel is also known by the last part of its path. Datasets of which a part is not in the file are listed as
/// skipped, as HDF5 would fill it up, and so are those that unpack to more than `options` let them; channels that are
/// not asked for have no values.
MeasuredFile read_measured_hdf5(const std::filesystem::path& path, const MeasuredFileOptions& options = {});

}  // namespace kalfem
