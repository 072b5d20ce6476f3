// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/joints.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <tuple>

#include "kalfem/study/node_groups.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
namespace d = description;

/// "left" and "seam" of "left.seam".
std::pair<std::string, std::string> split(const std::string& qualified) {
  const auto dot = qualified.find('.');
  if (dot == std::string::npos) return {qualified, ""};
  return {qualified.substr(0, dot), qualified.substr(dot + 1)};
}

std::string metres(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g m", length);
  return text;
}

/// What a node can do in a direction.
enum class Mobility { free, held, follows_others, absent };

bool moves(Mobility mobility) { return mobility == Mobility::free || mobility == Mobility::follows_others; }

/// One side of a joint: nodes of a substructure.
class Side {
public:
  Side(const FiniteElementPart& part_, const Name& name_)
      : part(part_),
        name(name_),
        nodes(nodes_of_group(part_, split(name_.value).second)),
        rows_(part_.assembled.expansion) {}

  [[nodiscard]] auto place(Index node) const { return part.elements.mesh.nodes.col(node); }
  [[nodiscard]] std::string title_of(Index node) const {
    return "node " + std::to_string(part.elements.mesh.node_ids[static_cast<std::size_t>(node)]);
  }
  [[nodiscard]] std::string qualified(const NodalDof& dof) const {
    return part.name + "." + dof_name(part.elements.mesh, dof);
  }
  [[nodiscard]] Mobility mobility(const NodalDof& dof) const {
    if (part.assembled.find(dof) >= 0) return Mobility::free;
    if (is_held(part.elements, dof)) return Mobility::held;
    return rows_.innerVector(6 * dof.node + dof.direction).nonZeros() > 0 ? Mobility::follows_others : Mobility::absent;
  }

  const FiniteElementPart& part;
  const Name& name;
  std::vector<Index> nodes;

private:
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows_;  ///< motion of each nodal degree of freedom by the free ones
};

/// Joins the nodes of two sides.
class Joiner {
public:
  Joiner(const Side& first, const Side& second, std::optional<double> tolerance)
      : first_(first), second_(second), tolerance_(tolerance.value_or(default_tolerance())) {}

  /// Finds the partner of each node; false, with an issue, where one has none.
  bool pair(IssueList& issues) {
    std::vector<Index> back;
    return find_partners(first_, second_, partners_, issues) && find_partners(second_, first_, back, issues);
  }

  /// Nodes of the second side, in the order of the first one's.
  [[nodiscard]] const std::vector<Index>& partners() const { return partners_; }

  std::vector<SharedDof> share(std::vector<std::string>& warnings, IssueList& issues) {
    warn_of_gap(warnings);
    std::vector<SharedDof> shared;
    for (std::size_t i = 0; i < partners_.size(); ++i)
      for (int direction = 0; direction < 6; ++direction) {
        const NodalDof one{first_.nodes[i], direction}, other{partners_[i], direction};
        const Mobility of_one = first_.mobility(one), of_other = second_.mobility(other);
        if (of_one == Mobility::free && of_other == Mobility::free)
          shared.push_back({first_.qualified(one), second_.qualified(other)});
        else if (moves(of_one) || moves(of_other))
          note_difference(one, of_one, of_other, issues);
      }
    warn_of_rotations(warnings);
    return shared;
  }

private:
  [[nodiscard]] double element_size() const {
    const auto sizes = element_sizes(first_.part.elements.mesh, first_.nodes);
    return *std::ranges::min_element(sizes);
  }
  [[nodiscard]] double default_tolerance() const { return 1e-3 * element_size(); }

  void warn_of_gap(std::vector<std::string>& warnings) const {
    constexpr double visible = 0.01;  // of an element
    double gap = 0.0;
    for (std::size_t i = 0; i < partners_.size(); ++i)
      gap = std::max(gap, (second_.place(partners_[i]) - first_.place(first_.nodes[i])).norm());
    if (gap > visible * element_size())
      warnings.push_back("the joint of '" + first_.name.value + "' and '" + second_.name.value +
                         "' unites nodes up to " + metres(gap) +
                         " apart: a turn of the whole structure strains it there");
  }

