// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/schematic_graph.hpp"

#include <algorithm>
#include <deque>
#include <map>
#include <numeric>
#include <set>

namespace kalfem {
namespace {

using Eigen::Index;

std::string qualified(const std::string& substructure, const std::string& name) {
  return name.starts_with(substructure + ".") ? name : substructure + "." + name;
}

/// Collects nodes and edges from the parts of a structure.
class GraphMaker {
public:
  GraphMaker(const StructureParts& parts, const std::vector<Sensor>& sensors, const SchematicOptions& options)
      : options_(options) {
    for (const auto& substructure : parts.substructures) find_small(substructure);
    for (const auto& substructure : parts.substructures)
      if (small_.contains(substructure.name)) add(substructure);
    for (const auto& connector : parts.connectors) add(connector);
    for (const auto& input : parts.inputs) add(input, parts);
    for (const auto& sensor : sensors) add(sensor);
  }

  SchematicGraph take() { return std::move(graph_); }

private:
  void find_small(const LumpedSubstructure& substructure) {
    const auto count = static_cast<Index>(dofs_of(substructure).size());
    if (count > 0 && count <= options_.most_masses) small_[substructure.name] = &substructure;
    for (const auto& ground : substructure.grounds) grounds_.insert(qualified(substructure.name, ground));
  }

  void add(const LumpedSubstructure& substructure) {
    for (const auto& dof : dofs_of(substructure)) node(qualified(substructure.name, dof));
    for (const auto& spring : substructure.springs)
      if (spring.stiffness != 0.0 || spring.damping != 0.0)
        edge(qualified(substructure.name, spring.from), qualified(substructure.name, spring.to),
             spring.damping == 0.0     ? SchematicEdgeKind::spring
             : spring.stiffness == 0.0 ? SchematicEdgeKind::dashpot
                                       : SchematicEdgeKind::spring_and_dashpot);
    const auto& [dofs, mass, damping, stiffness] = substructure.matrices;
    for (int column = 0; column < stiffness.outerSize(); ++column)
      for (SparseMatrix::InnerIterator it(stiffness, column); it; ++it)
        if (it.row() < it.col() && it.value() != 0.0)
          edge(qualified(substructure.name, dofs[static_cast<std::size_t>(it.row())]),
               qualified(substructure.name, dofs[static_cast<std::size_t>(it.col())]), SchematicEdgeKind::spring);
  }

  void add(const ConnectorDescription& connector) {
    const bool is_unknown = std::ranges::count(options_.unknown_connectors, connector.name) > 0;
    edge(connector.from, connector.to, SchematicEdgeKind::connector, connector.name, is_unknown);
    connectors_[connector.name] = graph_.edges.size() - 1;
  }

  void add(const InputDescription& input, const StructureParts& parts) {
    if (!input.target.empty()) return add_input(input.name, input.target);
    if (input.kind == InputKind::base_displacement) {
      for (const auto& [ground, weight] : input.direction)
        if (weight != 0.0) add_input(input.name, ground);
      return;
    }
    for (const auto& ground : ground_names(parts))
      if (is_drawn(ground)) add_input(input.name, ground);
  }

  /// At every symbol of a ground, or at the one node of another point.
  void add_input(const std::string& input, const std::string& point) {
    if (!is_drawn(point)) node(point);
    for (auto& each : graph_.nodes)
      if (each.name == point) each.inputs.push_back(input);
  }

  [[nodiscard]] bool is_drawn(const std::string& name) const {
    return std::ranges::find(graph_.nodes, name, &SchematicNode::name) != graph_.nodes.end();
  }

  void add(const Sensor& sensor) {
    for (const auto& [point, weight] : sensor.output.points) {
      if (weight == 0.0) continue;
      if (const auto found = connectors_.find(point); found != connectors_.end())
        graph_.edges[found->second].label += " [" + sensor.name + "]";
      else
        graph_.nodes[node(point)].sensors.push_back(sensor.name);
    }
  }

  /// The node of that name, made where there is none yet.
  std::size_t node(const std::string& name) {
    if (const auto found = nodes_.find(name); found != nodes_.end()) return found->second;
    const std::size_t index = graph_.nodes.size();
    nodes_[name] = index;
    graph_.nodes.push_back({name, kind_of(name)});
    if (graph_.nodes[index].kind == SchematicNodeKind::point) link(name, index);
    return index;
  }

