// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "kalfem/formats/unpacked_size.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Whether a file that begins with these bytes is a MATLAB file of version 5 to 7.3; older ones have no mark.
bool begins_matlab(std::string_view head);

/// Reads the series of a MATLAB file (versions 4 to 7.3).
///
/// A vector is a channel, a matrix one a column, or one a row where it has fewer rows: "acc_1", "acc_2", ...; fields of
/// structures are named "run.acc", elements of arrays and cells "run(2).acc". A field `name`, `label` or `title` beside
/// a single series names it, `unit` or `units` states units (SeriesUnits). Their times are a vector `t`, `time` and the
/// like of their length, else `fs`, `sample_rate` or `dt`, `Ts`, of the same structure, or of the one around it; the
/// first column of a matrix where it increases evenly and there is no other. Complex arrays beside their frequencies
/// (frequencies_for()) are functions.
///
/// Everything else is listed in `skipped`: text, sparse matrices, real arrays of more dimensions, `string` and `table`
/// objects with their class, and variables that unpack to more than `options` let them. Throws InvalidInput where the
/// file cannot be read or holds no series.
MeasuredFile read_matlab_file(const std::filesystem::path& path, const MeasuredFileOptions& options = {});

}  // namespace kalfem
