#pragma once

#include <cstdint>
#include <vector>

#include "kalfem/updating/least_squares.hpp"

namespace kalfem {

struct MultiStartOptions {
  int starts = 8;             ///< the initial values counted in
  std::uint64_t seed = 1;     ///< of the other starting points
  int threads = 1;            ///< searches at the same time
  double same_within = 1e-3;  ///< two ends are one minimum where each parameter differs by less, in parts of its scale
  LeastSquaresOptions search{};  ///< `start` is not used; `watch` is called from several threads
};

/// A place at which searches ended.
struct Minimum {
  Eigen::VectorXd parameters;  ///< of the search that ended lowest there
  double cost = 0.0;           ///< F there: |r|^2 / 2 and the prior's share
  int reached = 0;             ///< by so many searches
};

struct MultiStartOutcome {
  LeastSquaresOutcome best;     ///< of the lowest cost among those that converged, or among all where none did
  std::vector<Minimum> minima;  ///< of the searches that converged, lowest first
  std::vector<Eigen::VectorXd> starts;
  int converged = 0;    ///< searches
  int evaluations = 0;  ///< of the residual, in all searches
};

/// Starting points, the initial values first and the others a Latin hypercube [MBC79]: along each parameter they fall
/// into as many equal strips, one into each. They fill the bounds; where one is infinite, the initial value's
/// surrounding of two prior deviations, or of half its scale where there is no prior.
std::vector<Eigen::VectorXd> spread_starts(const std::vector<UpdatingParameter>& parameters, int count,
                                           std::uint64_t seed);

/// Least squares from several starting points. The outcome does not depend on the number of threads. Throws
/// InvalidInput as minimise does.
MultiStartOutcome minimise_from_many(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                                     const MultiStartOptions& options = {});

}  // namespace kalfem
