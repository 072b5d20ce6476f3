// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace kalfem {

struct CmaEsOptions {
  unsigned population = 30;    ///< points a generation, at least 5
  unsigned generations = 200;  ///< at most
  unsigned seed = 1;
  double initial_deviation = 0.3;  ///< of the first generation about the start, in edges of the cube
  double tolerance = 1e-6;         ///< ended where a point strays from the mean by less, in edges of the cube
};

enum class CmaEsEnd { settled, generations, stopped };

/// Minimises `cost` over the unit cube by evolution of a normal distribution with adapted covariance (CMA-ES [Han06],
/// of pagmo2 [BI20]). The cost must be finite; it is asked for at points outside of the cube too, where it should grow.
/// `proceed` is called after each generation and ends the search with false. What the two throw is passed on.
CmaEsEnd cma_es(const std::function<double(const std::vector<double>&)>& cost, const std::vector<double>& start,
                const CmaEsOptions& options, const std::function<bool(unsigned generation)>& proceed);

}  // namespace kalfem
