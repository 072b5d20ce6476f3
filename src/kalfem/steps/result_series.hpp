// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/steps/reported_quantities.hpp"

namespace kalfem {

/// One series of the results under its path, "/estimate/body.3/displacement".
struct ResultSeries {
  std::string path;
  Eigen::VectorXd values;
  std::string unit;
  std::optional<double> sample_rate = {};   ///< [Hz]; empty: the values are not at even times
  std::optional<Eigen::Index> chains = {};  ///< of values that are draws: so many chains, one after the other
};
using SeriesVisitor = std::function<void(const ResultSeries&)>;

/// Hands over the series of a run, most of which have its sampling rate; those without values are left out.
class SeriesWriter {
public:
  SeriesWriter(double sample_rate, const SeriesVisitor& visit) : sample_rate_(sample_rate), visit_(visit) {}

  void write(const std::string& name, const Eigen::VectorXd& values, const std::string& unit);
  /// Each quantity of each point with its standard deviation: <group>/<point>/<quantity>{,_std}.
  void write_points(const std::string& group, const std::vector<PointQuantity>& points);
  /// A column without a time: one value per iteration of the updating, or per line of a response.
  void write_column(const std::string& name, const Eigen::VectorXd& values, const std::string& unit);
  /// Values of Markov chains, one chain after the other.
  void write_chains(const std::string& name, const Eigen::VectorXd& values, const std::string& unit,
                    Eigen::Index chains);

private:
  double sample_rate_;
  const SeriesVisitor& visit_;
};

}  // namespace kalfem