  [[nodiscard]] SchematicNodeKind kind_of(const std::string& name) const {
    if (name == fixed_ground || grounds_.contains(name)) return SchematicNodeKind::ground;
    const auto* substructure = small(name);
    if (!substructure) return SchematicNodeKind::point;
    const auto own = name.substr(substructure->name.size() + 1);
    return substructure->points.contains(own) ? SchematicNodeKind::point : SchematicNodeKind::mass;
  }

  [[nodiscard]] const LumpedSubstructure* small(const std::string& name) const {
    const auto found = small_.find(name.substr(0, name.find('.')));
    return found == small_.end() ? nullptr : found->second;
  }

  /// A combination to the degrees of freedom that it combines, a point of a box to the box.
  void link(const std::string& name, std::size_t index) {
    if (const auto* substructure = small(name)) {
      for (const auto& [dof, weight] : substructure->points.at(name.substr(substructure->name.size() + 1)))
        if (weight != 0.0)
          graph_.edges.push_back({index, node(qualified(substructure->name, dof)), SchematicEdgeKind::link});
      return;
    }
    const std::string box = name.substr(0, name.find('.'));
    if (!nodes_.contains(box)) {
      nodes_[box] = graph_.nodes.size();
      graph_.nodes.push_back({box, SchematicNodeKind::box});
    }
    graph_.edges.push_back({index, nodes_[box], SchematicEdgeKind::link});
  }

  void edge(const std::string& from, const std::string& to, SchematicEdgeKind kind, const std::string& label = "",
            bool unknown = false) {
    const std::size_t first = end_node(from, to), second = end_node(to, from);
    graph_.edges.push_back({first, second, kind, label, unknown});
  }

  /// A ground has a symbol of its own below each node that stands on it.
  std::size_t end_node(const std::string& end, const std::string& other) {
    if (kind_of(end) != SchematicNodeKind::ground) return node(end);
    const auto [found, is_new] = nodes_.try_emplace(end + " below " + other, graph_.nodes.size());
    if (is_new) graph_.nodes.push_back({end, SchematicNodeKind::ground});
    return found->second;
  }

  const SchematicOptions& options_;
  std::map<std::string, const LumpedSubstructure*> small_;
  std::set<std::string> grounds_;
  std::map<std::string, std::size_t> nodes_, connectors_;
  SchematicGraph graph_;
};

/// Degrees of freedom of one substructure that are joined to nothing but points are the motion of one body: heave and
/// pitch of a car. The first takes the place of the others.
void join_rigid_bodies(SchematicGraph& graph) {
  std::vector<bool> only_points(graph.nodes.size(), true), linked(graph.nodes.size(), false);
  for (const auto& edge : graph.edges)
    for (const auto end : {edge.from, edge.to}) {
      linked[end] = true;
      if (edge.kind != SchematicEdgeKind::link) only_points[end] = false;
    }
  std::map<std::string, std::size_t> bodies;
  std::vector<std::size_t> place(graph.nodes.size());
  SchematicGraph joined;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    auto& node = graph.nodes[i];
    const auto dot = node.name.find('.');
    const bool of_body =
        node.kind == SchematicNodeKind::mass && only_points[i] && linked[i] && dot != std::string::npos;
    const auto [body, is_new] =
        of_body ? bodies.try_emplace(node.name.substr(0, dot), joined.nodes.size()) : std::pair(bodies.end(), true);
    if (is_new) {
      place[i] = joined.nodes.size();
      joined.nodes.push_back(std::move(node));
      continue;
    }
    place[i] = body->second;
    auto& first = joined.nodes[body->second];
    first.name += ", " + node.name.substr(dot + 1);
    first.sensors.insert(first.sensors.end(), node.sensors.begin(), node.sensors.end());
    first.inputs.insert(first.inputs.end(), node.inputs.begin(), node.inputs.end());
  }
  std::set<std::pair<std::size_t, std::size_t>> links;
  for (auto& edge : graph.edges) {
    edge.from = place[edge.from];
    edge.to = place[edge.to];
    if (edge.kind != SchematicEdgeKind::link || links.insert({edge.from, edge.to}).second)
      joined.edges.push_back(std::move(edge));
  }
  graph = std::move(joined);
}

/// How far bodies of several degrees of freedom reach over the points on them.
void set_spans(SchematicGraph& graph, const std::vector<std::vector<std::size_t>>& neighbours) {
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    auto& body = graph.nodes[i];
    if (body.kind != SchematicNodeKind::mass || body.name.find(", ") == std::string::npos) continue;
    for (const auto point : neighbours[i])
      body.span = std::max(body.span, 2.0 * std::abs(graph.nodes[point].position - body.position));
  }
}

