// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/dynamics/collocation_step.hpp"
#include "kalfem/dynamics/first_order_form.hpp"
#include "kalfem/dynamics/trajectory.hpp"
#include "kalfem/estimation/gaussian.hpp"
#include "kalfem/estimation/parameter_transform.hpp"
#include "kalfem/estimation/state_coordinates.hpp"
#include "kalfem/system/connector_forces.hpp"

namespace kalfem {

/// One parameter of one connector law.
struct ParameterTarget {
  Eigen::Index connector = 0;
  Eigen::Index parameter = 0;
};

/// An unknown that the filter estimates: of connectors, several of which may share it, of the linear part, of both, or
/// a constant offset of sensors.
struct UnknownParameter {
  std::string name;
  std::string unit;
  std::vector<ParameterTarget>
      targets;  ///< none, and no sensors: only of the linear part, see AugmentedModelOptions::system_at
  ParameterTransform transform;
  double initial = 0.0;      ///< prior mean [unit] (median under log and logit)
  double deviation = 0.0;    ///< prior standard deviation [unit]
  double random_walk = 0.0;  ///< drift that is allowed [unit/sqrt(s)]
  /// The linear part depends on it beside its connectors: modal damping follows the stiffness of a released spring.
  bool in_linear_part = false;
  std::vector<Eigen::Index> sensors = {};  ///< outputs that it is added to; then it has no targets and no transform
};

/// Continuous-time noise as densities, which do not depend on the sampling rate. They are two-sided: white acceleration
/// of density q has the autocovariance q^2 delta(tau), so that a velocity's variance grows by q^2 each second; its
/// one-sided spectrum is 2 q^2.
struct ProcessNoise {
  Eigen::VectorXd acceleration;      ///< white acceleration on each degree of freedom [m/s^2/sqrt(Hz)], n
  Eigen::VectorXd input;             ///< on each input that is modelled by states [its driving unit/sqrt(Hz)], n_u
  Eigen::VectorXd connector_states;  ///< on each internal state [its unit/sqrt(s)]
  /// What a density of one at every point is on the degrees of freedom, n, which may be those of a reduced structure;
  /// empty: ones.
  Eigen::VectorXd unit_acceleration = {};
};

/// Prior of everything but the unknown parameters.
struct StatePrior {
  InitialState mean;
  Eigen::VectorXd displacement_deviation;     ///< [m], n
  Eigen::VectorXd velocity_deviation;         ///< [m/s], n
  Eigen::VectorXd connector_state_deviation;  ///< per internal state
  Eigen::VectorXd input_deviation;            ///< value of an input that is a state; of a latent one its process, n_u
  Eigen::VectorXd input_rate_deviation;       ///< rate of an integrated input, n_u
  double sensor_state_deviation = 0.0;        ///< of the measurement chains' states, in the sensor's unit
  /// Further covariance of [displacements; velocities], which may be correlated, 2n x 2n; empty: none.
  Eigen::MatrixXd motion_covariance = {};
};

/// Options of an augmented model, in addition to the system and its sensors.
struct AugmentedModelOptions {
  std::vector<UnknownParameter> unknowns;
  /// The system at values of the unknowns of the linear part, in their order [their units]: what no connector can
  /// carry, such as Young's modulus of a region. Its degrees of freedom, the ends of its connectors and its inputs are
  /// the same for all values. Connectors read their parameters from the state, so that the laws must give the same
  /// total force for all values: a released spring's law carries the departure from the value in the linear part.
  std::function<LocallyNonlinearSystem(const Eigen::VectorXd& values)> system_at = {};
  ProcessNoise process_noise;
  StatePrior prior;
  std::vector<InputTreatment> inputs;  ///< one per input; if empty, all are known
  bool keep_initial_state = false;     ///< carry the initial state as constants: a fixed-point smoother of it
  double step = 1e-3;                  ///< sample interval [s]
  /// Connector forces and inputs are polynomials in time over each of so many equal parts of a sample interval. More
  /// parts cost a few connector forces more, whatever the number of states.
  int substeps = 1;
  /// Of the step over a part, see CollocationStep. 2: they are linear, and the error falls with the square of the
  /// parts. 4: quadratic through the values at begin, middle and end, at the cost of two linear parts; the error falls
  /// with the fourth power where the laws are smooth, otherwise with a lower one.
  int step_order = 2;
  ForceSolveOptions forces = {};
  StateCoordinates coordinates = StateCoordinates::physical;

  /// Instants of a sample interval at which forces and inputs are taken, its begin left out.
  [[nodiscard]] int instants() const { return substeps * step_order / 2; }
};

/// Places of the unknowns of the linear part among all: those without targets, and those that are in both.
std::vector<Eigen::Index> linear_unknowns(const AugmentedModelOptions& options);

/// Positions of the parts of the augmented state [x; s; theta; x(0); s(0)].
struct StateLayout {
  Eigen::Index dofs = 0, linear = 0, connector_states = 0, unknowns = 0;
  bool keeps_initial_state = false;

