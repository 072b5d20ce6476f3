// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/report/finished/run_comparison.hpp"
#include "kalfem/statistics/population.hpp"

namespace kalfem {

/// One parameter of runs that are members of a population: nominally equal structures, or campaigns at one structure.
struct ParameterPopulation {
  std::string name, unit;
  std::vector<std::size_t> runs;  ///< that found it with a standard deviation; two or more
  NormalPopulation of;            ///< with 95 %; its members are those runs
};

/// Every parameter that two runs or more found with a standard deviation. Throws InvalidInput where there is none.
std::vector<ParameterPopulation> parameter_populations(const RunComparison& comparison);

/// Mean, spread and the next member of each parameter; and, of the runs, what each is as one of them.
std::vector<Table> population_tables(const RunComparison& comparison);

/// The same for programs, in SI units.
nlohmann::ordered_json population_json(const RunComparison& comparison);

}  // namespace kalfem
