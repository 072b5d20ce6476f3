// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/modal/modal_model_fit.hpp"
#include "kalfem/modal/rational_fraction.hpp"
#include "kalfem/modal/response_modes.hpp"
#include "kalfem/modal/stabilisation.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr Index least_lines = 32;
constexpr Index usual_order = 120;  ///< poles of the largest model
constexpr double few_lines = 3.0;   ///< in a half-power bandwidth: fewer hardly tell a damping

void check_sizes(const FrfMatrix& given, IssueList& issues) {
  const Index lines = given.lines.size(), outputs = std::ssize(given.outputs);
  const auto add = [&](const std::string& what, const std::string& why, const std::string& fix = "") {
    issues.add({}, what, why, fix);
  };
  if (given.inputs.empty() || given.values.size() != given.inputs.size())
    add(fmt::format("responses to {} inputs are given, with {} names", given.values.size(), given.inputs.size()),
        "each input has a name and a matrix of responses");
  if (outputs < 2) add(fmt::format("there are responses of {} outputs", outputs), "a shape needs two and more");
  if (!given.deviations.empty() && given.deviations.size() != given.values.size())
    add(fmt::format("deviations of {} inputs are given", given.deviations.size()),
        "each input has its own, or none has");
  for (std::size_t i = 0; i < given.values.size(); ++i) {
    const std::string name = i < given.inputs.size() ? "'" + given.inputs[i] + "'" : std::to_string(i + 1);
    if (given.values[i].rows() != lines || given.values[i].cols() != outputs)
      add(fmt::format("the responses to {} are {} x {}", name, given.values[i].rows(), given.values[i].cols()),
          fmt::format("there are {} lines and {} outputs", lines, outputs));
    else if (!given.values[i].allFinite())
      add("the responses to " + name + " hold values that are not finite", "every value counts",
          "leave these lines out");
    if (i < given.deviations.size() && (given.deviations[i].rows() != lines || given.deviations[i].cols() != outputs ||
                                        !(given.deviations[i].array() >= 0.0).all()))
      add("the deviations of the responses to " + name + " are no positive numbers, one a response",
          "they weigh the lines");
  }
  const bool ascending = lines < 2 || (given.lines.tail(lines - 1) - given.lines.head(lines - 1)).minCoeff() > 0.0;
  if (lines > 0 && (!given.lines.allFinite() || !ascending || given.lines[0] < 0.0))
    add("the frequencies are negative or not ascending", "lines stand by frequency");
}

void check_options(const ModalOptions& options, IssueList& issues) {
  if (options.band && !(options.band->from >= 0.0 && options.band->from < options.band->to))
    issues.add({}, fmt::format("the band is {} to {} Hz", options.band->from, options.band->to),
               "it must ascend from 0 or more", "");
  if (options.max_order < 0) issues.add({}, "max_order is negative", "models have an order of 4 and more", "");
  if (!options.references.empty())
    issues.add({}, "references are given", "frequency responses have inputs in their place", "leave them out");
}

/// Columns of the wanted outputs. Throws InvalidInput with every name that there is none of.
std::vector<Index> wanted_outputs(const FrfMatrix& given, const std::vector<std::string>& names) {
  std::vector<Index> columns;
  if (names.empty())
    for (Index i = 0; i < std::ssize(given.outputs); ++i) columns.push_back(i);
  std::vector<std::string> known;
  for (const auto& output : given.outputs) known.push_back(output.name);
  IssueList issues;
  for (const auto& name : names) {
    const auto found = std::ranges::find(known, name);
    if (found == known.end())
      issues.add({}, "there is no response of '" + name + "'" + did_you_mean(name, known), "", "");
    else
      columns.push_back(found - known.begin());
  }
  issues.raise();
  return columns;
}

/// Lines in the band, those at 0 Hz left out.
std::vector<Index> wanted_lines(const VectorXd& lines, const ModalOptions& options) {
  const FrequencyBand band =
      options.band.value_or(FrequencyBand{0.0, lines.size() > 0 ? lines[lines.size() - 1] : 0.0});
  std::vector<Index> kept;
  for (Index k = 0; k < lines.size(); ++k)
    if (lines[k] > 0.0 && lines[k] >= band.from && lines[k] <= band.to) kept.push_back(k);
  if (std::ssize(kept) < least_lines)
    throw InvalidInput(fmt::format("there are {} lines between {:.4g} and {:.4g} Hz", kept.size(), band.from, band.to),
                       fmt::format("a fit needs at least {}", least_lines), "widen the band, or use longer segments");
  return kept;
}

