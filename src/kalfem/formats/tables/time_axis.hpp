#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

/// What a column of equidistant time stamps says.
struct TimeAxis {
  double start = 0.0;        ///< [s]
  double sample_rate = 1.0;  ///< [Hz]
};

struct TimeAxisOptions {
  std::string column = "t";                ///< for the messages
  double jitter = 0.05;                    ///< allowed deviation of an interval, as a fraction of the interval
  std::optional<double> sample_rate = {};  ///< known rate [Hz], which the stamps must then confirm within 0.1 %
};

/// Start and sampling rate from time stamps [s], and a problem with its line for every gap, repeated or reversed stamp.
///
/// Stamps may be rounded: an interval may deviate from the typical one by jitter * interval + one unit of the stamps'
/// last decimal. The rate is (N - 1) / (t_N - t_1), taken to the roundest number that the stamps' resolution allows.
/// `lines`: the line of each stamp in the file.
TimeAxis time_axis(const Eigen::VectorXd& stamps, const std::vector<int>& lines, const TimeAxisOptions& options,
                   FileProblems& problems);

}  // namespace kalfem
