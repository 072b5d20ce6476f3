// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/identify_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/modal/block_covariance.hpp"
#include "kalfem/modal/modal_setup.hpp"
#include "kalfem/modal/output_correlations.hpp"
#include "kalfem/modal/shape_measures.hpp"
#include "kalfem/modal/spectral_modes.hpp"
#include "kalfem/modal/stabilisation.hpp"
#include "kalfem/modal/state_space_poles.hpp"
#include "kalfem/modal/subspace.hpp"
#include "kalfem/records/frf_estimates.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double few_degrees_of_freedom = 8.0;  ///< below, a standard deviation is known to no more than a quarter

/// Shape and its deviations in the channels' units, the largest entry 1 again.
void rescale(IdentifiedMode& mode, MatrixXd& deviations, const VectorXd& scale) {
  const Index channels = scale.size();
  VectorXcd shape = scale.cwiseProduct(mode.shape);
  Index top = 0;
  shape.cwiseAbs().maxCoeff(&top);
  const std::complex<double> largest = shape[top];
  mode.shape = shape / largest;
  for (Index block = 0; block < deviations.cols(); ++block) {
    VectorXcd change(channels);
    change.real() = scale.cwiseProduct(deviations.col(block).head(channels));
    change.imag() = scale.cwiseProduct(deviations.col(block).tail(channels));
    const VectorXcd relative = (change - mode.shape * change[top]) / largest;
    deviations.col(block) << relative.real(), relative.imag();
  }
}

IdentifiedMode mode_of(const PoleTrack& track, const StatePole& pole, const Subspace& subspace,
                       const PoleOptions& options, const VectorXd& scale) {
  const Index memory = memory_in_blocks(pole, options, subspace.blocks);
  const auto covariance = block_covariance(pole.deviations, memory);
  IdentifiedMode mode{.frequency = pole.frequency,
                      .damping = pole.damping,
                      .covariance = covariance.of_mean,
                      .degrees_of_freedom = covariance.degrees_of_freedom,
                      .shape = pole.shape,
                      .shape_covariance = {},
                      .participation = pole.participation,
                      .order = static_cast<int>(pole.order),
                      .orders = static_cast<int>(track.poles.size())};
  MatrixXd deviations = shape_deviations(subspace, pole, options);
  rescale(mode, deviations, scale);
  mode.shape_covariance = block_covariance(deviations, memory).of_mean;
  mode.phase_collinearity = phase_collinearity(mode.shape);
  return mode;
}

/// Frequency responses of the wanted channels to the inputs.
FrfMatrix responses_to_inputs(const Record& record, const ModalOptions& options) {
  std::vector<std::string> outputs = options.channels;
  if (outputs.empty())
    for (const auto& channel : record.channels)
      if (std::ranges::find(options.inputs, channel.name) == options.inputs.end()) outputs.push_back(channel.name);
  const auto& [seconds, window, estimator] = options.forced;
  constexpr double usual_parts = 8.5;  // sixteen segments that overlap by half
  if (!(seconds >= 0.0) || !std::isfinite(seconds))
    throw InvalidInput(fmt::format("a segment of {} s is asked for", seconds), "a length must be positive", "");
  const double samples = seconds > 0.0 ? seconds * record.sample_rate : double(record.samples()) / usual_parts;
  return estimate_frfs({&record, 1}, options.inputs, outputs,
                       {{.segment = static_cast<Index>(std::llround(samples)), .window = window}, estimator});
}

}  // namespace

ModalResult identify_modes(const Record& given, const ModalOptions& options) {
  if (!options.inputs.empty()) return identify_modes(responses_to_inputs(given, options), options);
  const ModalSetup setup = make_modal_setup(given, options);
  const Record& record = setup.record;
  const int threads = options.threads > 0 ? options.threads : processors();
  const auto tell = [&](const char* words, double fraction) {
    if (options.progress) options.progress(words, fraction);
  };
  tell("correlations", 0.0);
  const auto correlations =
      output_correlations(record.values, setup.references, 2 * setup.block_rows - 1, setup.blocks, threads);
  tell("singular values", 0.4);
  const Subspace subspace = make_subspace(correlations, options.subspace, setup.block_rows, setup.max_order,
                                          setup.scale, setup.references, threads);
  const PoleOptions pole_options{.sample_rate = record.sample_rate, .block_length = correlations.block_length};
  std::vector<std::vector<StatePole>> by_order(static_cast<std::size_t>(subspace.max_order() / 2));
  for (std::size_t i = by_order.size(); i-- > 0;) {
    stop_if_asked();
    by_order[i] = poles_of_order(subspace, 2 * static_cast<Index>(i) + 2, pole_options);
    if (options.band)
      std::erase_if(by_order[i], [&](const StatePole& pole) {
        return pole.frequency < options.band->from || pole.frequency > options.band->to;
      });
    tell("models", 0.5 + 0.5 * (1.0 - static_cast<double>(i) / static_cast<double>(by_order.size())));
  }
  const auto tracks = options.poles.empty() ? stable_tracks(by_order, options.stabilisation)
                                            : chosen_tracks(by_order, options.poles, options.stabilisation);
  ModalResult result{.channels = {},
                     .units = {},
                     .references = {},
                     .sample_rate = record.sample_rate,
                     .samples = record.samples(),
                     .block_rows = static_cast<int>(setup.block_rows),
                     .max_order = static_cast<int>(subspace.max_order()),
                     .blocks = static_cast<int>(setup.blocks),
                     .modes = {},
                     .diagram = {},
                     .remarks = setup.remarks};
  for (const auto& channel : record.channels) {
    result.channels.push_back(channel.name);
    result.units.push_back(channel.unit);
  }
  for (const Index row : setup.references) result.references.push_back(result.channels[static_cast<std::size_t>(row)]);
  const Index least_order = sufficient_order(tracks);
  for (const auto& track : tracks)
    result.modes.push_back(mode_of(track, track.representative(least_order), subspace, pole_options, setup.scale));
  for (const auto& mode : result.modes)
    if (mode.degrees_of_freedom < few_degrees_of_freedom)
      result.remarks.push_back(fmt::format(
          "The record holds few decays of the mode at {:.4g} Hz: its standard deviations are uncertain themselves.",
          mode.frequency));
  for (const double frequency : steady_harmonics(by_order, tracks, options.stabilisation))
    result.remarks.push_back(fmt::format(
        "A steady vibration at {:.5g} Hz has no damping: it is a machine's harmonic, and left out.", frequency));
  const auto peaks = spectral_modes(record, setup.scale, result.modes);
  for (std::size_t i = 0; i < peaks.size(); ++i) result.modes[i].spectral = peaks[i];
  for (const auto& poles : by_order)
    for (const auto& pole : poles)
      if (pole.damping > 0.0)
        result.diagram.push_back({static_cast<int>(pole.order), pole.frequency, pole.damping, pole.frequency_std,
                                  std::ranges::any_of(tracks, [&](const PoleTrack& track) {
                                    return std::ranges::find(track.poles, &pole) != track.poles.end();
                                  })});
  return result;
}

}  // namespace kalfem