/// Lines count by the inverse of their deviation, the root mean square over all responses in units of these.
VectorXd line_weights(const FrfMatrix& given, const std::vector<Index>& lines, const std::vector<Index>& columns,
                      const VectorXd& scale) {
  VectorXd variance = VectorXd::Zero(std::ssize(lines));
  for (const auto& deviations : given.deviations)
    variance += (MatrixXd(deviations(lines, columns)) * scale.cwiseInverse().asDiagonal()).cwiseAbs2().rowwise().mean();
  if (given.deviations.empty() || !(variance.maxCoeff() > 0.0)) return VectorXd::Ones(variance.size());
  const double least = 1e-4 * variance.mean();  // lines of no deviation are known by chance
  const VectorXd weights = variance.cwiseMax(least).cwiseSqrt().cwiseInverse();
  return weights / weights.mean();
}

FittedResponses fitted_responses(const FrfMatrix& given, const std::vector<Index>& lines,
                                 const std::vector<Index>& columns) {
  FittedResponses fitted{
      .omega = 2.0 * std::numbers::pi * given.lines(lines), .values = {}, .weights = {}, .scale = {}};
  VectorXd squares = VectorXd::Zero(std::ssize(columns));
  for (const auto& values : given.values) {
    fitted.values.emplace_back(values(lines, columns));
    squares += fitted.values.back().cwiseAbs2().colwise().mean().transpose();
  }
  fitted.scale = (squares / static_cast<double>(given.values.size())).cwiseSqrt();
  for (Index o = 0; o < fitted.scale.size(); ++o)
    if (!(fitted.scale[o] > 0.0))
      throw InvalidInput("the responses of '" +
                             given.outputs[static_cast<std::size_t>(columns[static_cast<std::size_t>(o)])].name +
                             "' are 0",
                         "an output without motion tells of no mode", "leave it out");
  for (auto& values : fitted.values) values *= fitted.scale.cwiseInverse().asDiagonal();
  fitted.weights = line_weights(given, lines, columns, fitted.scale);
  return fitted;
}

/// Degrees of the fraction, whose orders are every second one or every multiple of the inputs up to the largest that
/// lines and options allow.
std::vector<Index> degrees_of(const FittedResponses& fitted, const ModalOptions& options) {
  const Index order = options.max_order > 0 ? options.max_order : usual_order;
  const Index step = fitted.inputs() == 1 ? 2 : 1, least = 6 * step;
  const Index largest = std::clamp<Index>(order / fitted.inputs(), least, std::max<Index>(least, fitted.lines() / 3));
  std::vector<Index> degrees;
  for (Index degree = step; degree <= largest; degree += step) degrees.push_back(degree);
  return degrees;
}

bool is_within(const IdentifiedMode& mode, const FittedResponses& fitted, const StabilisationOptions& limits) {
  const double omega = 2.0 * std::numbers::pi * mode.frequency;
  return omega >= fitted.omega[0] && omega <= fitted.omega[fitted.lines() - 1] && mode.damping > 0.0 &&
         mode.damping <= limits.largest_damping && mode.frequency_std() <= limits.frequency_std * mode.frequency &&
         mode.damping_std() <= limits.damping_std * mode.damping && mode.participation >= limits.least_participation;
}

/// A mode of the final fit and the track that it began with.
struct FittedMode {
  IdentifiedMode mode;
  VectorXcd shape;  ///< in scaled units
};

