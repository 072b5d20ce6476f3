#include "kalfem/model/mesh/connectivity.hpp"

#include <algorithm>
#include <numeric>

namespace kalfem {
namespace {

/// Disjoint sets with path halving and union by size.
class DisjointSets {
public:
  explicit DisjointSets(Eigen::Index count) : parent_(static_cast<std::size_t>(count)), size_(parent_.size(), 1) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::size_t find(Eigen::Index item) {
    auto i = static_cast<std::size_t>(item);
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void join(Eigen::Index one, Eigen::Index other) {
    auto a = find(one), b = find(other);
    if (a == b) return;
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
  }

private:
  std::vector<std::size_t> parent_, size_;
};

/// Calls `touch(node)` for what belongs to the structure and `join(node, node)` for what holds together.
template <typename Touch, typename Join>
void visit_joints(const FiniteElementModel& model, const Touch& touch, const Join& join) {
  for (const auto& [region, property] : model.properties)
    for (const auto cell : model.mesh.regions.at(region)) {
      const auto nodes = model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]);
      for (const auto node : nodes) {
        touch(node);
        join(nodes.front(), node);
      }
    }
  for (const auto& mass : model.masses) touch(mass.node);
  for (const auto& spring : model.springs) {
    touch(spring.from.node);
    if (!spring.to) continue;
    touch(spring.to->node);
    join(spring.from.node, spring.to->node);
  }
  for (const auto& joint : model.joints)
    for (const auto& [dof, coefficient] : joint.deformation) {
      touch(dof.node);
      join(joint.deformation.front().first.node, dof.node);
    }
  for (const auto& item : model.matrices)
    for (const auto& dof : item.dofs) {
      touch(dof.node);
      join(item.dofs.front().node, dof.node);
    }
  for (const auto& link : model.weighted_links)
    for (const auto& share : link.shares) join(link.follower, share.node);
  for (const auto& link : model.links)
    for (const auto slave : link.slaves) join(link.master, slave);
  for (const auto& constraint : model.constraints)
    for (const auto& [dof, coefficient] : constraint.terms) join(constraint.terms.front().first.node, dof.node);
}

/// Name of a region with a property that holds the node, "" where there is none.
std::string region_at(const FiniteElementModel& model, Eigen::Index node) {
  for (const auto& [region, property] : model.properties)
    for (const auto cell : model.mesh.regions.at(region))
      if (std::ranges::count(model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]), node) > 0)
        return region;
  return "";
}

}  // namespace

std::vector<std::vector<Eigen::Index>> connected_parts(const FiniteElementModel& model) {
  const auto count = model.mesh.node_count();
  DisjointSets sets(count);
  std::vector<bool> touched(static_cast<std::size_t>(count), false);
  visit_joints(
      model, [&](Eigen::Index node) { touched[static_cast<std::size_t>(node)] = true; },
      [&](Eigen::Index one, Eigen::Index other) { sets.join(one, other); });
  constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::vector<std::size_t> part_of(static_cast<std::size_t>(count), none);
  std::vector<std::vector<Eigen::Index>> parts;
  for (Eigen::Index node = 0; node < count; ++node) {
    if (!touched[static_cast<std::size_t>(node)]) continue;
    auto& part = part_of[sets.find(node)];
    if (part == none) {
      part = parts.size();
      parts.emplace_back();
    }
    parts[part].push_back(node);
  }
  std::ranges::stable_sort(parts, std::greater{}, &std::vector<Eigen::Index>::size);
  return parts;
}

void require_connected(const FiniteElementModel& model) {
  constexpr std::size_t most_told = 20;
  const auto parts = connected_parts(model);
  if (parts.size() < 2) return;
  std::string text;
  for (std::size_t i = 0; i < std::min(parts.size(), most_told); ++i) {
    const auto& part = parts[i];
    const auto region = region_at(model, part.front());
    text += (i == 0 ? "" : ", ") + std::to_string(part.size()) + (part.size() == 1 ? " node" : " nodes") + " with n" +
            std::to_string(model.mesh.node_ids[static_cast<std::size_t>(part.front())]) +
            (region.empty() ? "" : " in region '" + region + "'");
  }
  if (parts.size() > most_told) text += ", ...";
  throw InvalidInput(Issue{{model.mesh.source, 0},
                           "the structure falls into " + std::to_string(parts.size()) + " parts: " + text,
                           "its parts do not move together",
                           "merge nodes that stand at one place, or join the parts by links, constraints or springs"});
}

}  // namespace kalfem
