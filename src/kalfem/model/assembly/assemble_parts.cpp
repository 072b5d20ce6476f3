#include "kalfem/model/assembly/assemble_parts.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Positions = std::vector<Index>;  ///< of a part's degrees of freedom in the assembly
using Triplets = std::vector<Eigen::Triplet<double>>;

/// The names of the assembly, and where each part's degrees of freedom are in it.
struct Numbering {
  std::vector<std::string> names;
  std::unordered_map<std::string, Index> places;
  std::vector<Positions> of_part;
};

// One degree of freedom of a part may not stand twice: it would be joined with itself without a word.
Numbering numbered(const std::vector<const LinearModel*>& parts) {
  Numbering numbering;
  IssueList issues;
  for (const LinearModel* part : parts) {
    Positions places;
    std::vector<bool> met(numbering.names.size() + part->dofs.size(), false);
    for (const auto& name : part->dofs) {
      const auto [found, added] = numbering.places.emplace(name, static_cast<Index>(numbering.names.size()));
      if (added) numbering.names.push_back(name);
      if (met[static_cast<std::size_t>(found->second)])
        issues.add({}, "a part has the degree of freedom '" + name + "' twice", "names must be unique within a part");
      met[static_cast<std::size_t>(found->second)] = true;
      places.push_back(found->second);
    }
    numbering.of_part.push_back(std::move(places));
  }
  issues.raise();
  return numbering;
}

void add(const SparseMatrix& matrix, const Positions& places, Triplets& sum) {
  for (Index column = 0; column < matrix.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it)
      sum.emplace_back(places[static_cast<std::size_t>(it.row())], places[static_cast<std::size_t>(column)],
                       it.value());
}

SparseMatrix assembled(const std::vector<const LinearModel*>& parts, const Numbering& numbering,
                       SparseMatrix LinearModel::*matrix) {
  Triplets sum;
  for (std::size_t s = 0; s < parts.size(); ++s) add(parts[s]->*matrix, numbering.of_part[s], sum);
  const auto n = static_cast<Index>(numbering.names.size());
  SparseMatrix result(n, n);
  result.setFromTriplets(sum.begin(), sum.end());
  return result;
}

SparseMatrix damping_of_modes(const LinearModel& part) {
  const Index n = part.size();
  return damping_force(part.modal_damping, part.mass, Eigen::MatrixXd::Identity(n, n)).sparseView();
}

void add_modal_damping_of_parts(const std::vector<const LinearModel*>& parts, const Numbering& numbering,
                                LinearModel& joined) {
  Triplets sum;
  for (std::size_t s = 0; s < parts.size(); ++s)
    if (parts[s]->modal_damping.rates.size() > 0) add(damping_of_modes(*parts[s]), numbering.of_part[s], sum);
  if (sum.empty()) return;
  SparseMatrix damping(joined.size(), joined.size());
  damping.setFromTriplets(sum.begin(), sum.end());
  joined.damping += damping;
}

VectorXd placed(const VectorXd& values, const Positions& places, Index size) {
  VectorXd all = VectorXd::Zero(size);
  for (Index i = 0; i < values.size(); ++i) all[places[static_cast<std::size_t>(i)]] = values[i];
  return all;
}

std::vector<GroundCoupling> joined_grounds(const std::vector<const LinearModel*>& parts, const Numbering& numbering) {
  const auto n = static_cast<Index>(numbering.names.size());
  std::vector<GroundCoupling> grounds;
  for (std::size_t s = 0; s < parts.size(); ++s)
    for (const auto& [name, stiffness, damping] : parts[s]->grounds) {
      auto found = std::ranges::find(grounds, name, &GroundCoupling::ground);
      if (found == grounds.end()) found = grounds.insert(found, {name, VectorXd::Zero(n), VectorXd::Zero(n)});
      found->stiffness += placed(stiffness, numbering.of_part[s], n);
      found->damping += placed(damping, numbering.of_part[s], n);
    }
  return grounds;
}

std::map<std::string, DofCombination> joined_points(const std::vector<const LinearModel*>& parts,
                                                    const Numbering& numbering) {
  std::map<std::string, DofCombination> points;
  IssueList issues;
  for (const LinearModel* part : parts)
    for (const auto& [name, combination] : part->points) {
      if (numbering.places.contains(name) && std::ranges::find(part->dofs, name) == part->dofs.end())
        issues.add({}, "the point '" + name + "' has the name of a degree of freedom of another part",
                   "one name must mean one motion", "rename one of them");
      const auto [found, added] = points.emplace(name, combination);
      if (!added && found->second != combination)
        issues.add({}, "two parts have different points named '" + name + "'", "one name must mean one motion",
                   "rename one of them");
    }
  issues.raise();
  return points;
}

/// 1 where a part says nothing; the larger of two.
VectorXd joined_scale(const std::vector<const LinearModel*>& parts, const Numbering& numbering) {
  const bool some = std::ranges::any_of(parts, [](const auto* part) { return part->coordinate_scale.size() > 0; });
  if (!some) return {};
  VectorXd scale = VectorXd::Zero(static_cast<Index>(numbering.names.size()));
  for (std::size_t s = 0; s < parts.size(); ++s)
    for (Index i = 0; i < parts[s]->size(); ++i) {
      double& value = scale[numbering.of_part[s][static_cast<std::size_t>(i)]];
      value = std::max(value, parts[s]->coordinate_scale.size() > 0 ? parts[s]->coordinate_scale[i] : 1.0);
    }
  return scale;
}

void check_modal_damping(const std::vector<const LinearModel*>& parts, Index dense_damping_up_to) {
  for (const LinearModel* part : parts)
    if (part->modal_damping.rates.size() > 0 && part->size() > dense_damping_up_to)
      throw InvalidInput(
          "a part of " + std::to_string(part->size()) + " degrees of freedom that is joined has modal damping",
          "it would become a full matrix of the assembly",
          "apply modal damping to the assembly, or reduce the part first");
}

}  // namespace

// Names decide: each gets one place in the assembly, each part the positions of its own names. M, C, K are then sums of
// triplets at these positions, grounds sums of vectors.
LinearModel assemble_parts(const std::vector<const LinearModel*>& parts, Index dense_damping_up_to) {
  if (parts.empty())
    throw InvalidInput("there are no parts to assemble", "an assembly needs at least one part", "give its parts");
  if (parts.size() == 1) return *parts.front();
  check_modal_damping(parts, dense_damping_up_to);
  const Numbering numbering = numbered(parts);
  LinearModel joined;
  joined.dofs = numbering.names;
  joined.mass = assembled(parts, numbering, &LinearModel::mass);
  joined.damping = assembled(parts, numbering, &LinearModel::damping);
  joined.stiffness = assembled(parts, numbering, &LinearModel::stiffness);
  add_modal_damping_of_parts(parts, numbering, joined);
  joined.grounds = joined_grounds(parts, numbering);
  joined.points = joined_points(parts, numbering);
  joined.points_only = std::ranges::any_of(parts, [](const auto* part) { return part->points_only; });
  joined.coordinate_scale = joined_scale(parts, numbering);
  return joined;
}

}  // namespace kalfem
