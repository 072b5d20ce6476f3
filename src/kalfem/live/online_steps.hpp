// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "kalfem/base/resumable.hpp"
#include "kalfem/live/change_monitor.hpp"
#include "kalfem/live/online_loop.hpp"
#include "kalfem/live/online_options.hpp"
#include "kalfem/system/signal.hpp"
#include "kalfem/system/signals/streamed_spline.hpp"

namespace kalfem {

/// An input of a structure whose filter is moved by its samples.
struct OnlineInput {
  std::string name;
  bool moves_ground = false;  ///< by its displacement
  SignalPtr signal = {};      ///< null: its samples come online
};

/// The filter, and the samples that wait for later inputs. Inputs that come as values pass through a spline each. Once
/// the newest sample is `input_delay` ahead, the filter begins at the first one, and then follows at this distance;
/// measurements wait in a queue until the filter stands at their sample. OnlineFilter documents the calls.
class OnlineSteps final : public Resumable {
public:
  /// `problem`: with a signal for every input, whatever it is where the samples come online.
  OnlineSteps(FilterProblem problem, std::vector<OnlineInput> inputs, const OnlineOptions& options);

  void start(const std::vector<InputSample>& inputs);
  void start(const Eigen::VectorXd& values);
  bool predict(const std::vector<InputSample>& inputs);
  bool predict();
  bool predict_values(const Eigen::VectorXd& values);
  bool update(const Eigen::VectorXd& measured);
  bool finish() { return follow(0); }

  /// Called whenever the filter has taken a sample, wherever it then stands.
  void after_each_sample(std::function<void()> call) { after_sample_ = std::move(call); }

  [[nodiscard]] OnlineLoop& loop() { return loop_; }
  [[nodiscard]] const OnlineLoop& loop() const { return loop_; }
  [[nodiscard]] const std::vector<OnlineInput>& inputs() const { return inputs_; }
  /// Of changes; null without OnlineOptions::changes.
  [[nodiscard]] ChangeMonitor* monitor() { return monitor_ ? &*monitor_ : nullptr; }
  [[nodiscard]] const ChangeMonitor* monitor() const { return monitor_ ? &*monitor_ : nullptr; }

  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;
  /// Of the state, see state_fingerprint().
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }

private:
  /// Values that the sensors showed at a sample.
  struct Waiting {
    long sample = 0;
    Eigen::VectorXd measured;
  };

  bool take(const Eigen::VectorXd& measured);
  bool follow(Eigen::Index distance);
  void begin();
  void take_waiting();
  void leave_splines();
  [[nodiscard]] Eigen::MatrixXd next_interval();
  [[nodiscard]] Eigen::MatrixXd sampled_signals() const;
  [[nodiscard]] Eigen::MatrixXd course_to(const Eigen::VectorXd& next) const;
  [[nodiscard]] Eigen::VectorXd straight_to(const Eigen::VectorXd& values) const;
  [[nodiscard]] Eigen::VectorXd stacked(const std::vector<InputSample>& given) const;
  void require_inputs(const Eigen::VectorXd& values) const;
  [[nodiscard]] Eigen::Index count() const { return std::ssize(inputs_); }
  static void transfer(auto& self, auto& archive);

  std::string fingerprint_;
  std::vector<OnlineInput> inputs_;
  OnlineLoop loop_;
  std::optional<ChangeMonitor> monitor_;
  Eigen::Index delay_;
  bool begun_;                           ///< whether the filter has taken, or may take, the first sample
  long newest_ = 0;                      ///< sample of the last prediction that was asked for
  std::vector<StreamedSpline> splines_;  ///< one an input, while inputs come as values
  std::deque<Waiting> waiting_;
  std::function<void()> after_sample_;
};

}  // namespace kalfem
