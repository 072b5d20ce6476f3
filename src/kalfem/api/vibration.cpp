// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/vibration.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/model/fixed_model.hpp"
#include "kalfem/system/linearised.hpp"
#include "kalfem/updating/frf_model.hpp"
#include "kalfem/vibration/frequency_responses.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index most_modes = 1000;  ///< that are computed without being counted

Index counted(Index count, Index size) {
  if (count < 0)
    throw InvalidInput("count: " + std::to_string(count), "a number of modes is at least 1", "0 gives all of them");
  if (count == 0 && size > most_modes)
    throw InvalidInput("count: all modes of " + std::to_string(size) + " degrees of freedom are asked for",
                       "up to " + std::to_string(most_modes) + " are computed without being counted",
                       "say how many modes you want");
  return count == 0 ? size : std::min(count, size);
}

StructureModes modes_of(const LinearModel& model, Index count) {
  const Index with_mass = (model.mass.diagonal().array() > 0.0).count();  // others have no mode of their own
  const Index wanted = std::min(counted(count, model.size()), with_mass);
  const NormalModes modes =
      wanted == model.size() ? normal_modes(model.mass, model.stiffness) : lowest_normal_modes(model, {wanted});
  StructureModes found{.dofs = model.dofs, .frequencies = modes.frequencies, .damping = {}, .shapes = modes.shapes};
  found.damping = VectorXd::Zero(modes.frequencies.size());
  for (Index i = 0; i < found.damping.size(); ++i) {
    if (found.frequencies[i] == 0.0) continue;
    const VectorXd shape = modes.shapes.col(i);
    const VectorXd force = model.damping * shape + VectorXd(damping_force(model.modal_damping, model.mass, shape));
    found.damping[i] = shape.dot(force) / (4.0 * std::numbers::pi * found.frequencies[i]);
  }
  return found;
}

CoupledModel coupled(const Structure& structure) {
  const auto model = make_structure_model(structure.description());
  StructureParts parts = model->parts;
  parts.finite_elements = model->reduced_parts();
  return couple(parts);
}

std::string point_of(const OutputDescription& output) {
  const bool single = output.points.size() == 1 && output.points.begin()->second == 1.0;
  if (!single || output.relative_to_base)
    throw InvalidInput("output '" + output.name + "' is not the motion of one point or the strain of one gauge",
                       "frequency responses are of absolute motions and of strains", "ask for each by itself");
  return output.points.begin()->first;
}

ResponseQuantity quantity_of(const OutputDescription& output) {
  switch (output.quantity) {
    case ObservedQuantity::displacement:
      return ResponseQuantity::displacement;
    case ObservedQuantity::velocity:
      return ResponseQuantity::velocity;
    case ObservedQuantity::acceleration:
      return ResponseQuantity::acceleration;
    case ObservedQuantity::strain:
      return ResponseQuantity::strain;
    default:
      throw InvalidInput("output '" + point_of(output) + "' is of a connector",
                         "frequency responses are motions of points", "ask for the motion of its ends");
  }
}

/// The input of the sets: a ground that moves or a place where a force acts.
std::pair<FrfInput, std::string> place_of(const std::string& input, const Structure& structure) {
  const auto& inputs = structure.description().parts.inputs;
  const auto found = std::ranges::find(inputs, input, &InputDescription::name);
  if (found == inputs.end()) return {FrfInput::force, input};
  if (found->kind == InputKind::base_acceleration)
    throw InvalidInput("input '" + input + "' accelerates all grounds alike",
                       "frequency responses are per force or per displacement of a ground",
                       "describe it by base_displacement");
  if (found->kind == InputKind::force) return {FrfInput::force, found->target};
  return {FrfInput::ground_displacement, input};
}

void require_lines(const VectorXd& frequencies) {
  if (frequencies.size() == 0 || !frequencies.allFinite() || (frequencies.array() < 0.0).any())
    throw InvalidInput("frequencies: there are none, or one is negative or not finite", "they are in Hz, >= 0", "");
}

/// Adds the issues of an error, each with the place of its argument.
void add(const InvalidInput& error, const std::string& place, IssueList& issues) {
  for (const auto& issue : error.issues()) issues.add({}, place + issue.what, issue.why, issue.fix);
}

