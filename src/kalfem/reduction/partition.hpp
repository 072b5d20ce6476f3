#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/linalg/long_vectors.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// Degrees of freedom of a model split into boundary and interior, with the blocks that a reduction needs.
struct Partition {
  std::vector<Eigen::Index> boundary;  ///< in the order given
  std::vector<Eigen::Index> interior;  ///< ascending
  std::vector<std::string> interior_names;
  SparseMatrix stiffness_ii, mass_ii, stiffness_ib;
};

/// Throws InvalidInput with every name that the model does not have, or that is given twice.
Partition partition(const LinearModel& model, const std::vector<std::string>& boundary);

/// U with K_ii U = F: how the interior follows static loads F, n_i x k, while the boundary is held. Where K_ii was
/// shifted because it may be singular, F must be in equilibrium (R^T F = 0 with the M_ii-normalised rigid-body modes R,
/// n_i x r, r may be 0), and R^T M_ii U = 0 holds.
class InteriorStatics {
public:
  /// Everything is kept by reference.
  InteriorStatics(const Partition& parts, const StiffnessFactor& factored, const Eigen::MatrixXd& rigid_modes);

  [[nodiscard]] Eigen::MatrixXd response(Eigen::MatrixXd loads) const;

  /// Psi with K_ii Psi = -K_ib, n_i x n_b: how the interior follows unit displacements of the boundary statically.
  [[nodiscard]] std::unique_ptr<LongVectors> constraint_modes() const;

private:
  const Partition& parts_;
  const StiffnessFactor& factored_;
  const Eigen::MatrixXd& rigid_modes_;
  std::optional<SparseFactor> supported_;  ///< of K_ii held statically determinate, where it was shifted
};

/// Largest |K_ii psi + K_ib| / |K_ib| over the columns.
double static_error(const Partition& parts, const LongVectors& constraint_modes);

/// Fixed-interface modes of the interior that a selection keeps, and why.
struct SelectedModes {
  LowestModes modes;
  Eigen::Index rigid = 0;  ///< how many of them are rigid-body modes
  std::string reason;
};

/// The interior's rigid-body modes while the boundary is held, n_i x r; none where K_ii is positive definite.
Eigen::MatrixXd rigid_body_modes(const Partition& parts, const StiffnessFactor& factored);

/// `following`: motion of the interior with each translation of the boundary, n_i x directions; effective mass alone
/// needs it. Rigid-body modes are kept in any case. Throws InvalidInput where no criterion is given, or a value is out
/// of its range.
SelectedModes select_modes(const Partition& parts, const Eigen::MatrixXd& following, const StiffnessFactor& factored,
                           const ModeSelection& selection);

/// Unit displacements of the boundary in each translation, n_b x directions; the names' last part tells the direction.
Eigen::MatrixXd translations(const std::vector<std::string>& boundary_names);

}  // namespace kalfem
