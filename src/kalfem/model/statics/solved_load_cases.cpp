// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/solved_load_cases.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <sstream>

#include "kalfem/model/statics/geometric_stiffness.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Beyond this the sum of loads and reactions is no rounding [-].
constexpr double largest_imbalance = 1e-6;

double size_of(const StressPeak& peak) { return std::abs(peak.value); }

std::string imbalance_in_words(const StaticSolution& solution) {
  std::ostringstream words;
  words << "static load case '" << solution.load_case << "': the reactions differ from the loads by "
        << std::setprecision(1) << solution.imbalance
        << " of the largest force; constraints or matrices of another code hold the structure beside its supports, or "
           "the stiffness is almost singular";
  return words.str();
}

PointResponse response_at(const NamedNode& point, const SolvedLoadCase& results) {
  PointResponse response{point.name, point.node, results.solution.displacements.segment<6>(6 * point.node), {}};
  for (const auto& region : results.nodal)
    for (const auto& mean : region)
      if (mean.node == point.node && (!response.stress || von_mises(mean.stress) > von_mises(response.stress->stress)))
        response.stress = mean;
  return response;
}

SolvedLoadCase results_of(const StaticsProblem& problem, std::size_t number) {
  const auto& load_case = problem.analysis->cases()[number];
  const auto& model = problem.analysis->model();
  SolvedLoadCase results{.solution = problem.analysis->solve(number)};
  results.stresses = recover_stresses(model, results.solution.displacements, load_case.field(), load_case.beam_loads);
  for (const auto& region : results.stresses) {
    results.nodal.push_back(nodal_stresses(model.mesh, region));
    if (auto peak = stress_peak(model.mesh, region, results.nodal.back())) results.peaks.push_back(std::move(*peak));
  }
  std::ranges::stable_sort(results.peaks, std::greater{}, size_of);
  for (const auto& point : problem.points) results.points.push_back(response_at(point, results));
  return results;
}

}  // namespace

SolvedLoadCases statics(const StaticsProblem& problem) {
  SolvedLoadCases all;
  const auto& analysis = *problem.analysis;
  for (std::size_t i = 0; i < analysis.cases().size(); ++i) {
    const auto& solution = all.cases.emplace_back(results_of(problem, i)).solution;
    if (const auto ignored = analysis.ignored_springs(i); !ignored.empty())
      all.warnings.push_back(ignored_preload(analysis.cases()[i].preload.front().name, ignored));
    if (!(solution.imbalance < largest_imbalance)) all.warnings.push_back(imbalance_in_words(solution));
  }
  return all;
}

Index farthest_node(const StaticSolution& solution) {
  Index node = 0;
  solution.displacements.reshaped(6, solution.displacements.size() / 6).topRows<3>().colwise().norm().maxCoeff(&node);
  return node;
}

}  // namespace kalfem
