#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Collects the displacement of the substructure that the case wants pictures of, while a simulation runs.
class FieldCollector {
public:
  explicit FieldCollector(const Study& study);

  /// Lets the simulation hand its snapshots over; nothing where the case asks for no pictures.
  void attach(SimulationOptions& options);
  [[nodiscard]] std::optional<FieldSeries> take();

private:
  void add(double time, const Eigen::VectorXd& displacement);

  const Study& study_;
  const FiniteElementSubstructure* elements_ = nullptr;
  Eigen::Index offset_ = 0;
  FieldSeries series_;
  std::vector<Eigen::VectorXd> frames_;
};

/// The same from the estimated states, recovered from the reduced coordinates.
std::optional<FieldSeries> estimated_fields(const Study& study, const EstimationOutcome& outcome);

}  // namespace kalfem
