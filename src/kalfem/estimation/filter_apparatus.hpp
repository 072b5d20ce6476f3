#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/observer_maps.hpp"

namespace kalfem {

/// An observer, its maps and the filter over them: what a run over a record works with.
struct FilterApparatus {
  FilterApparatus(std::shared_ptr<const Observer> of, const EstimationOptions& options);

  std::shared_ptr<const Observer> observer;
  TransitionMap transition;
  std::unique_ptr<Filter> filter;
  InstantMap measurement;
  std::optional<InstantMap> monitored;
};

/// Where the unknowns of the linear part are, or were when the observer was linearised about them.
struct LinearEstimate {
  Eigen::VectorXd values, deviations;  ///< one an unknown [its unit]

  /// Whether the observer is to be linearised anew here after it was there. What the tangent leaves out grows with the
  /// square of the move, as a few move^2 / value, and shall be a few per cent of the deviation; and where that has
  /// shrunk, the neighbours stand too far away.
  [[nodiscard]] bool outdates(const LinearEstimate& there) const;
};

/// The apparatus of the observer about `here`, its filter with the estimate that `apparatus` has. `first`: the observer
/// as the run began with it. Throws InvalidInput where the values make no structure.
std::unique_ptr<FilterApparatus> linearised_anew(const Observer& first, const LinearEstimate& here,
                                                 const FilterApparatus& apparatus, const EstimationOptions& options);

}  // namespace kalfem
