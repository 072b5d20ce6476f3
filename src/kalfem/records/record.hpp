// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kalfem {

/// What one row of a record holds.
struct Channel {
  std::string name;
  std::string unit = {};
  double noise = 0.0;  ///< standard deviation of a sample's white noise [unit]; 0: not stated
};

/// Equally sampled channels, one row each: the samples of one time, which a filter takes together, lie side by side in
/// memory. One type from the reader of a file to the filter. A sample that is not a number is missing.
struct Record {
  double sample_rate = 1.0;               ///< [Hz]
  double start = 0.0;                     ///< time of the first sample [s]
  std::vector<Channel> channels = {};     ///< row j of the values is channel j
  Eigen::MatrixXd values = {};            ///< channels x samples; column k is the time start + k / sample_rate
  std::optional<Eigen::Index> used = {};  ///< a filter learns from so many first samples; nothing: from all

  [[nodiscard]] Eigen::Index samples() const { return values.cols(); }
  [[nodiscard]] double time(Eigen::Index k) const { return start + static_cast<double>(k) / sample_rate; }
  /// Time of the last sample [s].
  [[nodiscard]] double end() const { return time(samples() - 1); }
  [[nodiscard]] Eigen::Index samples_used() const { return used.value_or(samples()); }
  /// Row of the channel of that name, or -1.
  [[nodiscard]] Eigen::Index find(const std::string& name) const;
  /// Noise of each channel.
  [[nodiscard]] Eigen::VectorXd noise() const;
};

/// A record of one series of samples a channel, {{"road", road}, {"a3", a3}}. Throws InvalidInput where their lengths
/// differ.
Record make_record(double sample_rate, const std::vector<std::pair<std::string, Eigen::VectorXd>>& channels,
                   double start = 0.0);

/// The channels of these names, in this order. Throws InvalidInput with every name that the record does not have.
Record select_channels(const Record& record, const std::vector<std::string>& names);

/// The samples between two times [s]. Throws InvalidInput where there are fewer than two.
Record cut(Record record, double from, double to);

/// Root mean square.
double rms(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// The same of the samples that are not missing; 0 where all are.
double rms_of_present(const Eigen::Ref<const Eigen::VectorXd>& channel);

/// NRMSE = rms(estimate - reference) / rms(reference); NaN-free: 0/0 counts as 0, x/0 as infinity.
double nrmse(const Eigen::Ref<const Eigen::VectorXd>& estimate, const Eigen::Ref<const Eigen::VectorXd>& reference);

}  // namespace kalfem
