// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/report/finished/finished_run.hpp"

namespace kalfem {

class Hdf5File;

/// How a parameter went: over time, or over the evaluations of an updating.
struct ParameterCourse {
  Eigen::VectorXd x, mean;
  Eigen::VectorXd lower, upper;  ///< 95 % band; empty if there is none
};

/// The time series of a finished run, from its results.h5. A run without that file has none.
class RunSeries {
public:
  /// Throws InvalidInput if results.h5 is no HDF5 file or belongs to another run than summary.json.
  explicit RunSeries(const FinishedRun& run);

  /// Paths of all series below a group in natural order (k2 before k10); empty if there is no such group.
  [[nodiscard]] std::vector<std::string> below(const std::string& group) const;
  /// Nothing if there is no such series.
  [[nodiscard]] std::optional<Eigen::VectorXd> read(const std::string& path) const;
  /// The unit of a series; empty if it has none.
  [[nodiscard]] std::string unit(const std::string& path) const;

  /// What the filter held for true at each sample. Its band is 1.96 standard deviations wide on either side.
  [[nodiscard]] std::optional<ParameterCourse> filter_course(const std::string& parameter) const;
  /// The values that the updating held for the best, by the number of the evaluation from 1.
  [[nodiscard]] std::optional<ParameterCourse> updating_course(const std::string& parameter) const;

private:
  std::shared_ptr<const Hdf5File> file_;
};

}  // namespace kalfem