/// One set for each input and output, in the order of the result.
std::vector<FrfSet> sets_of(const Structure& structure, const FrequencyResponseOptions& options, IssueList& issues) {
  std::vector<FrfSet> sets;
  if (options.inputs.empty()) issues.add({}, "inputs: the list is empty", "", "give at least one");
  if (options.outputs.empty()) issues.add({}, "outputs: the list is empty", "", "give at least one");
  std::vector<FrfSet> of_outputs;
  for (std::size_t i = 0; i < options.outputs.size(); ++i) try {
      const auto& output = options.outputs[i];
      of_outputs.push_back({.outputs = {point_of(output)}, .quantity = quantity_of(output)});
    } catch (const InvalidInput& error) {
      add(error, "outputs[" + std::to_string(i) + "]: ", issues);
    }
  for (std::size_t i = 0; i < options.inputs.size(); ++i) try {
      const auto [kind, place] = place_of(options.inputs[i], structure);
      for (FrfSet set : of_outputs) {
        set.input = kind;
        set.place = place;
        sets.push_back(std::move(set));
      }
    } catch (const InvalidInput& error) {
      add(error, "inputs[" + std::to_string(i) + "]: ", issues);
    }
  return sets;
}

void check_reductions(const StructureModel& model, IssueList& issues) {
  if (model.finite_elements.empty())
    issues.add({}, "model: there are no finite elements to reduce", "full and reduced model are the same",
               "ask for ResponseModel::full");
  for (const auto& elements : model.finite_elements)
    if (!elements.reduced)
      issues.add({}, "model: '" + elements.part->name + "' is not to be reduced", "a reduced model is asked for",
                 "call reduce() of the finite elements");
}

}  // namespace

StructureModes modes(const Structure& structure, Index count) {
  return modes_of(linearised_at_rest(coupled(structure)), count);
}

StructureModes modes_of(const Structure& structure, const std::string& substructure, Index count) {
  const CoupledModel model = coupled(structure);
  return modes_of(*model.find_substructure(substructure).part.model, count);
}

Eigen::MatrixXcd frequency_responses(const Structure& structure, const VectorXd& frequencies, const std::string& input,
                                     const std::vector<OutputDescription>& outputs) {
  require_lines(frequencies);
  const auto [kind, place] = place_of(input, structure);
  std::vector<FrfSet> sets;
  for (const auto& output : outputs) {
    const auto quantity = quantity_of(output);
    sets.push_back({.input = kind, .place = place, .outputs = {point_of(output)}, .quantity = quantity});
  }
  const auto model = std::make_shared<const FixedModel>(linearised_at_rest(coupled(structure)));
  const FrfEvaluation evaluation =
      FrfModel(model, sets, frequencies.maxCoeff(), VectorXd()).evaluate(VectorXd(), false);
  Eigen::MatrixXcd values(frequencies.size(), std::ssize(outputs));
  for (Index i = 0; i < frequencies.size(); ++i) {
    const std::complex<double> s(0.0, 2.0 * std::numbers::pi * frequencies[i]);
    if (evaluation.is_singular(s)) throw singular_at(frequencies[i]);
    for (std::size_t j = 0; j < outputs.size(); ++j) values(i, static_cast<Index>(j)) = evaluation.at(j, s).values[0];
  }
  return values;
}

FrequencyResponses frequency_responses(const Structure& structure, const FrequencyResponseOptions& options) {
  IssueList issues;
  const auto& lines = options.frequencies;
  try {
    require_lines(lines);
  } catch (const InvalidInput& error) {
    add(error, "", issues);
  }
  if (lines.size() > 1 && !(lines.tail(lines.size() - 1).array() > lines.head(lines.size() - 1).array()).all())
    issues.add({}, "frequencies: they do not ascend", "peaks are found between neighbours", "sort them");
  FrequencyResponseProblem problem{.frequencies = lines,
                                   .sets = sets_of(structure, options, issues),
                                   .model = options.model,
                                   .method = options.method,
                                   .parts = {},
                                   .finite_elements = {},
                                   .full = {}};
  const auto model = make_structure_model(structure.description());
  if (options.model != ResponseModel::full) check_reductions(*model, issues);
  problem.finite_elements = model->finite_elements;
  problem.parts = model->parts;
  problem.parts.finite_elements.clear();
  for (const auto& elements : model->finite_elements)
    problem.parts.finite_elements.push_back(
        {elements.part->name, std::shared_ptr<const LinearModel>(elements.part, &elements.part->full)});
  problem.full = std::make_shared<const LinearModel>(linearised_at_rest(couple(problem.parts)));
  for (const auto& set : problem.sets) places_of(set, *problem.full, issues);
  issues.raise();
  return frequency_responses(problem, options.progress);
}

}  // namespace kalfem