/// Fits until every pole is a mode within the limits: those that are none leave, and the others are fitted again.
std::vector<FittedMode> fitted_modes(const FittedResponses& fitted, std::vector<PoleTrack> tracks,
                                     const StabilisationOptions& limits, bool& converged) {
  std::vector<FittedMode> modes;
  while (!tracks.empty()) {
    stop_if_asked();
    VectorXcd start(std::ssize(tracks));
    for (Index r = 0; r < start.size(); ++r) start[r] = tracks[static_cast<std::size_t>(r)].representative().value;
    const ModalModelFit fit = fit_modal_model(fitted, start);
    converged = fit.converged;
    modes.clear();
    std::vector<PoleTrack> kept;
    for (Index r = 0; r < start.size(); ++r) {
      auto& track = tracks[static_cast<std::size_t>(r)];
      IdentifiedMode mode = mode_of_fit(fit, r, fitted.inputs(), fitted.scale);
      mode.order = static_cast<int>(track.representative().order);
      mode.orders = static_cast<int>(track.poles.size());
      if (!track.chosen && (!is_within(mode, fitted, limits) || !stands_out(fit, r, fitted.lines()))) continue;
      const VectorXcd shape = mode.shape.cwiseQuotient(fitted.scale.cast<Complex>());
      modes.push_back({std::move(mode), shape});
      kept.push_back(track);
    }
    if (kept.size() == tracks.size()) break;
    tracks = std::move(kept);
  }
  if (tracks.empty()) modes.clear();
  std::ranges::sort(modes, {}, [](const FittedMode& each) { return each.mode.frequency; });
  return modes;
}

}  // namespace

// 1. The lines and outputs that are wanted, each output in units of its root mean square.
// 2. Fractions of many degrees: poles with shapes; those that hold over the degrees are candidates, by the rules for
//    state-space models.
// 3. All candidates in one modal model, fitted by least squares; poles that it does not determine leave.
ModalResult identify_modes(const FrfMatrix& responses, const ModalOptions& options) {
  IssueList issues;
  check_sizes(responses, issues);
  check_options(options, issues);
  issues.raise();
  const auto columns = wanted_outputs(responses, options.channels);
  const FittedResponses fitted = fitted_responses(responses, wanted_lines(responses.lines, options), columns);
  const auto tell = [&](const char* words, double fraction) {
    if (options.progress) options.progress(words, fraction);
  };
  tell("fractions", 0.0);
  const auto degrees = degrees_of(fitted, options);
  const RationalFraction fraction(fitted, degrees.back());
  std::vector<std::vector<StatePole>> by_degree(degrees.size());
  for_each_index(degrees.size(), options.threads > 0 ? options.threads : processors(), [&](std::size_t i) {
    stop_if_asked();
    const std::size_t largest_first = degrees.size() - 1 - i;
    by_degree[largest_first] = fraction.poles(degrees[largest_first]);
  });
  auto tracks = options.poles.empty() ? stable_tracks(by_degree, options.stabilisation)
                                      : chosen_tracks(by_degree, options.poles, options.stabilisation);
  ModalResult result{.channels = {},
                     .units = {},
                     .references = responses.inputs,
                     .samples = fitted.lines(),
                     .max_order = static_cast<int>(degrees.back() * fitted.inputs()),
                     .method = ModalMethod::rational_fraction,
                     .modes = {},
                     .diagram = {},
                     .remarks = {}};
  for (const Index column : columns) {
    result.channels.push_back(responses.outputs[static_cast<std::size_t>(column)].name);
    result.units.push_back(responses.outputs[static_cast<std::size_t>(column)].unit);
  }
  for (const auto& poles : by_degree)
    for (const auto& pole : poles)
      result.diagram.push_back({static_cast<int>(pole.order), pole.frequency, pole.damping, 0.0,
                                std::ranges::any_of(tracks, [&](const PoleTrack& track) {
                                  return std::ranges::find(track.poles, &pole) != track.poles.end();
                                })});
  tell("modal model", 0.7);
  bool converged = true;
  for (auto& [mode, shape] : fitted_modes(fitted, std::move(tracks), options.stabilisation, converged)) {
    mode.spectral = indicated_mode(fitted, mode, shape);
    const double spacing = (fitted.omega[fitted.lines() - 1] - fitted.omega[0]) /
                           (2.0 * std::numbers::pi * static_cast<double>(fitted.lines() - 1));
    if (2.0 * mode.damping * mode.frequency < few_lines * spacing)
      result.remarks.push_back(
          fmt::format("The half-power bandwidth of the mode at {:.4g} Hz has fewer than {:.0f} lines: leakage may "
                      "bias its damping; use longer segments.",
                      mode.frequency, few_lines));
    result.modes.push_back(std::move(mode));
  }
  if (!converged) result.remarks.push_back("The fit of the modal model did not converge: take its numbers as rough.");
  return result;
}

}  // namespace kalfem
