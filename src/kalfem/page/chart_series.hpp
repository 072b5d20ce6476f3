// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// The entries of a vector, as a series of a chart holds them.
inline std::vector<double> series_values(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

/// The times of a record's samples, as the abscissae of a chart.
std::vector<double> times(const Record& record);
/// A curve with the 95 % band of a normal distribution; without a deviation, the curve alone.
Series with_band(const std::string& label, const Eigen::VectorXd& mean, const Eigen::VectorXd& deviation, Role role);
/// The chart with its ordinates in the unit that people read, "displacement [mm]": that of its largest value.
/// `unit`: SI; `own`: the one that the user wrote, which then stays.
Chart with_readable_ordinates(Chart chart, const std::string& quantity, const std::string& unit,
                              const std::string& own = {});
/// The same of the abscissae.
Chart with_readable_abscissae(Chart chart, const std::string& quantity, const std::string& unit);

}  // namespace kalfem
