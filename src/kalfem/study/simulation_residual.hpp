#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/study/filter_run.hpp"
#include "kalfem/study/parameterised_structure.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// The record of some sensors against the simulation of the whole structure under its known excitation, from rest or
/// from the start that the case gives: r = (simulated - measured) / noise at every sample after settling. Connectors
/// are as the case gives them. Each column of the Jacobian is a simulation more, with the finite elements in the basis
/// of the point.
class SimulationResidual final : public Residual {
public:
  struct Options {
    std::string name;
    std::vector<std::string> sensors;
    Eigen::Index substeps = 4;    ///< steps per sample over which connector forces are linear; the rest is exact
    double relative_step = 1e-4;  ///< of a parameter, to its scale
  };
  SimulationResidual(const Study& study, FullRecord record, std::shared_ptr<const ParameterisedStructure> structure,
                     Options options);

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] Eigen::Index size() const override { return measured_.size(); }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;

private:
  [[nodiscard]] std::optional<Eigen::VectorXd> values(const StructureParts& parts) const;

  const Study& study_;
  std::shared_ptr<const ParameterisedStructure> structure_;
  Options options_;
  std::vector<StudySensor> sensors_;
  double start_ = 0.0, sample_rate_ = 0.0;  ///< of the record [s], [Hz]
  Eigen::Index settled_ = 0;                ///< first sample that counts
  Eigen::MatrixXd measured_;                ///< counted samples x sensors
  Eigen::VectorXd noise_;                   ///< one a sensor
};

}  // namespace kalfem
