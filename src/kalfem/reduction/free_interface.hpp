// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// What stands for the free modes that were left out.
enum class FreeInterfaceKind {
  rubin,   ///< their static flexibility and their mass [Rub75]
  macneal  ///< their static flexibility alone, as springs without mass [Mac71]
};

/// `modes` counts the modes of the free component, not those with the boundary held, its rigid-body modes included;
/// they are all kept in any case. A part of the mass (`effective_mass`) is no criterion here.
struct FreeInterfaceOptions {
  FreeInterfaceKind kind = FreeInterfaceKind::rubin;
  ModeSelection modes = {};                 ///< count or cutoff, at least one
  std::vector<std::string> also_kept = {};  ///< degrees of freedom treated as boundary beside it, such as sensors'
  double compare_up_to = 0.0;               ///< as in ReductionOptions
  Eigen::Index full_modes = 0;              ///< as there
  bool error_indicators = true;             ///< compare at all (costs the full model's modes)
  std::shared_ptr<const StiffnessFactor> whole = {};  ///< factor of the whole model's K, where it is at hand
};

/// Free-interface reduction: the lowest modes Phi of the component whose boundary is free (Lambda their values), with
/// the residual flexibility that the modes left out have at the boundary,
///     z = Phi p + Psi_r f_b,    Psi_r = (G_e - Phi_e Lambda_e^-1 Phi_e^T) B,
/// B the boundary's unit forces, G_e the flexibility with the rigid-body modes R filtered out by inertia relief,
/// G_e = A^T G_c A, A = I - M R R^T. The forces f_b are exchanged for the boundary's displacements, so that the
/// superelement couples like a Craig-Bampton one [CC77]. Statics at the boundary are exact with any number of modes,
/// and so are the modes kept while nothing is attached. The component may be free, partly held or fully held.
///
/// Rubin: K_r = T^T K T and M_r = T^T M T, n_b + modes coordinates. Psi_r is not formed: for a held component the space
/// of Phi and Psi_r is that of [Psi, Phi - Psi Phi_b] with the constraint modes Psi of craig_bampton(); a free one adds
/// the interior's answer K_ii^-1 (M R)_i to the inertia forces of the rigid-body motions that boundary forces cause.
/// What vanishes on the boundary is made uncoupled and mass-normalised: so "mode1", ... are approximate fixed-interface
/// modes. Each coordinate of the space is kept once, so with all modes this is the full model. Frequencies are upper
/// bounds.
///
/// MacNeal: q = [boundary; p], with the residual flexibility G_r = Psi_r of the boundary's rows
///     K_r = [G_r^-1, -G_r^-1 Phi_b; ., Lambda + Phi_b^T G_r^-1 Phi_b],    M_r = diag(0, 1).
/// The mass is singular: the boundary has none until another part lends it mass. Modes of it can be computed, and it
/// can be coupled to what has mass at the interface; to integrate it in time, or to filter with it, alone, take
/// Rubin's. Frequencies may err to either side. Where so few modes are left out that G_r is singular, the reduction is
/// Rubin's (which is exact there), and the evidence says so.
///
/// Two factorisations, of K (K + s M for a free component; none where `whole` is given) and K_ii, and n_b + 6
/// back-solves beside the modes'; a third of K_ii where the held boundary leaves the interior free to move. The
/// evidence speaks of the free modes. Throws InvalidInput with every boundary name that is unknown or doubled, where
/// the selection gives no criterion, or a part of the mass.
Superelement free_interface(const LinearModel& model, const std::vector<std::string>& boundary,
                            const FreeInterfaceOptions& options);

}  // namespace kalfem