  [[nodiscard]] Eigen::Index velocity() const { return dofs; }
  [[nodiscard]] Eigen::Index connector_state() const { return linear; }
  [[nodiscard]] Eigen::Index unknown() const { return linear + connector_states; }
  [[nodiscard]] Eigen::Index initial_state() const { return unknown() + unknowns; }
  [[nodiscard]] Eigen::Index size() const {
    return initial_state() + (keeps_initial_state ? linear + connector_states : 0);
  }
};

class AugmentedModel;

/// AugmentedModels beside one, along an unknown of the linear part; in physical coordinates, without neighbours of
/// their own.
struct Neighbours {
  Eigen::Index unknown;  ///< its place among all unknowns
  double value, step;    ///< of the unknown: they stand at value - step and value + step [its unit]
  std::shared_ptr<const AugmentedModel> below, above;
};

/// The augmented model of joint state and parameter estimation: immutable data from which each run makes its own maps.
class AugmentedModel {
public:
  /// `system`: at the initial values of all unknowns.
  /// Throws InvalidInput on priors outside their ranges, unknown parameters that no connector has, wrong sizes.
  AugmentedModel(const LocallyNonlinearSystem& system, const OutputMap& sensors,
                 const std::vector<MeasurementChain>& chains, AugmentedModelOptions options);
  /// The same augmented model about other values of the unknowns of the linear part, in its own coordinates; neighbours
  /// stand sqrt(3) deviations away, a quarter of the value at most. Process noise over a step stays as it is. Throws
  /// InvalidInput if the values are not admissible.
  [[nodiscard]] AugmentedModel about(const Eigen::VectorXd& values, const Eigen::VectorXd& deviations) const;

  [[nodiscard]] const StateLayout& layout() const { return layout_; }
  [[nodiscard]] const FirstOrderForm& form() const { return form_.first_order; }
  [[nodiscard]] const AugmentedModelForm& augmented_model_form() const { return form_; }
  [[nodiscard]] const CollocationStep& step() const { return step_; }  ///< over one part of a sample interval
  [[nodiscard]] const LocallyNonlinearSystem& system() const { return system_; }
  [[nodiscard]] const AugmentedModelOptions& options() const { return options_; }
  [[nodiscard]] const std::vector<Neighbours>& neighbours() const { return neighbours_; }  ///< one per linear unknown
  /// Of the augmented state in the augmented model's coordinates, as everything that the filter sees.
  [[nodiscard]] const Gaussian& prior() const { return prior_; }
  [[nodiscard]] const Eigen::MatrixXd& process_noise() const { return process_noise_; }  ///< Q of one step
  /// What white accelerations of these densities, n, add to the covariance over an interval [s].
  [[nodiscard]] Eigen::MatrixXd acceleration_noise(const Eigen::VectorXd& density, double interval) const;
  /// Q of one step but for white accelerations.
  [[nodiscard]] Eigen::MatrixXd other_process_noise() const;

  /// Rows of the augmented state, and its covariance, in physical coordinates.
  [[nodiscard]] Eigen::MatrixXd physical(Eigen::MatrixXd rows) const {
    return moved(std::move(rows), &AugmentedModelForm::to_physical);
  }
  [[nodiscard]] Eigen::MatrixXd physical_covariance(const Eigen::MatrixXd& covariance) const;
  /// Rows of the augmented state, and its covariance, in the augmented model's coordinates.
  [[nodiscard]] Eigen::MatrixXd own(Eigen::MatrixXd rows) const {
    return moved(std::move(rows), &AugmentedModelForm::from_physical);
  }
  [[nodiscard]] Eigen::MatrixXd own_covariance(const Eigen::MatrixXd& physical) const;

  /// The prior with other means of the unknowns and of the initial state (physical coordinates): another pass over the
  /// same record.
  [[nodiscard]] Gaussian prior_about(const Eigen::VectorXd& unknowns, const Eigen::VectorXd& linear_state,
                                     const Eigen::VectorXd& connector_states) const;

private:
  struct Bare {};  ///< without prior, noise and neighbours
  AugmentedModel(Bare, const LocallyNonlinearSystem& system, const OutputMap& sensors,
                 const std::vector<MeasurementChain>& chains, AugmentedModelOptions options);
  void check() const;
  void set_neighbours(const Eigen::VectorXd& values, const Eigen::VectorXd& deviations);
  void set_prior();
  void add_latent_inputs(Eigen::MatrixXd& covariance) const;
  [[nodiscard]] Eigen::MatrixXd linear_noise(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& input,
                                             double interval) const;
  void add_walks(Eigen::MatrixXd& noise) const;
  using Move = Eigen::MatrixXd (AugmentedModelForm::*)(const Eigen::Ref<const Eigen::MatrixXd>&) const;
  [[nodiscard]] Eigen::MatrixXd moved(Eigen::MatrixXd rows, Move move) const;

  LocallyNonlinearSystem system_;
  OutputMap sensors_;
  std::vector<MeasurementChain> chains_;
  AugmentedModelOptions options_;
  AugmentedModelForm form_;
  CollocationStep step_;
  StateLayout layout_;
  Gaussian prior_;
  Eigen::MatrixXd process_noise_;
  std::vector<Neighbours> neighbours_;
};

}  // namespace kalfem
