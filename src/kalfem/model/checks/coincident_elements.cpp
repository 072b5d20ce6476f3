// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <tuple>

#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/checks/single_checks.hpp"

namespace kalfem {

// Cells are sorted by the kind of their property and by their nodes, whatever the order in which these are named. Equal
// neighbours coincide.
std::optional<ModelFinding> coincident_elements_finding(const FiniteElementModel& model) {
  struct Key {
    std::size_t kind;
    std::vector<Eigen::Index> nodes;
    Eigen::Index cell;
  };
  std::vector<Key> keys;
  for (const auto& [region, property] : model.properties) {
    const auto cells = model.mesh.regions.find(region);
    if (cells == model.mesh.regions.end()) continue;
    for (const auto index : cells->second) {
      const auto nodes = model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(index)]);
      keys.push_back({property.index(), {nodes.begin(), nodes.end()}, index});
      std::ranges::sort(keys.back().nodes);
    }
  }
  std::ranges::sort(keys, {}, [](const Key& key) { return std::tie(key.kind, key.nodes, key.cell); });
  ModelFinding finding{FindingSeverity::warning, FindingTopic::elements, "", "the stiffness and mass of both count",
                       "remove one of each unless both are meant"};
  std::vector<std::string> names;
  Eigen::Index count = 0;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const auto &one = keys[i - 1], &other = keys[i];
    if (one.cell == other.cell || one.kind != other.kind || one.nodes != other.nodes) continue;
    ++count;
    if (names.size() < report::most_named)
      names.push_back(report::cell_name(model.mesh, one.cell) + " and " + report::cell_name(model.mesh, other.cell));
    if (finding.nodes.size() < report::most_shown)
      finding.nodes.insert(finding.nodes.end(), other.nodes.begin(), other.nodes.end());
  }
  if (count == 0) return std::nullopt;
  finding.what = std::to_string(count) + (count == 1 ? " pair" : " pairs") +
                 " of elements have the same nodes: " + report::listed(names, count);
  return finding;
}

}  // namespace kalfem
