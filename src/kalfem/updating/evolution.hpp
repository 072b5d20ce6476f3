#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/updating/cma_es.hpp"
#include "kalfem/updating/least_squares.hpp"

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

}  // namespace kalfem
