// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/pictures/schematic.hpp"

namespace kalfem {

enum class SchematicNodeKind {
  mass,    ///< a degree of freedom, or those of a rigid body (heave and pitch) of which only points are used
  ground,  ///< fixed, or moved by an excitation
  point,   ///< a combination of degrees of freedom, or a point of a box
  box      ///< a whole substructure
};

struct SchematicNode {
  std::string name;
  SchematicNodeKind kind = SchematicNodeKind::mass;
  std::vector<std::string> sensors = {}, inputs = {};
  int layer = 0;          ///< edges from the nearest ground
  double position = 0.0;  ///< in its layer, from 0 on
  double span = 0.0;      ///< of a rigid body: places from its first point to its last
};

enum class SchematicEdgeKind { spring, dashpot, spring_and_dashpot, connector, link };

struct SchematicEdge {
  std::size_t from = 0, to = 0;  ///< nodes
  SchematicEdgeKind kind = SchematicEdgeKind::link;
  std::string label = {};
  bool unknown = false;  ///< what is looked for
};

/// The nodes with their places, and what joins them.
struct SchematicGraph {
  std::vector<SchematicNode> nodes;
  std::vector<SchematicEdge> edges;
  int layers = 0;
  double widest = 0.0;  ///< places side by side
};

/// Layers are distances to the nearest ground. In a layer nodes stand in the order of the mean place of their
/// neighbours, and as near to it as they can, which sweeps up and down through the layers improve (Sugiyama, Tagawa
/// and Toda 1981).
SchematicGraph schematic_graph(const StructureParts& parts, const std::vector<Sensor>& sensors,
                               const SchematicOptions& options);

}  // namespace kalfem
