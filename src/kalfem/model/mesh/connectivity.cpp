// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/mesh/connectivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

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

// Union-find over everything that joins nodes: the work is practically linear in the size of the model. Parts are then
// collected in the order of their lowest node and sorted by size.
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

bool has_loose_parts(const FiniteElementModel& model, const std::vector<std::vector<Eigen::Index>>& parts,
                     const std::vector<Eigen::Index>& joined) {
  std::vector<bool> held(static_cast<std::size_t>(model.mesh.node_count()), false);
  const auto hold = [&](Eigen::Index node) { held[static_cast<std::size_t>(node)] = true; };
  std::ranges::for_each(joined, hold);
  for (const auto& support : model.fixed) std::ranges::for_each(support.nodes, hold);
  for (const auto& spring : model.springs)
    if (!spring.to) hold(spring.from.node);
  for (const auto& constraint : model.constraints) {
    if (constraint.terms.empty()) continue;
    const auto first = constraint.terms.front().first.node;
    if (std::ranges::all_of(constraint.terms, [&](const auto& term) { return term.first.node == first; })) hold(first);
  }
  const auto is_loose = [&](const std::vector<Eigen::Index>& part) {
    return std::ranges::none_of(part, [&](Eigen::Index node) { return held[static_cast<std::size_t>(node)]; });
  };
  return parts.size() > 1 && std::ranges::any_of(parts, is_loose);
}

bool require_connected(const FiniteElementModel& model, const std::vector<Eigen::Index>& joined) {
  constexpr std::size_t most_told = 20;
  const auto parts = connected_parts(model);
  if (!has_loose_parts(model, parts, joined)) return has_loose_parts(model, parts, {});
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
                           "the structure consists of " + std::to_string(parts.size()) + " unconnected parts: " + text,
                           "its parts move independently",
                           "merge coincident nodes, hold each part, or connect the parts by links, constraints or "
                           "springs, or by connectors of a case"});
}

namespace {

using Eigen::Index;
using Box = std::array<std::int64_t, 3>;

struct BoxHash {
  std::size_t operator()(const Box& box) const {
    std::uint64_t hash = 0;
    for (const auto number : box) {  // the finaliser of a 64-bit mixing hash, so that neighbours spread
      hash ^= static_cast<std::uint64_t>(number) + 0x9e3779b97f4a7c15ULL + (hash << 6U) + (hash >> 2U);
      hash = (hash ^ (hash >> 30U)) * 0xbf58476d1ce4e5b9ULL;
      hash ^= hash >> 27U;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// Boxes are four tolerances wide, so that most places lie near none of their sides.
constexpr double box_widths = 4.0;

}  // namespace

// Nodes are hashed into boxes four tolerances wide. A node looks into the boxes that its ball touches, mostly one and
// at most eight, for nodes met before; so each pair is found once and the work grows with the number of nodes. The cap
// on partners keeps a model with thousands of nodes at one place from growing quadratically.
std::vector<std::pair<Index, Index>> coincident_nodes(const Eigen::Matrix3Xd& places, const std::vector<bool>& marked,
                                                      double tolerance, int most_partners) {
  std::vector<std::pair<Index, Index>> pairs;
  if (places.cols() == 0 || !(tolerance > 0.0)) return pairs;
  const Eigen::Vector3d origin = places.rowwise().minCoeff();
  const double width = box_widths * tolerance;
  std::unordered_map<Box, Index, BoxHash> newest;  // in a box; each leads to the one before it
  newest.reserve(static_cast<std::size_t>(places.cols()));
  std::vector<Index> before(static_cast<std::size_t>(places.cols()), -1);
  const auto box_of = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d scaled = (place - origin) / width;
    return Box{static_cast<std::int64_t>(std::floor(scaled[0])), static_cast<std::int64_t>(std::floor(scaled[1])),
               static_cast<std::int64_t>(std::floor(scaled[2]))};
  };
  for (Index node = 0; node < places.cols(); ++node) {
    if (!marked[static_cast<std::size_t>(node)]) continue;
    const Eigen::Vector3d place = places.col(node), reach = Eigen::Vector3d::Constant(tolerance);
    const Box low = box_of(place - reach), high = box_of(place + reach);
    int partners = 0;
    for (auto x = low[0]; x <= high[0]; ++x)
      for (auto y = low[1]; y <= high[1]; ++y)
        for (auto z = low[2]; z <= high[2]; ++z) {
          const auto found = newest.find({x, y, z});
          if (found == newest.end()) continue;
          for (Index other = found->second; other >= 0 && partners < most_partners;
               other = before[static_cast<std::size_t>(other)])
            if ((places.col(other) - place).norm() <= tolerance) {
              pairs.emplace_back(other, node);
              ++partners;
            }
        }
    const auto [entry, is_new] = newest.try_emplace(box_of(place), node);
    if (!is_new) before[static_cast<std::size_t>(node)] = std::exchange(entry->second, node);
  }
  std::ranges::sort(pairs);
  return pairs;
}

// Each node in question lists the items that name it, in ascending order; two lists that share an item are joined by
// it.
std::vector<bool> directly_joined(const FiniteElementModel& model, const std::vector<std::pair<Index, Index>>& pairs) {
  std::unordered_map<Index, std::vector<std::size_t>> items_at;  // of the nodes in question only
  for (const auto& [one, other] : pairs) items_at[one], items_at[other];
  std::size_t item = 0;
  visit_items(model, [&](std::span<const Index> nodes) {
    for (const auto node : nodes)
      if (const auto place = items_at.find(node); place != items_at.end()) place->second.push_back(item);
    ++item;
  });
  std::vector<bool> joined;
  for (const auto& [one, other] : pairs) {
    const auto &first = items_at[one], &second = items_at[other];  // ascending
    auto a = first.begin(), b = second.begin();
    while (a != first.end() && b != second.end() && *a != *b) ++(*a < *b ? a : b);
    joined.push_back(a != first.end() && b != second.end());
  }
  return joined;
}

}  // namespace kalfem
