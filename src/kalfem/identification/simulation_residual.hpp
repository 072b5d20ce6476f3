// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// The record of some sensors against the simulation of the whole structure under its known excitation, from rest or
/// from a given start: r = (simulated - measured) / noise at every sample after settling. Connectors
/// are as the structure has them. Each column of the Jacobian is a central difference (difference_jacobian()) of two
/// simulations, with the finite elements in the basis of the point. A one-sided difference would not do: the phase of a
/// lightly damped response changes by some tens of radians per change of a stiffness by itself, so that a step of 1e-4
/// leaves an error of a per cent, and where the residual is large the search then ends off the minimum or finds none.
class SimulationResidual final : public Residual {
public:
  struct Options {
    std::string name;
    InitialMotion initial = {};
    double settle = 0.0;          ///< time at the start that does not count [s]
    Eigen::Index substeps = 4;    ///< steps per sample over which connector forces are linear; the rest is exact
    double relative_step = 1e-4;  ///< of a parameter, to its scale
    std::vector<StructureBinding> connectors = {};  ///< parameters of connectors among those that are varied
  };
  /// `measured`: the sensors that are compared; `parameters`: what is refined.
  SimulationResidual(StructurePtr given, std::vector<Sensor> measured, const Record& record,
                     std::shared_ptr<const ParameterisedStructure> structure, std::vector<UpdatingParameter> parameters,
                     Options options);

  /// Relative error of the Jacobian's columns that its differences may leave.
  static constexpr double derivative_error = 1e-3;

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] Eigen::Index size() const override { return measured_.size(); }
  [[nodiscard]] RowLayout layout() const override { return layout_of_series(measured_.cols(), measured_.rows()); }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;
  /// Of the sensors, then of the excitations.
  [[nodiscard]] std::vector<ComparedGain> gains() const override;
  [[nodiscard]] std::optional<Eigen::MatrixXd> by_gains(const Eigen::VectorXd& parameters) const override;

private:
  [[nodiscard]] StructureParts parts_at(const StructureAtParameters& here, const Eigen::VectorXd& parameters) const;
  [[nodiscard]] std::optional<Eigen::MatrixXd> simulated(const StructureParts& parts,
                                                         const std::vector<SignalPtr>& given) const;
  [[nodiscard]] std::optional<Eigen::VectorXd> values(const StructureParts& parts) const;
  [[nodiscard]] Eigen::VectorXd over_noise(const Eigen::MatrixXd& channels) const;

  StructurePtr given_;
  std::shared_ptr<const ParameterisedStructure> structure_;
  Options options_;
  std::vector<Sensor> sensors_;
  std::vector<UpdatingParameter> parameters_;
  double start_ = 0.0, sample_rate_ = 0.0;  ///< of the record [s], [Hz]
  Eigen::Index settled_ = 0;                ///< first sample that counts
  Eigen::MatrixXd measured_;                ///< sensors x counted samples
  Eigen::VectorXd noise_;                   ///< one a sensor
};

}  // namespace kalfem
