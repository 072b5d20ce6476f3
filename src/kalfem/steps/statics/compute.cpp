// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/statics/compute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/study/finite_element_part.hpp"

namespace kalfem {
namespace {

/// Beyond this the sum of loads and reactions is no rounding [-].
constexpr double largest_imbalance = 1e-6;

double size_of(const StressPeak& peak) { return std::abs(peak.value); }

PointResponse response_at(const NamedNode& point, const StaticCaseOutcome& outcome) {
  PointResponse response{point.name, point.node, outcome.solution.displacements.segment<6>(6 * point.node), {}};
  for (const auto& region : outcome.nodal)
    for (const auto& mean : region)
      if (mean.node == point.node && (!response.stress || von_mises(mean.stress) > von_mises(response.stress->stress)))
        response.stress = mean;
  return response;
}

StaticCaseOutcome run_case(const StaticsPlan& plan, std::size_t number) {
  const auto& load_case = plan.analysis->cases()[number];
  const auto& model = plan.analysis->model();
  StaticCaseOutcome outcome{.solution = plan.analysis->solve(number)};
  outcome.stresses = recover_stresses(model, outcome.solution.displacements, load_case.field(), load_case.beam_loads);
  for (const auto& region : outcome.stresses) {
    outcome.nodal.push_back(nodal_stresses(model.mesh, region));
    if (auto peak = stress_peak(model.mesh, region, outcome.nodal.back())) outcome.peaks.push_back(std::move(*peak));
  }
  std::ranges::stable_sort(outcome.peaks, std::greater{}, size_of);
  for (const auto& point : plan.points) outcome.points.push_back(response_at(point, outcome));
  return outcome;
}

}  // namespace

StaticsOutcome run_statics(const StaticsPlan& plan, std::vector<std::string>& warnings) {
  const Stopwatch watch;
  StaticsOutcome outcome{.substructure = plan.part->name};
  for (std::size_t i = 0; i < plan.analysis->cases().size(); ++i) {
    outcome.cases.push_back(run_case(plan, i));
    const auto& solution = outcome.cases.back().solution;
    if (const auto ignored = plan.analysis->ignored_springs(i); !ignored.empty())
      warnings.push_back(ignored_preload(plan.analysis->cases()[i].preload.front().name, ignored));
    if (!(solution.imbalance < largest_imbalance))
      warnings.push_back(fmt::format(
          "static load case '{}': the reactions differ from the loads by {:.1g} of the largest force; constraints or "
          "matrices of another code hold the structure beside its supports, or the stiffness is almost singular",
          solution.load_case, solution.imbalance));
  }
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem
