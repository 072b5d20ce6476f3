// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Displacement of every degree of freedom of a finite-element substructure at some times, for pictures.
struct FieldSeries {
  std::string name;  ///< "frame_simulated"
  std::string substructure;
  std::vector<double> times;     ///< [s]
  Eigen::MatrixXd displacement;  ///< dofs of the full model x times
};

/// Collects the displacement of the pictured substructure while a simulation runs.
class FieldCollector {
public:
  explicit FieldCollector(const Study& study);

  /// Makes the simulation hand over its snapshots; does nothing if the case asks for no pictures.
  void attach(SimulationOptions& options);
  [[nodiscard]] std::optional<FieldSeries> take();

private:
  void add(double time, const Eigen::VectorXd& displacement);

  const Study& study_;
  const FiniteElementSubstructure* elements_ = nullptr;
  std::vector<Eigen::Index> dofs_;  ///< of the substructure in the system
  FieldSeries series_;
  std::vector<Eigen::VectorXd> frames_;
};

/// The same from the estimated states, recovered from the reduced coordinates.
std::optional<FieldSeries> estimated_fields(const Study& study, const RecordEstimate& estimate);

/// For ParaView: <name>.pvd of each series, and a folder <name>/ of one .vtu a time.
void write_field_series(const std::filesystem::path& folder, const Study& study,
                        const std::vector<FieldSeries>& fields);

}  // namespace kalfem
