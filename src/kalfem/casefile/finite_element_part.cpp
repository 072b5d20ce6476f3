#include "kalfem/casefile/finite_element_part.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/casefile/finite_element_builder.hpp"
#include "kalfem/model/connectivity.hpp"
#include "kalfem/model/mechanisms.hpp"
#include "kalfem/model/modal_damping.hpp"
#include "kalfem/reduction/free_interface.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
namespace d = description;

/// Sensors' bandwidth where there are none, or none with an upper limit [Hz].
constexpr double default_bandwidth = 100.0;

/// Names of the free degrees of freedom that a motion of the node in the directions means.
void add_boundary(const FiniteElementPart& part, Index node, const std::vector<int>& directions,
                  std::vector<std::string>& boundary) {
  for (const int direction : directions) {
    if (part.assembled.find({node, direction}) < 0) continue;
    const std::string name = dof_name(part.elements.mesh, {node, direction});
    if (std::ranges::find(boundary, name) == boundary.end()) boundary.push_back(name);
  }
}

/// "p1": the translations of the node; "p1.rx": that motion. Returns false where there is no such node.
bool add_place(const FiniteElementPart& part, const std::string& place, bool whole_node,
               std::vector<std::string>& boundary) {
  const auto dot = place.find('.');
  const auto found = std::ranges::find(part.nodes, place.substr(0, dot), &NamedNode::name);
  if (found == part.nodes.end()) return false;
  const int direction = dot == std::string::npos ? -1 : direction_index(place.substr(dot + 1));
  if (dot != std::string::npos && direction < 0) return false;
  if (direction < 0 || whole_node) add_boundary(part, found->node, {0, 1, 2}, boundary);
  if (direction >= 0) add_boundary(part, found->node, {direction}, boundary);
  return true;
}

/// Each attached node keeps its three translations: forces along one of them alone would leave the rest to move freely
/// in the fixed-interface modes.
std::vector<std::string> default_boundary(const FiniteElementPart& part, const d::Substructure& given,
                                          const std::vector<std::string>& attached) {
  std::vector<std::string> boundary;
  for (const auto& point : attached) {
    const auto weighted = std::ranges::find(given.points, point, &std::pair<std::string, Named<double>>::first);
    if (weighted == given.points.end())
      add_place(part, point, true, boundary);
    else
      for (const auto& [place, weight] : weighted->second) add_place(part, place, true, boundary);
  }
  return boundary;
}

std::vector<std::string> given_boundary(const FiniteElementPart& part, const d::Reduction& given) {
  std::vector<std::string> boundary, known;
  for (const auto& node : part.nodes) known.push_back(node.name);
  IssueList issues;
  for (const auto& place : given.boundary)
    if (!add_place(part, place.value, false, boundary))
      issues.add(place.location,
                 place.path + ": there is no node '" + place.value + "'" + did_you_mean(place.value, known),
                 "the boundary is made of named nodes", "name one of `nodes`, or node.direction");
  issues.raise();
  return boundary;
}

void add_weighted_points(const d::Substructure& given, LinearModel& model) {
  for (const auto& [point, weights] : given.points) {
    DofCombination sum;
    for (const auto& [place, weight] : weights) {
      const auto found = model.points.find(place);
      if (found == model.points.end())
        throw InvalidInput("point '" + point + "' uses '" + place + "', which is no motion of a named node",
                           "a point is a weighted sum of node.direction", "name the node under `nodes`");
      for (const auto& [dof, coefficient] : found->second) sum[dof] += weight * coefficient;
    }
    model.points[point] = sum;
  }
}

void require_no_mechanism(const FiniteElementModel& elements, const AssembledModel& assembled) {
  const auto free = find_mechanisms(elements, assembled);
  if (free.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(free.size(), 10); ++i) names += (i == 0 ? "" : ", ") + free[i];
  throw InvalidInput("substructure '" + elements.name + "' is a mechanism: it moves without strain at " + names +
                         (free.size() > 10 ? " and " + std::to_string(free.size() - 10) + " more" : ""),
                     "its motion there is not determined", "hold or join these degrees of freedom");
}