std::vector<std::vector<std::size_t>> neighbours_of(const SchematicGraph& graph) {
  std::vector<std::vector<std::size_t>> neighbours(graph.nodes.size());
  for (const auto& edge : graph.edges) {
    neighbours[edge.from].push_back(edge.to);
    neighbours[edge.to].push_back(edge.from);
  }
  return neighbours;
}

/// Breadth first from all grounds; of what does not hang on one, from its first node.
void set_layers(SchematicGraph& graph, const std::vector<std::vector<std::size_t>>& neighbours) {
  std::vector<bool> reached(graph.nodes.size(), false);
  std::deque<std::size_t> waiting;
  const auto start = [&](std::size_t node, int layer) {
    reached[node] = true;
    graph.nodes[node].layer = layer;
    waiting.push_back(node);
  };
  const auto spread = [&] {
    for (; !waiting.empty(); waiting.pop_front())
      for (const auto next : neighbours[waiting.front()])
        if (!reached[next]) start(next, graph.nodes[waiting.front()].layer + 1);
  };
  for (std::size_t i = 0; i < graph.nodes.size(); ++i)
    if (graph.nodes[i].kind == SchematicNodeKind::ground) start(i, 0);
  spread();
  for (std::size_t i = 0; i < graph.nodes.size(); ++i)
    if (!reached[i]) start(i, 1), spread();
  for (const auto& node : graph.nodes) graph.layers = std::max(graph.layers, node.layer + 1);
}

/// The ascending places at least 1 apart that are nearest to the wanted ones in the mean square: neighbours that would
/// come too close stand side by side about their mean (pool adjacent violators).
std::vector<double> spaced(const std::vector<double>& wanted) {
  struct Block {
    double sum = 0.0;
    std::size_t count = 0;
    [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
  };
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    blocks.push_back({wanted[i] - static_cast<double>(i), 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].mean() > blocks.back().mean()) {
      const Block last = blocks.back();
      blocks.pop_back();
      blocks.back().sum += last.sum;
      blocks.back().count += last.count;
    }
  }
  std::vector<double> places;
  for (const auto& block : blocks)
    for (std::size_t k = 0; k < block.count; ++k) places.push_back(block.mean() + static_cast<double>(places.size()));
  return places;
}

/// Places in each layer: in the order of the neighbours' mean place, and as near to it as their distance allows.
void set_positions(SchematicGraph& graph, const std::vector<std::vector<std::size_t>>& neighbours) {
  std::vector<std::vector<std::size_t>> layers(static_cast<std::size_t>(graph.layers));
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    auto& layer = layers[static_cast<std::size_t>(graph.nodes[i].layer)];
    graph.nodes[i].position = static_cast<double>(layer.size());
    layer.push_back(i);
  }
  const auto wanted = [&](std::size_t i) {
    if (neighbours[i].empty()) return graph.nodes[i].position;
    double sum = 0.0;
    for (const auto next : neighbours[i]) sum += graph.nodes[next].position;
    return sum / static_cast<double>(neighbours[i].size());
  };
  constexpr int sweeps = 8;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (auto& layer : layers) {
      std::ranges::stable_sort(layer, {}, wanted);
      std::vector<double> places;
      for (const auto i : layer) places.push_back(wanted(i));
      places = spaced(places);
      for (std::size_t k = 0; k < layer.size(); ++k) graph.nodes[layer[k]].position = places[k];
    }
    std::ranges::reverse(layers);
  }
  if (graph.nodes.empty()) return;
  const auto [first, last] = std::ranges::minmax_element(graph.nodes, {}, &SchematicNode::position);
  const double left = first->position;
  graph.widest = last->position - left + 1.0;
  for (auto& node : graph.nodes) node.position -= left;
}

}  // namespace

SchematicGraph schematic_graph(const StructureParts& parts, const std::vector<Sensor>& sensors,
                               const SchematicOptions& options) {
  SchematicGraph graph = GraphMaker(parts, sensors, options).take();
  join_rigid_bodies(graph);
  const auto neighbours = neighbours_of(graph);
  set_layers(graph, neighbours);
  set_positions(graph, neighbours);
  set_spans(graph, neighbours);
  return graph;
}

}  // namespace kalfem
