#pragma once

#include <optional>
#include <vector>

#include "kalfem/system/locally_nonlinear_system.hpp"

namespace kalfem {

/// Damping of the modes of a whole structure, as it stands on its connectors.
struct GlobalModalDamping {
  std::vector<double> ratios;     ///< ratio to critical per mode; the last one holds for all further modes
  std::optional<double> up_to{};  ///< modes up to here have their own ratio, see add_modal_damping() [Hz]; empty: all
};

/// df/dd of a law where nothing moves [N/m]; not finite where it has no stiffness there.
double stiffness_at_rest(const ConnectorLaw& law, const Eigen::VectorXd& parameters);

/// K with every connector as stiff as at rest, K + sum_j (df_j/dd_j)(0) b_j b_j^T.
SparseMatrix stiffness_at_rest(const LocallyNonlinearSystem& system);

/// Adds C_m = M Phi diag(2 zeta omega) Phi^T M of the modes of M and stiffness_at_rest(). It acts on the motion
/// relative to that with which the structure at rest follows its slowly moving grounds r_i,
///     C_m (z' - sum_i s_i r_i'),    (K + sum_j k_j b_j b_j^T) s_i = p_i + sum_j k_j b_j g_ji,
/// so that a structure that moves with its grounds is not damped.
/// `grounds`: which inputs are displacements of grounds. Throws InvalidInput for unsuitable ratios, where the system
/// has modal damping already, and where a connector is not elastic at rest.
void add_global_modal_damping(LocallyNonlinearSystem& system, const GlobalModalDamping& damping,
                              const std::vector<Eigen::Index>& grounds);

}  // namespace kalfem
