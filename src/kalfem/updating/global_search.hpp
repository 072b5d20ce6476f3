// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/updating/cma_es.hpp"
#include "kalfem/updating/gauss_newton.hpp"

namespace kalfem {

/// The search after one generation.
struct EvolutionGeneration {
  unsigned generation = 0;     ///< counted from 1
  Eigen::VectorXd parameters;  ///< the best so far
  double cost = 0.0;           ///< F there
};

struct EvolutionOptions {
  CmaEsOptions search{};  ///< lengths in widths of the parameters' bounds
  std::optional<LeastSquaresOptions> polishing = LeastSquaresOptions{};  ///< from the best point; its start is not used
  std::function<bool(const EvolutionGeneration&)> watch{};  ///< called after each generation; false ends the search
};

struct EvolutionOutcome {
  Eigen::VectorXd parameters;  ///< the best, after polishing
  double cost_initial = 0.0;   ///< F at the initial values: |r|^2 / 2 and the prior's share; infinite without response
  double cost_evolved = 0.0;   ///< F before polishing
  double cost_final = 0.0;     ///< F at `parameters`
  int evaluations = 0;         ///< of the residual, without those of polishing
  int without_response = 0;    ///< of them
  CmaEsEnd end = CmaEsEnd::generations;
  std::vector<EvolutionGeneration> trace;
  std::optional<LeastSquaresOutcome> polished;

  /// Some point had a response.
  [[nodiscard]] bool found() const { return evaluations > without_response; }
  /// Why it ended, and how polishing did.
  [[nodiscard]] std::string reason() const;
};

/// Minimises |r|^2 / 2 and the priors' share between the bounds where the landscape is rough: CMA-ES over the cube of
/// the bounds, beginning at the initial values, then least squares from the best point. A point without response counts
/// as very costly; a point outside of the bounds as the nearest one inside, raised by its distance. The same seed gives
/// the same search. Throws InvalidInput as require_startable does, and with each parameter without finite bounds.
EvolutionOutcome evolve(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                        const EvolutionOptions& options = {});

struct MultiStartOptions {
  int starts = 8;             ///< the initial values counted in
  std::uint64_t seed = 1;     ///< of the other starting points
  int threads = 1;            ///< searches at the same time
  double same_within = 1e-3;  ///< two ends are one minimum where each parameter differs by less, in parts of its scale
  LeastSquaresOptions search{};  ///< `start` is not used; `watch` is called from several threads
  /// Smoothed forms of the residual that each search minimises first, in turn, each from where the last one ended.
  std::vector<const Residual*> continuation{};
};

/// A place at which searches ended.
struct Minimum {
  Eigen::VectorXd parameters;  ///< of the search that ended lowest there
  double cost = 0.0;           ///< F there: |r|^2 / 2 and the prior's share
  double residual_cost = 0.0;  ///< |r|^2 / 2
  int reached = 0;             ///< by so many searches
  bool converged = false;      ///< one of them converged there; otherwise the cost falls further
};

struct MultiStartOutcome {
  LeastSquaresOutcome best;     ///< of the lowest cost, whatever ended it
  std::vector<Minimum> minima;  ///< all ends of searches with a response, lowest first
  std::vector<Eigen::VectorXd> starts;
  int converged = 0;    ///< searches
  int evaluations = 0;  ///< of the residual, in all searches
};

/// Starting points, the initial values first and the others a Halton sequence [Hal60] with randomly permuted digits
/// [Owe17]. Point k does not depend on `count`: more starts are the same ones and others, so the best of them is never
/// worse. Along parameter i, each run of b points falls into b equal strips, one into each, with the i-th prime b. They
/// fill the bounds; where one is infinite, the initial value's surrounding of two prior deviations, or of half its
/// scale where there is no prior.
std::vector<Eigen::VectorXd> spread_starts(const std::vector<UpdatingParameter>& parameters, int count,
                                           std::uint64_t seed);

/// Least squares from several starting points. The outcome does not depend on the number of threads. Throws
/// InvalidInput as minimise does.
MultiStartOutcome minimise_from_many(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                                     const MultiStartOptions& options = {});

}  // namespace kalfem
