// SPDX-License-Identifier: Apache-2.0
#include "modal/modal_runs.hpp"

#include <cmath>
#include <optional>

#include "kalfem/modal/shape_measures.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;

/// The identified mode that is mode `j` of the structure; nothing where there is none left.
std::optional<std::size_t> find_mode(const AmbientStructure& structure, Index j, const ModalResult& result,
                                     const std::vector<bool>& taken) {
  std::optional<std::size_t> best;
  double best_mac = 0.7;
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const auto& mode = result.modes[i];
    if (taken[i] || std::abs(mode.frequency / structure.frequencies()[j] - 1.0) > 0.02) continue;
    const double agreement = mac(mode.shape, structure.shapes.col(j).cast<std::complex<double>>());
    if (agreement < best_mac) continue;
    best_mac = agreement;
    best = i;
  }
  return best;
}

void add_shape(const IdentifiedMode& mode, const Eigen::VectorXd& truth, ModalTally& tally) {
  Index top = 0;
  mode.shape.cwiseAbs().maxCoeff(&top);
  const auto deviation = mode.shape_std();
  for (Index i = 0; i < truth.size(); ++i) {
    if (i == top) continue;  // 1 by definition
    ++tally.shape_intervals;
    tally.shapes_held +=
        std::abs(mode.shape[i].real() - truth[i] / truth[top]) <= mode.coverage_factor() * deviation[i].real();
  }
}

}  // namespace

ModalTally tally_modes(const AmbientStructure& structure, double sample_rate, Index samples, int first, int count,
                       const ModalOptions& options) {
  const Index modes = structure.omega.size();
  ModalTally tally{.found = Eigen::VectorXd::Zero(modes),
                   .frequency_bias = Eigen::VectorXd::Zero(modes),
                   .damping_bias = Eigen::VectorXd::Zero(modes),
                   .records = count};
  for (int seed = first; seed < first + count; ++seed) {
    const auto record = ambient_record(structure, sample_rate, samples, static_cast<std::uint64_t>(seed));
    const auto result = identify_modes(record, options);
    std::vector<bool> taken(result.modes.size(), false);
    for (Index j = 0; j < modes; ++j) {
      const auto at = find_mode(structure, j, result, taken);
      if (!at) {
        ++tally.missed;
        continue;
      }
      taken[*at] = true;
      const auto& mode = result.modes[*at];
      const double off_frequency = (mode.frequency - structure.frequencies()[j]) / mode.frequency_std(),
                   off_damping = (mode.damping - structure.zeta[j]) / mode.damping_std();
      tally.found[j] += 1.0;
      tally.frequency_bias[j] += off_frequency;
      tally.damping_bias[j] += off_damping;
      ++tally.intervals;
      tally.frequencies_held += std::abs(off_frequency) <= mode.coverage_factor();
      tally.dampings_held += std::abs(off_damping) <= mode.coverage_factor();
      add_shape(mode, structure.shapes.col(j), tally);
    }
    tally.spurious += static_cast<int>(std::ranges::count(taken, false));
  }
  tally.frequency_bias.array() /= tally.found.array().max(1.0);
  tally.damping_bias.array() /= tally.found.array().max(1.0);
  return tally;
}

bool is_binomial(int held, int intervals) {
  return std::abs(held - 0.95 * intervals) <= 2.576 * std::sqrt(0.95 * 0.05 * intervals);
}

}  // namespace kalfem::test
