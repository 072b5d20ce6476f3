// SPDX-License-Identifier: Apache-2.0
#include "kalfem/vibration/frequency_responses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/response_reduction.hpp"
#include "kalfem/model/fixed_model.hpp"
#include "kalfem/records/frequency_response.hpp"
#include "kalfem/system/linearised.hpp"
#include "kalfem/updating/direct_response.hpp"
#include "kalfem/updating/frf_model.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Smaller maxima than this part of the highest peak are not reported.
constexpr double least_peak = 0.01;

/// Degrees of freedom of a part at which forces act.
std::vector<std::string> loaded_dofs(const FiniteElementPart& part, const std::vector<FrfSet>& sets) {
  std::vector<std::string> dofs;
  for (const auto& set : sets) {
    const bool is_here = set.input == FrfInput::force && set.place.starts_with(part.name + ".");
    const auto point = is_here ? part.full.points.find(set.place.substr(part.name.size() + 1)) : part.full.points.end();
    if (point == part.full.points.end()) continue;
    for (const auto& [dof, coefficient] : point->second)
      if (std::ranges::find(dofs, dof) == dofs.end()) dofs.push_back(dof);
  }
  return dofs;
}

void warn_of_cutoff(const FiniteElementPart& part, const ReductionErrorIndicators& reduction, double highest,
                    std::vector<std::string>& warnings) {
  if (reduction.next_left_out == 0.0 || highest <= reduction.next_left_out) return;
  warnings.push_back(fmt::format(
      "frequency responses of the reduced model up to {:.4g} Hz: '{}' holds its modes only up to {:.4g} Hz; raise "
      "reduction.up_to to twice the highest line",
      highest, part.name, reduction.highest_kept));
}

/// The structure with its finite elements reduced. The constraint modes of the points at which forces act are kept as
/// well: with them the static response to these forces is exact, as with residual vectors.
LinearModel reduced_model(const FrequencyResponseProblem& problem, std::vector<std::string>& warnings) {
  const double highest = problem.frequencies.tail(1)[0];
  StructureParts parts = problem.parts;
  for (std::size_t i = 0; i < problem.finite_elements.size(); ++i) {
    const auto& [part, request, in_filter, reference] = problem.finite_elements[i];
    const auto loaded = loaded_dofs(*part, problem.sets);
    if (part->boundary.empty() && loaded.empty()) continue;  // nothing acts on it
    const auto element = std::make_shared<const Superelement>(reduce_for_responses(*part, request, loaded, highest));
    warn_of_cutoff(*part, element->error_indicators, highest, warnings);
    parts.finite_elements[i] = {part->name, std::shared_ptr<const LinearModel>(element, &element->model)};
  }
  return linearised_at_rest(couple(parts));
}

/// In a basis of modes and residual vectors, which serves all lines.
std::vector<MatrixXcd> modal_responses(const LinearModel& model, const FrequencyResponseProblem& problem) {
  const VectorXd none;
  const FrfModel responses(std::make_shared<const FixedModel>(model), problem.sets, problem.frequencies.tail(1)[0],
                           none);
  const FrfEvaluation evaluation = responses.evaluate(none, false);
  for (const double line : problem.frequencies)
    if (evaluation.is_singular({0.0, 2.0 * std::numbers::pi * line})) throw singular_at(line);
  std::vector<MatrixXcd> found;
  for (std::size_t i = 0; i < problem.sets.size(); ++i) {
    auto& values = found.emplace_back(problem.frequencies.size(), std::ssize(problem.sets[i].outputs));
    for (Index line = 0; line < values.rows(); ++line) {
      stop_if_asked();
      const std::complex<double> s(0.0, 2.0 * std::numbers::pi * problem.frequencies[line]);
      values.row(line) = evaluation.at(i, s).values.transpose();
    }
  }
  return found;
}

std::vector<MatrixXcd> responses_of(const LinearModel& model, const FrequencyResponseProblem& problem,
                                    const Progress& progress) {
  return problem.method == ResponseMethod::direct ? direct_responses(model, problem.sets, problem.frequencies, progress)
                                                  : modal_responses(model, problem);
}

