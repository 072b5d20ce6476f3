// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/frequency_course.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/identification/released_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index most_instants = 100;
constexpr double difference = 1e-4;  ///< of a parameter for its derivatives, relative: K and M are smooth in it
constexpr double rigid = 1e-9;       ///< squared frequency over the largest one, below which it is rounding

struct Pencil {
  MatrixXd stiffness, mass;
};

/// K and M of the structure as functions of the problem's unknowns.
class StructureOfUnknowns {
public:
  StructureOfUnknowns(const EstimationProblem& problem, const StructureParts& parts, const AugmentedModelSetup& setup,
                      const AugmentedModelOptions& options)
      : problem_(problem), parts_(parts), linear_(setup.linear_unknowns), of_linear_(linear_unknowns(options)) {}

  [[nodiscard]] Index size() const { return static_cast<Index>(problem_.settings.unknowns.size()); }

  [[nodiscard]] Pencil at(const VectorXd& values) const {
    StructureParts parts = linear_.bindings.empty() ? parts_ : parts_at(problem_, linear_, values(of_linear_));
    for (Index i = 0; i < size(); ++i)
      for (const auto& target : problem_.settings.unknowns[static_cast<std::size_t>(i)].targets)
        if (can_be_released(problem_.structure->parts, target)) set_parameter(parts, target, values[i]);
    const auto coupled = couple(parts);
    return {MatrixXd(stiffness_at_rest(coupled.system())), MatrixXd(coupled.system().mass)};
  }

private:
  const EstimationProblem& problem_;
  const StructureParts& parts_;
  const LinearUnknowns& linear_;
  std::vector<Index> of_linear_;
};

/// Correlation of the first `count` unknowns after the last sample.
MatrixXd correlation_at_end(const RecordEstimate& estimate, Index count) {
  const Index first = estimate.augmented_model->layout().unknown();
  const MatrixXd covariance = estimate.result.final_covariance.block(first, first, count, count);
  const VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

/// The lowest modes of a pencil: squared frequencies [rad^2/s^2] and mass-normalised shapes.
struct Modes {
  VectorXd squared;
  MatrixXd shapes;
};

Modes lowest(const Pencil& pencil, Index count) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(pencil.stiffness, pencil.mass);
  const VectorXd& all = solver.eigenvalues();
  Modes modes{all.head(count), solver.eigenvectors().leftCols(count)};
  for (double& squared : modes.squared)
    if (std::abs(squared) < rigid * all[all.size() - 1]) squared = 0.0;
  return modes;
}

double hertz(double squared) {
  return squared < 0.0 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(squared) / (2.0 * std::numbers::pi);
}

/// d(omega^2)/dtheta, modes x unknowns.
MatrixXd derivatives(const StructureOfUnknowns& structure, const VectorXd& values, const VectorXd& deviation,
                     const Modes& modes) {
  MatrixXd found(modes.squared.size(), structure.size());
  for (Index i = 0; i < structure.size(); ++i) {
    const double step = std::max(difference * std::abs(values[i]), 1e-3 * deviation[i]);
    VectorXd up = values, down = values;
    up[i] += step;
    down[i] -= step;
    const Pencil above = structure.at(up), below = structure.at(down);
    const MatrixXd by_stiffness = (above.stiffness - below.stiffness) * modes.shapes / (2.0 * step);
    const MatrixXd by_mass = (above.mass - below.mass) * modes.shapes / (2.0 * step);
    for (Index m = 0; m < found.rows(); ++m)
      found(m, i) = modes.shapes.col(m).dot(by_stiffness.col(m) - modes.squared[m] * by_mass.col(m));
  }
  return found;
}

}  // namespace

FrequencyCourse frequency_course(const EstimationProblem& problem, const StructureParts& parts,
                                 const AugmentedModelSetup& setup, const RecordEstimate& estimate, Index modes) {
  const StructureOfUnknowns structure(problem, parts, setup, estimate.augmented_model->options());
  const auto& [mean, deviation] = estimate.result.unknowns;
  const Index samples = mean.cols(), first = std::min(estimate.settled, samples - 1);
  const Index instants = std::min(samples - first, most_instants), unknowns = structure.size();
  const MatrixXd correlation = correlation_at_end(estimate, unknowns);
  const Index count = std::min(modes, structure.at(mean.col(samples - 1)).mass.rows());
  FrequencyCourse course{VectorXd(instants), MatrixXd(count, instants), MatrixXd::Zero(count, instants)};
  for (Index k = 0; k < instants; ++k) {
    const Index sample = first + (k + 1) * (samples - first) / instants - 1;
    const VectorXd values = mean.col(sample).head(unknowns), spread = deviation.col(sample).head(unknowns);
    const Modes found = lowest(structure.at(values), count);
    const MatrixXd by_unknowns = derivatives(structure, values, spread, found) * spread.asDiagonal();
    course.time[k] = estimate.measurements.time(sample);
    for (Index m = 0; m < count; ++m) {
      const double frequency = hertz(found.squared[m]);
      course.frequency(m, k) = frequency;
      const double variance = by_unknowns.row(m) * correlation * by_unknowns.row(m).transpose();
      if (frequency > 0.0)
        course.deviation(m, k) =
            std::sqrt(std::max(0.0, variance)) / (8.0 * std::numbers::pi * std::numbers::pi * frequency);
    }
  }
  return course;
}

}  // namespace kalfem
