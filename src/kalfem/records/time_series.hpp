#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace kalfem {

/// What one column of a record holds.
struct Channel {
  std::string name;
  std::string unit;
};

/// Equally sampled channels: column j of `values` is channel j, row k is the time start + k / sample_rate.
struct TimeSeries {
  double sample_rate = 1.0;  ///< [Hz]
  double start = 0.0;        ///< time of the first sample [s]
  std::vector<Channel> channels;
  Eigen::MatrixXd values;  ///< samples x channels

  [[nodiscard]] Eigen::Index samples() const { return values.rows(); }
  [[nodiscard]] double time(Eigen::Index k) const { return start + static_cast<double>(k) / sample_rate; }
  /// Column of the channel of that name, or -1.
  [[nodiscard]] Eigen::Index find(const std::string& name) const;
};

/// Root mean square.
double rms(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// NRMSE = rms(estimate - reference) / rms(reference); NaN-free: 0/0 counts as 0, x/0 as infinity.
double nrmse(const Eigen::Ref<const Eigen::VectorXd>& estimate, const Eigen::Ref<const Eigen::VectorXd>& reference);

}  // namespace kalfem
