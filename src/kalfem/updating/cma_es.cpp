// SPDX-License-Identifier: Apache-2.0
// pagmo's class has Eigen members that its library allocates and this file destroys. kalfem aligns Eigen's memory to 64
// bytes, the library as its packager chose, and mixing the two ends in free() of a wrong address. So this file has a
// copy of Eigen of its own, under another name that no other object shares, with plain malloc and free as the library.
#define EIGEN_MALLOC_ALREADY_ALIGNED 1
#define EIGEN_DONT_VECTORIZE
#define Eigen eigen_as_pagmo_has_it
#include "kalfem/updating/cma_es.hpp"

#include <cassert>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

namespace kalfem {
namespace {

/// The problem as pagmo wants it: copyable, hence with pointers.
struct UnitCube {
  const std::function<double(const std::vector<double>&)>* cost = nullptr;
  std::size_t dimension = 1;

  [[nodiscard]] pagmo::vector_double fitness(const pagmo::vector_double& point) const { return {(*cost)(point)}; }
  [[nodiscard]] std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(dimension, 0.0), pagmo::vector_double(dimension, 1.0)};
  }
};

}  // namespace

CmaEsEnd cma_es(const std::function<double(const std::vector<double>&)>& cost, const std::vector<double>& start,
                const CmaEsOptions& options, const std::function<bool(unsigned generation)>& proceed) {
  assert(options.population >= 5 && !start.empty());
  constexpr double automatic = -1.0, no_cost_tolerance = 0.0;
  constexpr bool keep_distribution = true, force_bounds = false;
  const pagmo::algorithm one_generation{pagmo::cmaes(1, automatic, automatic, automatic, automatic,
                                                     options.initial_deviation, no_cost_tolerance, options.tolerance,
                                                     keep_distribution, force_bounds, options.seed)};
  pagmo::population population{pagmo::problem{UnitCube{&cost, start.size()}}, options.population - 1, options.seed};
  population.push_back(start);
  for (unsigned generation = 1; generation <= options.generations; ++generation) {
    const auto evaluations = population.get_problem().get_fevals();
    population = one_generation.evolve(std::move(population));
    if (population.get_problem().get_fevals() == evaluations) return CmaEsEnd::settled;
    if (!proceed(generation)) return CmaEsEnd::stopped;
  }
  return CmaEsEnd::generations;
}

}  // namespace kalfem
