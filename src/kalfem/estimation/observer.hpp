#pragma once

#include <string>
#include <vector>

#include "kalfem/dynamics/exact_step.hpp"
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

/// An unknown that the filter estimates; several connectors may share it.
struct UnknownParameter {
  std::string name;
  std::string unit;
  std::vector<ParameterTarget> targets;
  ParameterTransform transform;
  double initial = 0.0;      ///< prior mean [unit] (median under log and logit)
  double deviation = 0.0;    ///< prior standard deviation [unit]
  double random_walk = 0.0;  ///< drift that is allowed [unit/sqrt(s)]
};

/// Continuous-time noise, as densities so that nothing depends on the sampling rate.
struct ProcessNoise {
  Eigen::VectorXd acceleration;      ///< white acceleration on each degree of freedom [m/s^2/sqrt(Hz)], n
  Eigen::VectorXd input;             ///< on each input that is modelled by states [its driving unit/sqrt(Hz)], n_u
  Eigen::VectorXd connector_states;  ///< on each internal state [its unit/sqrt(s)]
};

/// Prior of everything but the unknown parameters.
struct StatePrior {
  InitialState mean;
  Eigen::VectorXd displacement_deviation;     ///< [m], n
  Eigen::VectorXd velocity_deviation;         ///< [m/s], n
  Eigen::VectorXd connector_state_deviation;  ///< per internal state
  Eigen::VectorXd input_deviation;            ///< value of an input that is a state, n_u
  Eigen::VectorXd input_rate_deviation;       ///< rate of an integrated input, n_u
  double sensor_state_deviation = 0.0;        ///< of the measurement chains' states, in the sensor's unit
};

/// What an observer is made of, beside the system and its sensors.
struct ObserverOptions {
  std::vector<UnknownParameter> unknowns;
  ProcessNoise process_noise;
  StatePrior prior;
  std::vector<InputTreatment> inputs;  ///< one an input, or none: all known
  bool keep_initial_state = false;     ///< carry the initial state as constants: a fixed-point smoother of it
  double step = 1e-3;                  ///< sample interval [s]
  /// Connector forces and inputs are linear in time over each of so many equal parts of a sample interval. Their error
  /// is of second order in the part; more parts cost a few connector forces more, whatever the number of states.
  int substeps = 1;
  ForceSolveOptions forces = {};
  StateCoordinates coordinates = StateCoordinates::physical;
};

/// Where the parts of the augmented state stand: [x; s; theta; x(0); s(0)].
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

/// The augmented model of joint state and parameter estimation: immutable data from which each run makes its own maps.
class Observer {
public:
  /// Throws InvalidInput on priors outside their ranges, unknown parameters that no connector has, wrong sizes.
  Observer(const LocallyNonlinearSystem& system, const OutputMap& sensors, const std::vector<MeasurementChain>& chains,
           ObserverOptions options);

  [[nodiscard]] const StateLayout& layout() const { return layout_; }
  [[nodiscard]] const FirstOrderForm& form() const { return form_.first_order; }
  [[nodiscard]] const ObserverForm& observer_form() const { return form_; }
  [[nodiscard]] const ExactStep& step() const { return step_; }  ///< one part of a sample interval
  [[nodiscard]] const LocallyNonlinearSystem& system() const { return system_; }
  [[nodiscard]] const ObserverOptions& options() const { return options_; }
  /// Of the augmented state in the observer's coordinates, as everything that the filter sees.
  [[nodiscard]] const Gaussian& prior() const { return prior_; }
  [[nodiscard]] const Eigen::MatrixXd& process_noise() const { return process_noise_; }  ///< Q of one step

  /// Rows of the augmented state, and its covariance, in physical coordinates.
  [[nodiscard]] Eigen::MatrixXd physical(Eigen::MatrixXd rows) const {
    return moved(std::move(rows), &ObserverForm::to_physical);
  }
  [[nodiscard]] Eigen::MatrixXd physical_covariance(const Eigen::MatrixXd& covariance) const;

  /// The prior with other means of the unknowns and of the initial state (physical coordinates): another pass over the
  /// same record.
  [[nodiscard]] Gaussian prior_about(const Eigen::VectorXd& unknowns, const Eigen::VectorXd& linear_state,
                                     const Eigen::VectorXd& connector_states) const;

private:
  void check() const;
  void set_prior();
  void set_process_noise();
  using Move = Eigen::MatrixXd (ObserverForm::*)(const Eigen::Ref<const Eigen::MatrixXd>&) const;
  [[nodiscard]] Eigen::MatrixXd moved(Eigen::MatrixXd rows, Move move) const;
  [[nodiscard]] Eigen::MatrixXd in_own_coordinates(Eigen::MatrixXd rows) const {
    return moved(std::move(rows), &ObserverForm::from_physical);
  }

  LocallyNonlinearSystem system_;
  ObserverOptions options_;
  ObserverForm form_;
  ExactStep step_;
  StateLayout layout_;
  Gaussian prior_;
  Eigen::MatrixXd process_noise_;
};

}  // namespace kalfem