/// One a set and output.
std::vector<ComputedResponse> without_values(const std::vector<FrfSet>& sets) {
  std::vector<ComputedResponse> responses;
  for (const auto& set : sets)
    for (const auto& output : set.outputs)
      responses.push_back({.input = set.place,
                           .output = output,
                           .name = output + per_input(set),
                           .quantity = name_of(set.quantity),
                           .unit = unit_of(set)});
  return responses;
}

void take(const std::vector<MatrixXcd>& values, VectorXcd ComputedResponse::*member,
          std::vector<ComputedResponse>& responses) {
  std::size_t next = 0;
  for (const auto& set : values)
    for (const auto& column : set.colwise()) responses[next++].*member = column;
}

/// The line of the local maximum nearest to a frequency.
Index peak_line(const VectorXd& frequencies, const VectorXd& magnitudes, double frequency) {
  Index line = 0;
  (frequencies.array() - frequency).abs().minCoeff(&line);
  while (line + 1 < magnitudes.size() && magnitudes[line + 1] > magnitudes[line]) ++line;
  while (line > 0 && magnitudes[line - 1] > magnitudes[line]) --line;
  return line;
}

void add_peaks_and_difference(const VectorXd& frequencies, ComputedResponse& response) {
  const FrequencyResponse single{
      .lines = frequencies, .outputs = {{response.output, response.unit}}, .values = response.best()};
  const VectorXd magnitudes = response.best().cwiseAbs();
  std::vector<Index> lines;
  for (const auto& peak : find_peaks(single, {.least = least_peak})) {
    lines.push_back(peak_line(frequencies, magnitudes, peak.frequency));
    response.peaks.push_back({peak.frequency, peak.damping, magnitudes[lines.back()]});
  }
  if (response.full.size() > 0 && response.reduced.size() > 0)
    response.difference = difference_of(frequencies, response.full, response.reduced, lines);
}

}  // namespace

ResponseDifference difference_of(const VectorXd& frequencies, const VectorXcd& full, const VectorXcd& reduced,
                                 const std::vector<Index>& peak_lines) {
  const VectorXd magnitudes = full.cwiseAbs(), errors = (reduced - full).cwiseAbs();
  ResponseDifference difference;
  std::vector<bool> resonant(static_cast<std::size_t>(full.size()), false);
  for (const Index peak : peak_lines) {
    const double least = magnitudes[peak] / std::numbers::sqrt2;
    Index first = peak, last = peak;
    while (first > 0 && magnitudes[first - 1] >= least) --first;
    while (last + 1 < full.size() && magnitudes[last + 1] >= least) ++last;
    for (Index line = first; line <= last; ++line) resonant[static_cast<std::size_t>(line)] = true;
    const double largest = errors.segment(first, last - first + 1).maxCoeff() / magnitudes[peak];
    difference.at_resonances = std::max(difference.at_resonances.value_or(0.0), largest);
  }
  for (Index line = 0; line < full.size(); ++line) {
    if (resonant[static_cast<std::size_t>(line)] || magnitudes[line] == 0.0) continue;
    const double relative = errors[line] / magnitudes[line];
    if (difference.between && relative <= *difference.between) continue;
    difference.between = relative;
    difference.between_at = frequencies[line];
  }
  return difference;
}

FrequencyResponses frequency_responses(const FrequencyResponseProblem& problem, const Progress& progress) {
  FrequencyResponses found{.frequencies = problem.frequencies, .responses = without_values(problem.sets)};
  const bool both = problem.model == ResponseModel::both;
  if (problem.model != ResponseModel::reduced) {
    const Stopwatch watch;
    take(responses_of(*problem.full, problem, part_of(progress, 0.0, both ? 0.9 : 1.0)), &ComputedResponse::full,
         found.responses);
    found.full = {problem.full->size(), watch.seconds()};
  }
  if (problem.model != ResponseModel::full) {
    const Stopwatch watch;
    const LinearModel reduced = reduced_model(problem, found.warnings);
    take(responses_of(reduced, problem, part_of(progress, both ? 0.9 : 0.0, 1.0)), &ComputedResponse::reduced,
         found.responses);
    found.reduced = {reduced.size(), watch.seconds()};
  }
  for (auto& response : found.responses) add_peaks_and_difference(problem.frequencies, response);
  return found;
}

}  // namespace kalfem
