#pragma once

#include <optional>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Which modes get a damping ratio of their own: so many, or all up to a frequency, or both (whichever ends first).
struct ModalDampingOptions {
  std::optional<Eigen::Index> count = {};
  std::optional<double> up_to = {};  ///< [Hz]
  bool damp_the_rest = true;         ///< modes beyond the last one as well, see add_modal_damping
};

/// Adds damping by ratios to a large model: its lowest modes, of its own M and K, get the rates
///     phi_i^T C phi_i = 2 zeta_i omega_i [1/s],
/// the last ratio holding for all further modes, as the low-rank C_m = M Phi diag(rates) Phi^T M of the model.
///
/// Modes beyond the p computed ones would be undamped. They get the rate of the last one, alpha = 2 zeta_p omega_p, by
/// C += alpha M, which is taken off again from the stored rates: the computed modes keep theirs, rigid-body modes none
/// at all (their stored rate is -alpha). The ratio above omega_p so falls as omega_p / omega.
/// Damping that the model has already stays. Throws InvalidInput where a ratio is negative or not finite, where neither
/// a number nor a frequency is given, or the model has modal damping already.
void add_modal_damping(LinearModel& model, const std::vector<double>& ratios, const ModalDampingOptions& options);

/// The model's lowest `count` normal modes, or fewer where they end at a frequency [Hz]. They are not computed where
/// the modal damping knows them already.
NormalModes lowest_normal_modes(const LinearModel& model, Eigen::Index count, std::optional<double> up_to = {});

}  // namespace kalfem
