// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_map.hpp"
#include "kalfem/system/connector_forces.hpp"

namespace kalfem {

/// y = A x + G phi(N x + e) + b at one x. False where phi cannot be evaluated.
bool image(PartiallyLinearMap& map, const Eigen::VectorXd& x, Eigen::VectorXd& y);

/// What the unknowns of the linear part do to a map of an augmented model, to first order: the map's gain ends in the
/// columns
///     dy/dtheta_i ~ (y(x; theta_i + s_i) - y(x; theta_i - s_i)) / (2 s_i)     at the mean x,
/// y by the maps of the augmented model's neighbours with all that follows from theta (connector forces too), and its
/// nonlinear outputs end in theta_i less the value that the augmented model is about. Without such unknowns it is
/// nothing.
template <class Map>
class ParameterTangent {
public:
  /// Map(neighbour, more...) is the map of a neighbour.
  template <class... More>
  explicit ParameterTangent(const AugmentedModel& augmented_model, const More&... more)
      : augmented_model_(&augmented_model) {
    for (const auto& each : augmented_model.neighbours()) {
      pairs_.push_back({&each, {}});
      pairs_.back().maps.reserve(2);
      pairs_.back().maps.emplace_back(*each.below, more...);
      pairs_.back().maps.emplace_back(*each.above, more...);
    }
  }

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(pairs_.size()); }

  /// Lets every neighbour's map do the same.
  template <class Action>
  void each(const Action& action) {
    for (auto& pair : pairs_)
      for (auto& map : pair.maps) action(map);
  }

  /// Columns at the mean of the augmented state in the augmented model's coordinates; y in the maps' own. False where a
  /// neighbour cannot be evaluated.
  bool derivatives(const Eigen::VectorXd& mean, Eigen::MatrixXd& columns) {
    physical_ = augmented_model_->physical(mean);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      auto& [neighbours, maps] = pairs_[i];
      if (!image(maps[0], physical_, below_) || !image(maps[1], physical_, above_)) return false;
      columns.resize(above_.size(), size());
      columns.col(static_cast<Eigen::Index>(i)) = (above_ - below_) / (2.0 * neighbours->step);
    }
    return true;
  }

  /// theta_i - value in the last columns of `out`; `first_unknown`: the argument of the first unknown.
  void set_outputs(const Eigen::ArrayXXd& in, Eigen::Index first_unknown, Eigen::ArrayXXd& out) const {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const auto& neighbours = *pairs_[i].neighbours;
      const auto& transform =
          augmented_model_->options().unknowns[static_cast<std::size_t>(neighbours.unknown)].transform;
      auto output = out.col(out.cols() - size() + static_cast<Eigen::Index>(i));
      transform.to_parameter(in.col(first_unknown + neighbours.unknown), output);
      output -= neighbours.value;
    }
  }

private:
  struct Pair {
    const Neighbours* neighbours;
    std::vector<Map> maps;  ///< below, above
  };
  const AugmentedModel* augmented_model_;
  std::vector<Pair> pairs_;
  Eigen::VectorXd physical_, below_, above_;
};

/// A map of an augmented model before the laws close it: what it does to the linear part x of the state, the connector
/// forces f at all its instants and the inputs u there,
///     y = A x + G f + B u,     k = N x + L f + E u,     f = law(k),
/// with k the connectors' motion that phi depends on. L is block triangular: forces move what comes later.
struct OpenMap {
  Eigen::MatrixXd all;      ///< [A G B; N L E]
  Eigen::Index outputs;     ///< rows of A; of the process model the linear part of the state
  Eigen::Index states = 0;  ///< columns of A
  Eigen::Index forces = 0;  ///< columns of G
};

/// Transition of the augmented state over one sample interval, in equal parts over each of which the connector forces
/// are linear or quadratic (CollocationStep). Its instants are the begin and the nodes of all parts, N + 1; with linear
/// forces
///     x_i = A_h x_(i-1) + G_0 f_(i-1) + G_1 f_i + drive_i,   i = 1 ... N.
/// Nonlinear arguments: internal states, unknowns, connector motion at the begin and, as far as the linear part and the
/// inputs give it, at the further instants (d and d', 2m each; d'' too where a law depends on it). Nonlinear outputs:
/// the N + 1 forces, internal states at the end, unknowns of the linear part (ParameterTangent). The state itself is
/// moved once over the whole interval.
class ProcessModel final : public PartiallyLinearMap {
public:
  explicit ProcessModel(const AugmentedModel& augmented_model);

