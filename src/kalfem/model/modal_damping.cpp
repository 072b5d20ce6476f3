#include "kalfem/model/modal_damping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

void check(const LinearModel& model, const std::vector<double>& ratios, const ModalDampingOptions& options) {
  IssueList issues;
  for (const double ratio : ratios)
    if (!(ratio >= 0.0) || !std::isfinite(ratio))
      issues.add({}, "a damping ratio is " + std::to_string(ratio), "a negative one would feed energy in");
  if (!options.count && !options.up_to)
    issues.add({}, "modal damping does not say for how many modes", "not all modes of a large model are computed",
               "give their number or a frequency");
  if (options.count && *options.count < 0)
    issues.add({}, "modal damping of " + std::to_string(*options.count) + " modes", "the number is negative");
  if (options.up_to && !(*options.up_to > 0.0 && std::isfinite(*options.up_to)))
    issues.add({}, "modal damping up to " + std::to_string(*options.up_to) + " Hz",
               "the frequency must be positive and finite");
  if (model.modal_damping.rates.size() > 0)
    issues.add({}, "modal damping is added to a model that has some", "the modes would be damped twice");
  issues.raise();
}

LowestModes damped_modes(const LinearModel& model, const ModalDampingOptions& options) {
  LowestModesOptions wanted;
  if (options.count) wanted.count = std::min(*options.count, (model.mass.diagonal().array() > 0.0).count());
  if (options.up_to) wanted.below = std::pow(2.0 * std::numbers::pi * *options.up_to, 2);
  return lowest_modes(model.stiffness, model.mass, wanted);
}

}  // namespace

void add_modal_damping(LinearModel& model, const std::vector<double>& ratios, const ModalDampingOptions& options) {
  check(model, ratios, options);
  if (ratios.empty()) return;
  LowestModes modes = damped_modes(model, options);
  const Index count = modes.values.size();
  if (count == 0) return;
  const VectorXd frequencies = modes.values.cwiseSqrt() / (2.0 * std::numbers::pi);
  VectorXd rates = damping_rates(frequencies, ratios);
  if (options.damp_the_rest && modes.next) {
    const double alpha = rates[count - 1];
    model.damping = SparseMatrix(model.damping + alpha * model.mass);
    rates.array() -= alpha;
  }
  model.modal_damping = {{frequencies, std::move(modes.vectors)}, rates};
}

}  // namespace kalfem