/// A mass-normalised mode of a body of mass m moves a typical point by 1 / sqrt(m).
Superelement completed(const FiniteElementPart& part, Superelement superelement) {
  auto& model = superelement.model;
  const auto boundary = static_cast<Index>(superelement.boundary.size());
  model.points_only = true;
  model.coordinate_scale = Eigen::VectorXd::Ones(model.size());
  model.coordinate_scale.tail(model.size() - boundary).setConstant(std::sqrt(part.mass.mass));
  return superelement;
}

Superelement reduce_by(d::ReductionMethod method, const LinearModel& full, const std::vector<std::string>& boundary,
                       const ReductionOptions& options) {
  switch (method) {
    case d::ReductionMethod::guyan:
      return guyan(full, boundary, options);
    case d::ReductionMethod::rubin:
      return free_interface(full, boundary, {.kind = FreeInterfaceKind::rubin, .modes = options.modes});
    case d::ReductionMethod::macneal:
      return free_interface(full, boundary, {.kind = FreeInterfaceKind::macneal, .modes = options.modes});
    case d::ReductionMethod::craig_bampton:
      break;
  }
  return craig_bampton(full, boundary, options);
}

}  // namespace

FiniteElementPart make_finite_element_part(const std::string& name, const d::Substructure& given,
                                           const std::vector<std::string>& attached,
                                           const std::vector<std::string>& parameters) {
  FiniteElementPart part;
  part.name = name;
  auto [elements, nodes, notes] = build_finite_elements(name, given);
  part.elements = std::move(elements);
  part.nodes = std::move(nodes);
  part.notes = std::move(notes);
  try {
    require_connected(part.elements);
    part.assembled = assemble(part.elements, {.parameters = {parameters.begin(), parameters.end()}});
    if (!part.elements.mesh.cells.empty()) require_no_mechanism(part.elements, part.assembled);
    part.mass = mass_properties(part.elements, part.assembled);
    part.full = linear_model(part.elements, part.assembled, part.nodes,
                             {given.damping.mass_factor, given.damping.stiffness_factor});
    part.full.points_only = true;
    add_weighted_points(given, part.full);
    if (!given.damping.modal.empty())
      add_modal_damping(part.full, given.damping.modal, {.up_to = given.damping.modal_up_to});
  } catch (const InvalidInput& error) {
    IssueList issues;
    issues.add(error, given.finite_elements->location());
    issues.raise();
  }
  part.boundary = given.reduction && !given.reduction->boundary.empty() ? given_boundary(part, *given.reduction)
                                                                        : default_boundary(part, given, attached);
  return part;
}

Superelement reduce(const FiniteElementPart& part, const std::optional<d::Reduction>& given, double sensor_bandwidth) {
  const d::Reduction reduction = given.value_or(d::Reduction{});
  ReductionOptions options;
  options.modes.count = reduction.modes;
  options.modes.cutoff = reduction.up_to;
  options.modes.effective_mass = reduction.effective_mass;
  options.truncation_vectors = reduction.truncation_vectors;
  if (!reduction.modes && !reduction.up_to && !reduction.effective_mass)
    options.modes.cutoff = 3.0 * (std::isfinite(sensor_bandwidth) ? sensor_bandwidth : default_bandwidth);
  return completed(part, reduce_by(reduction.method, part.full, part.boundary, options));
}

Superelement reduce_again(const FiniteElementPart& part, const LinearModel& full,
                          const std::optional<d::Reduction>& given, const ReductionEvidence& first) {
  const d::Reduction reduction = given.value_or(d::Reduction{});
  return completed(part, reduce_by(reduction.method, full, part.boundary,
                                   {.modes = {.count = first.interface_frequencies.size()},
                                    .truncation_vectors = reduction.truncation_vectors,
                                    .order = first.order,
                                    .evidence = false}));
}

Superelement reduce_up_to(const FiniteElementPart& part, double frequency) {
  return completed(part,
                   craig_bampton(part.full, part.boundary,
                                 {.modes = {.cutoff = frequency}, .truncation_vectors = true, .evidence = false}));
}

}  // namespace kalfem
