#include <algorithm>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/linalg/sparse_select.hpp"
#include "kalfem/reduction/augmentation_vectors.hpp"
#include "kalfem/reduction/constraint_modes.hpp"
#include "kalfem/reduction/error_indicators.hpp"
#include "kalfem/reduction/mode_selection.hpp"
#include "kalfem/reduction/projection.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<std::string> reduced_names(const std::vector<std::string>& boundary, Index modes, Index truncation) {
  std::vector<std::string> names = boundary;
  for (Index i = 1; i <= modes; ++i) names.push_back("mode" + std::to_string(i));
  for (Index i = 1; i <= truncation; ++i) names.push_back("truncation" + std::to_string(i));
  return names;
}

/// The kept modes with the modal truncation augmentation vectors behind them, where they are wanted.
LowestModes completed_modes(const LinearModel& model, const Partition& parts, const MatrixXd& static_part,
                            LowestModes kept, const SparseFactor& stiffness, bool with_truncation) {
  if (!with_truncation || parts.boundary.empty()) return kept;
  const auto further = augmentation_vectors(parts, select(model.mass, parts.interior, parts.boundary), static_part,
                                            kept.vectors, stiffness);
  const Index count = kept.values.size() + further.values.size();
  kept.values.conservativeResize(count);
  kept.values.tail(further.values.size()) = further.values;
  kept.vectors.conservativeResize(Eigen::NoChange, count);
  kept.vectors.rightCols(further.values.size()) = further.vectors;
  return kept;
}

double comparison_band(const ReductionErrorIndicators& error_indicators, const ReductionOptions& options) {
  if (options.compare_up_to > 0.0) return options.compare_up_to;
  return 0.5 * (error_indicators.highest_kept > 0.0 ? error_indicators.highest_kept : error_indicators.next_left_out);
}

/// The superelement without its comparison with the full model; what belongs to the interior alone, its matrices and
/// their factor, ends here.
Superelement reduced(const LinearModel& model, const std::vector<std::string>& names, const ReductionOptions& options) {
  const Partition parts = partition(model, names);
  const ShiftedStiffness factored =
      factor_stiffness(parts.stiffness_ii, parts.mass_ii, parts.interior_names, options.order);
  const MatrixXd static_part = constraint_modes(parts, factored, rigid_body_modes(parts, factored));
  SelectedModes selected = select_modes(parts, static_part * translations(names), factored, options.modes);
  const VectorXd kept = natural_frequencies(selected.modes.values);

  Superelement element;
  ReductionErrorIndicators& error_indicators = element.error_indicators;
  error_indicators.static_error = static_error(parts, static_part);
  error_indicators.fixed_interface_frequencies = kept;
  error_indicators.highest_kept = kept.size() > 0 ? kept.tail(1)[0] : 0.0;
  error_indicators.next_left_out = natural_frequencies(VectorXd::Constant(1, selected.modes.next.value_or(0.0)))[0];
  error_indicators.rigid_modes = selected.rigid;
  error_indicators.reason = selected.reason;
  error_indicators.factor_bytes = factored.factor.bytes();
  error_indicators.order = factored.factor.order();
  error_indicators.solves = selected.modes.solves + static_part.cols();

  const LowestModes modes = completed_modes(model, parts, static_part, std::move(selected.modes), factored.factor,
                                            options.augmentation_vectors);
  const Index further = modes.values.size() - kept.size();
  if (further > 0) error_indicators.reason += ", " + std::to_string(further) + " modal truncation augmentation vectors";
  element.boundary = parts.boundary;
  element.basis = transformation(parts, static_part, modes.vectors);
  element.model = projected_model(model, element.basis, modes.values, reduced_names(names, kept.size(), further));
  return element;
}

}  // namespace

Superelement craig_bampton(const LinearModel& model, const std::vector<std::string>& boundary,
                           const ReductionOptions& options) {
  const Stopwatch watch;
  Superelement element = reduced(model, joined(boundary, options.also_kept), options);
  element.error_indicators.seconds = watch.seconds();
  if (options.error_indicators)
    element.error_indicators.modes =
        compare_modes(model, element.model, element.basis, comparison_band(element.error_indicators, options));
  return element;
}

Superelement guyan(const LinearModel& model, const std::vector<std::string>& boundary,
                   const ReductionOptions& options) {
  ReductionOptions without_modes = options;
  without_modes.modes = {.count = 0};
  return craig_bampton(model, boundary, without_modes);
}

}  // namespace kalfem