  /// The nearest node of `other` to each node of `side`.
  bool find_partners(const Side& side, const Side& other, std::vector<Index>& partners, IssueList& issues) const {
    std::size_t unpaired = 0;
    Index lonely = -1;
    double gap = 0.0;
    for (const Index node : side.nodes) {
      const auto distance = [&](Index candidate) { return (other.place(candidate) - side.place(node)).norm(); };
      const Index nearest = *std::ranges::min_element(other.nodes, {}, distance);
      partners.push_back(nearest);
      if (distance(nearest) <= tolerance_) continue;
      if (unpaired++ == 0 || distance(nearest) < gap) {
        lonely = node;
        gap = distance(nearest);
      }
    }
    if (unpaired > 0)
      issues.add(side.name.location,
                 side.name.path + ": " + std::to_string(unpaired) + " of the " + std::to_string(side.nodes.size()) +
                     " nodes of '" + side.name.value + "' have no partner in '" + other.name.value +
                     "'; the nearest to one is " + metres(gap) + " from " + side.title_of(lonely),
                 "nodes are joined that lie within " + metres(tolerance_) + " of each other",
                 "mesh both sides alike, correct the units, or state a larger `tolerance`");
    else if (auto found = partners; std::ranges::sort(found), std::ranges::adjacent_find(found) != found.end())
      issues.add(side.name.location,
                 side.name.path + ": two nodes of '" + side.name.value + "' lie within " + metres(tolerance_) + " of " +
                     other.title_of(*std::ranges::adjacent_find(found)) + " of '" + other.name.value + "'",
                 "each node has one partner", "merge nodes of the group, or state a smaller `tolerance`");
    else
      return true;
    return false;
  }

  void note_difference(const NodalDof& one, Mobility of_one, Mobility of_other, IssueList& issues) {
    const bool first_differs = of_one != Mobility::free;
    const Mobility worse = first_differs ? of_one : of_other;
    if (one.direction >= 3 && (of_one == Mobility::absent || of_other == Mobility::absent)) {
      ++single_rotations_;
      return;
    }
    if (refused_) return;  // one message tells of all nodes of the joint
    refused_ = true;
    const Side& side = first_differs ? first_ : second_;
    const char* reason = worse == Mobility::held ? "a support holds it there"
                         : worse == Mobility::follows_others
                             ? "a link or constraint lets it follow other nodes"
                             : "no element, spring or mass touches it, or what it follows is held";
    issues.add(first_.name.location,
               first_.name.path + ": " + first_.title_of(one.node) + " of '" + first_.name.value +
                   "' and its partner cannot move alike along " +
                   direction_names[static_cast<std::size_t>(one.direction)],
               "in '" + side.part.name + "' " + reason, "treat the node alike in both substructures");
  }

  void warn_of_rotations(std::vector<std::string>& warnings) const {
    if (single_rotations_ > 0)
      warnings.push_back("the joint of '" + first_.name.value + "' and '" + second_.name.value + "' leaves " +
                         std::to_string(single_rotations_) +
                         " rotations free that only one of two partners has: there it joins translations only");
  }

  const Side &first_, &second_;
  double tolerance_;
  std::vector<Index> partners_;  ///< of the first side's nodes
  std::size_t single_rotations_ = 0;
  bool refused_ = false;
};

