// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "kalfem/records/test_point.hpp"

namespace kalfem {

/// The points of a test's geometry.
///
/// * A universal file: its nodes (datasets 15 and 2411), named by their numbers.
/// * A table (.csv, .txt), separated by commas, semicolons or tabs: name, x, y, z in each row; nine further numbers are
///   the sensor's x, y and z axis as vectors, for sensors that look along axes of their own. Lines that begin with #,
///   and a first line of titles, are passed over.
///
/// `unit`: length of the coordinates [m]; a universal file that states its units has metres already. Throws
/// InvalidInput with file and line for rows that cannot be understood, names given twice, axes that are not at right
/// angles, and where there are no points.
std::vector<TestPoint> read_test_points(const std::filesystem::path& file, double unit = 1.0);

}  // namespace kalfem
