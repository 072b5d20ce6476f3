// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/live/online_options.hpp"
#include "kalfem/live/online_steps.hpp"

namespace kalfem {

/// The samples of all channels that wait, one column each in a ring, and the filter that takes them. Channels are the
/// sensors, then the inputs without a signal. LiveFilter documents the calls.
class SampleQueue final : public Resumable {
public:
  SampleQueue(FilterProblem problem, std::vector<OnlineInput> inputs, const LiveOptions& options);

  /// Where a channel stands; throws InvalidInput where there is none of that name.
  [[nodiscard]] Eigen::Index find(const std::string& channel) const;
  Eigen::Index push(const std::string& channel, double time, const Eigen::Ref<const Eigen::VectorXd>& values);
  Eigen::Index push(const std::string& channel, const Eigen::Ref<const Eigen::VectorXd>& times,
                    const Eigen::Ref<const Eigen::VectorXd>& values);
  /// A value of a covariate of OnlineOptions::changes, at any time before the filter has passed its window.
  void push_covariate(std::size_t covariate, double time, double value);
  [[nodiscard]] std::optional<std::size_t> find_covariate(const std::string& name) const;
  Eigen::Index flush();

  [[nodiscard]] OnlineSteps& steps() { return steps_; }
  [[nodiscard]] const OnlineSteps& steps() const { return steps_; }
  [[nodiscard]] const std::vector<std::string>& channels() const { return channels_; }
  [[nodiscard]] Eigen::Index sensors() const { return sensors_; }  ///< so many channels come first
  /// Time of the latest sample that any channel has given [s]; empty before the first.
  [[nodiscard]] std::optional<double> newest() const {
    return newest_ < 0 ? std::nullopt : std::optional(static_cast<double>(newest_) / rate_);
  }
  [[nodiscard]] Eigen::Index samples() const { return next_; }     ///< taken so far
  [[nodiscard]] Eigen::Index dropped() const { return dropped_; }  ///< values that came behind the horizon, or twice

  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;
  /// Of the state, see state_fingerprint().
  [[nodiscard]] std::string fingerprint() const { return steps_.fingerprint() + ":" + std::to_string(horizon_); }

private:
  [[nodiscard]] Eigen::Index sample_at(double time) const;
  void require(Eigen::Index channel, Eigen::Index first, const Eigen::Ref<const Eigen::VectorXd>& values) const;
  void add(Eigen::Index channel, Eigen::Index sample, double value);
  void take_complete();
  void take();
  static void transfer(auto& self, auto& archive);

  OnlineSteps steps_;
  LiveOptions options_;
  double rate_;  ///< [Hz]
  std::vector<std::string> channels_;
  std::vector<Eigen::Index> online_;                          ///< inputs without a signal, among all
  Eigen::Index sensors_ = 0;                                  ///< first so many channels
  Eigen::Index horizon_ = 0;                                  ///< in samples; the ring holds one more
  Eigen::MatrixXd values_;                                    ///< channels x samples
  Eigen::Matrix<char, Eigen::Dynamic, Eigen::Dynamic> here_;  ///< whether a value has come
  Eigen::VectorXi arrived_;                                   ///< channels that have come, per sample
  Eigen::VectorXd measured_, held_;                           ///< of the sensors; of all inputs
  Eigen::Index next_ = 0, newest_ = -1;  ///< sample to be taken next, and the latest one that has come
  Eigen::Index dropped_ = 0;
};

}  // namespace kalfem