  /// Inputs [r; r'; r''] at the N + 1 instants, 3 n_u x (N + 1).
  void set_inputs(const Eigen::Ref<const Eigen::MatrixXd>& inputs);
  /// The same for inputs that are linear over the whole interval.
  void set_inputs(const Eigen::Ref<const Eigen::VectorXd>& begin, const Eigen::Ref<const Eigen::VectorXd>& end);
  /// The mean about which the unknowns of the linear part act, after the inputs.
  void set_mean(const Eigen::VectorXd& mean);
  /// Further columns of evaluate()'s points are values of these parameters, which no unknown has.
  void vary(std::vector<ParameterTarget> parameters) { varied_ = std::move(parameters); }
  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override;
  /// The connector whose force the last evaluation could not compute; nothing where it could.
  [[nodiscard]] std::optional<Eigen::Index> failed_connector() const { return failed_connector_; }
  /// Per input at all instants or, where they are linear over the interval (`straight`), at its two ends.
  [[nodiscard]] OpenMap open(bool straight) const;
  /// The inputs as they were set, in the order of open().
  [[nodiscard]] const Eigen::VectorXd& inputs() const { return ends_; }
  /// The state at the end by the embedded step of order 2 less that by the step of order 4, with the present inputs and
  /// the forces of one evaluate(). The other forces that it would meet itself are left out.
  [[nodiscard]] Eigen::VectorXd embedded_difference(const Eigen::Ref<const Eigen::VectorXd>& outputs) const;

private:
  /// The state after the parts so far, from that at the begin, the forces at all instants and the inputs there.
  struct Composed {
    Eigen::MatrixXd transition, forces, inputs;
  };
  void add_part(Eigen::Index part, Composed& all);
  bool solve_interval(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out);
  bool solve_part(Eigen::Index part, const Eigen::ArrayXXd& in, const Eigen::ArrayXXd& out);

  const AugmentedModel* augmented_model_;
  Eigen::Index parts_, nodes_, motion_;  ///< motion_: arguments of motion at one instant
  ConnectorForces first_forces_;         ///< at the interval's begin
  ConnectorForces forces_;               ///< at the nodes of a part
  /// Connector motion at the nodes of part i per earlier force j, block (i - 1, j), nodes_ motion_ x m each.
  Eigen::MatrixXd force_motion_;
  /// State at the end, and motion at all instants, per input at each instant: n_x and motion_ (N + 1) rows. `straight`:
  /// per input at the two ends, where it is linear between them.
  Eigen::MatrixXd input_state_, input_motion_, straight_state_, straight_motion_;
  /// Of embedded_difference(), with the other sign: per force and per input at each instant.
  Eigen::MatrixXd force_difference_, input_difference_, straight_difference_;
  Eigen::VectorXd ends_;
  std::vector<ParameterTarget> varied_;
  ParameterTangent<ProcessModel> tangent_;
  Eigen::MatrixXd derivatives_;
  bool derivatives_usable_ = true;
  std::optional<Eigen::Index> failed_connector_;
};

/// Outputs of an augmented model: of its system, and what its unknowns add to them.
struct AugmentedModelOutput {
  LinearOutput of_system;
  Eigen::MatrixXd unknowns = {};  ///< rows x unknowns; empty: they add nothing

  AugmentedModelOutput(LinearOutput output) : of_system(std::move(output)) {}  // NOLINT: the usual case
};

/// Which outputs of an augmented model: of its sensors, or any others.
using OutputsOf = std::function<AugmentedModelOutput(const AugmentedModel&)>;
AugmentedModelOutput sensor_outputs(const AugmentedModel& augmented_model);

/// Outputs at an instant as a function of the augmented state, through the connector forces of that instant.
/// Nonlinear arguments: internal states, unknowns, connector motion without the forces (2m or 3m). Nonlinear outputs:
/// forces, unknowns of the linear part (ParameterTangent).
class MeasurementModel final : public PartiallyLinearMap {
public:
  MeasurementModel(const AugmentedModel& augmented_model, const OutputsOf& outputs);

  void set_inputs(const Eigen::Ref<const Eigen::VectorXd>& inputs);
  /// The mean about which the unknowns of the linear part act, after the inputs.
  void set_mean(const Eigen::VectorXd& mean);
  /// Further columns of evaluate()'s points are values of these parameters, which no unknown has.
  void vary(std::vector<ParameterTarget> parameters) { varied_ = std::move(parameters); }
  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override;
  [[nodiscard]] OpenMap open() const;
  /// The connector whose force the last evaluation could not compute; nothing where it could.
  [[nodiscard]] std::optional<Eigen::Index> failed_connector() const { return failed_connector_; }

private:
  const AugmentedModel* augmented_model_;
  Eigen::Index motion_;
  Eigen::MatrixXd input_;  ///< outputs per input
  std::vector<ParameterTarget> varied_;
  ConnectorForces forces_;
  ParameterTangent<MeasurementModel> tangent_;
  Eigen::MatrixXd derivatives_;
  bool derivatives_usable_ = true;
  std::optional<Eigen::Index> failed_connector_;
};

}  // namespace kalfem
