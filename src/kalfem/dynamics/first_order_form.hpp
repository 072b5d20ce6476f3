// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/dynamics/latent_process.hpp"
#include "kalfem/linalg/block_diagonal_form.hpp"
#include "kalfem/linalg/discretisation.hpp"
#include "kalfem/system/locally_nonlinear_system.hpp"
#include "kalfem/system/sensors/measurement_chain.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

/// Linear map of state, input triples and connector forces, v = state x + input u + force f.
struct LinearOutput {
  Eigen::MatrixXd state;  ///< rows x n_x
  Eigen::MatrixXd input;  ///< rows x 3 n_u
  Eigen::MatrixXd force;  ///< rows x m
};

/// How an input that is not known as a motion enters the state.
enum class InputModel {
  known,               ///< r, r' and r'' are given
  integrated,          ///< r'' = w is given (a measured acceleration): r and r' become states
  latent,              ///< nothing is given: r is a LatentProcess, whose states follow (an unknown force)
  latent_acceleration  ///< nothing is given: r'' is a LatentProcess; states r, r' and its own (an unknown ground)
};

struct InputTreatment {
  InputModel model = InputModel::known;
  LatentProcess process = {};  ///< of a latent input

  [[nodiscard]] bool is_latent() const {
    return model == InputModel::latent || model == InputModel::latent_acceleration;
  }
  /// Derivative of r with which the process starts.
  [[nodiscard]] int first_derivative() const { return model == InputModel::latent_acceleration ? 2 : 0; }
  [[nodiscard]] Eigen::Index states() const;
};

/// The locally nonlinear system as first-order equations, sensor dynamics and input models appended:
///     x' = A x + G f + B u,   x = [z; z'; input states; sensor states],   u = [r; r'; r''],
///     k  = [d; d'; d''] of the connectors,     y = sensor outputs behind their measurement chains.
/// Dense: for lumped and reduced systems. Immutable after construction.
class FirstOrderForm {
public:
  /// `chains` has one entry an output (identity where a sensor has no dynamics) or is empty, and so has `treatments`
  /// (all known). Throws InvalidInput where their numbers do not match or a correlation time is not positive.
  FirstOrderForm(const LocallyNonlinearSystem& system, const OutputMap& outputs,
                 const std::vector<MeasurementChain>& chains = {}, const std::vector<InputTreatment>& treatments = {});

  /// The same equations of xi, x = T xi, with the block diagonal T^-1 A T. What inputs and forces do to motion and
  /// outputs directly does not depend on coordinates: it is taken from `physical`, with its exact zeros.
  [[nodiscard]] FirstOrderForm in_coordinates(const BlockDiagonalForm& coordinates,
                                              const FirstOrderForm& physical) const;

  [[nodiscard]] Eigen::Index size() const { return dynamics_.rows(); }
  [[nodiscard]] Eigen::Index dof_count() const { return n_; }
  [[nodiscard]] Eigen::Index input_state_offset() const { return 2 * n_; }
  /// First state of the input's model, -1 for a known input.
  [[nodiscard]] Eigen::Index input_state(Eigen::Index input) const {
    return input_state_[static_cast<std::size_t>(input)];
  }

  [[nodiscard]] const Eigen::MatrixXd& dynamics() const { return dynamics_; }      ///< A, n_x x n_x
  [[nodiscard]] const Eigen::MatrixXd& force_gain() const { return force_gain_; }  ///< G, n_x x m
  [[nodiscard]] const Eigen::MatrixXd& input_gain() const { return input_gain_; }  ///< B, n_x x 3 n_u
  [[nodiscard]] const LinearOutput& motion() const { return motion_; }             ///< k, 3m rows
  [[nodiscard]] const LinearOutput& outputs() const { return outputs_; }           ///< y, l rows
  /// Any other outputs of the same system, without measurement chains.
  [[nodiscard]] LinearOutput raw_outputs(const OutputMap& outputs) const;

private:
  [[nodiscard]] LinearOutput outputs_of_state(const OutputMap& outputs) const;
  void set_mechanics(const LocallyNonlinearSystem& system);
  void add_input_models(const std::vector<InputTreatment>& treatments);
  void set_motion(const LocallyNonlinearSystem& system);
  void add_chains(const LinearOutput& raw, const std::vector<MeasurementChain>& chains);
  [[nodiscard]] LinearOutput route_inputs(LinearOutput output) const;

  Eigen::Index n_ = 0, n_u_ = 0, m_ = 0;
  Eigen::MatrixXd dynamics_, force_gain_, input_gain_;
  LinearOutput acceleration_;  ///< z'' as a function of state, input and force
  std::vector<Eigen::Index> input_state_;
  std::vector<InputTreatment> treatments_;
  LinearOutput motion_, outputs_;
  Eigen::MatrixXd basis_;  ///< T; empty where the state is x itself
};

/// One sample interval of a first-order form with the linear part exact and connector forces and inputs linear in time
/// over the interval:
///     x1 = transition x0 + begin_force f0 + end_force f1 + begin_input u0 + end_input u1.
/// Exact for f and u that are linear over the interval, at any h. The connectors' motion at the end follows as
///     k1 = k1_free + compliance f1,   k1_free = N (x1 without f1) + N_u u1.
struct ExactStep {
  ExactStep(const FirstOrderForm& form, double step);

  double step;                             ///< h [s]
  Eigen::MatrixXd transition;              ///< n_x x n_x
  Eigen::MatrixXd begin_force, end_force;  ///< n_x x m
  Eigen::MatrixXd begin_input, end_input;  ///< n_x x 3 n_u
  Eigen::MatrixXd compliance;              ///< connector motion per force at the end, 3m x m
  Eigen::MatrixXd instant_compliance;      ///< the same at an instant: only d'' feels f, 3m x m
};

}  // namespace kalfem