/// What joints have joined so far, so that no two of them contradict or repeat each other.
class JoinedNodes {
public:
  /// Notes the partners of a joint; false, with an issue, where another joint gives a node another partner of the same
  /// substructure, or joins all of these nodes already.
  bool add(const std::string& joint, const Side& one, const Side& other, const std::vector<Index>& partners,
           IssueList& issues) {
    std::size_t known = 0;
    const Partner* last = nullptr;
    for (std::size_t i = 0; i < partners.size(); ++i)
      for (const auto& [side, node, facing, partner] :
           {std::tuple(&one, one.nodes[i], &other, partners[i]), std::tuple(&other, partners[i], &one, one.nodes[i])}) {
        const auto [place, is_new] =
            partners_.try_emplace({side->part.name, node, facing->part.name}, Partner{partner, joint});
        if (is_new) continue;
        last = &place->second;
        if (last->node != partner) {
          issues.add(one.name.location,
                     "joints." + joint + ": " + side->title_of(node) + " of '" + side->part.name +
                         "' would be joined to " + facing->title_of(partner) + " of '" + facing->part.name +
                         "', and joint '" + last->joint + "' joins it to " + facing->title_of(last->node),
                     "both nodes would become one",
                     "state a smaller `tolerance`, or remove the node from one of the groups");
          return false;
        }
        ++known;
      }
    if (known < 2 * partners.size()) return true;
    issues.add(one.name.location, "joints." + joint + ": joint '" + last->joint + "' joins these nodes already",
               "it would have no effect", "remove one of the two");
    return false;
  }

private:
  struct Partner {
    Index node;
    std::string joint;
  };
  std::map<std::tuple<std::string, Index, std::string>, Partner> partners_;  ///< by node and the other substructure
};

/// The substructure of one end of a joint; null, with an issue, where it is none with finite elements.
const d::Substructure* find_substructure(const d::Case& given, const Name& end, IssueList& issues) {
  const std::string wanted = split(end.value).first;
  std::vector<std::string> known;
  for (const auto& [name, part] : given.substructures) {
    if (!part.finite_elements) continue;
    if (name == wanted) return &part;
    known.push_back(name);
  }
  issues.add(end.location,
             end.path + ": there is no finite-element substructure '" + wanted + "'" + did_you_mean(wanted, known),
             "joints connect nodes of meshes", "write substructure.group");
  return nullptr;
}

const FiniteElementPart& part_of(const StructureModel& structure, const Name& end) {
  const std::string wanted = split(end.value).first;
  return *std::ranges::find_if(structure.finite_elements, [&](const auto& each) {
            return each.part->name == wanted;
          })->part;
}

}  // namespace

std::vector<Name> joined_groups(const d::Case& given, const std::string& substructure) {
  std::vector<Name> groups;
  for (const auto& [name, joint] : given.joints)
    for (const auto& end : joint.between)
      if (const auto [owner, group] = split(end.value); owner == substructure)
        groups.push_back({group, end.location, end.path});
  return groups;
}

void check_joints(const d::Case& given, IssueList& issues) {
  for (const auto& [name, joint] : given.joints) {
    for (const auto& end : joint.between)
      if (const auto* part = find_substructure(given, end, issues); part && !part->damping.modal.empty())
        issues.add(end.location,
                   end.path + ": the joined substructure '" + split(end.value).first + "' has modal damping",
                   "its modes by itself are none of the joined structure",
                   "give `damping: {modal: ...}` for the whole structure, or Rayleigh damping");
    const auto& [one, other] = joint.between;
    if (split(one.value).first == split(other.value).first)
      issues.add(other.location, other.path + ": both groups belong to substructure '" + split(other.value).first + "'",
                 "a joint connects two substructures", "join nodes of one mesh by `links`");
  }
}

std::vector<SharedDof> make_joints(const d::Case& given, const StructureModel& structure,
                                   std::vector<std::string>& warnings, IssueList& issues) {
  std::vector<SharedDof> all;
  JoinedNodes joined;
  for (const auto& [name, joint] : given.joints) {
    const auto& [one, other] = joint.between;
    const Side from(part_of(structure, one), one), to(part_of(structure, other), other);
    Joiner joiner(from, to, joint.tolerance);
    if (!joiner.pair(issues) || !joined.add(name, from, to, joiner.partners(), issues)) continue;
    const auto shared = joiner.share(warnings, issues);
    all.insert(all.end(), shared.begin(), shared.end());
  }
  return all;
}

}  // namespace kalfem
