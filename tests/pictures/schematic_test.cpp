// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/schematic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kalfem/pictures/schematic_graph.hpp"

namespace kalfem {
namespace {

/// Ground - wheel =connector= body.1 - body.2, moved at the ground and pushed at body.2.
StructureParts quarter_car() {
  StructureParts parts;
  LumpedSubstructure wheel{.name = "wheel", .masses = {{"w", 1.0}}};
  wheel.springs = {{"tyre", "ground", "w", 100.0}};
  LumpedSubstructure body{.name = "body", .masses = {{"1", 1.0}, {"2", 1.0}}};
  body.springs = {{"k", "1", "2", 10.0, 0.5}, {"d", "1", "2", 0.0, 0.5}, {"none", "1", "2", 0.0}};
  body.points = {{"mean", {{"1", 0.5}, {"2", 0.5}}}};
  parts.substructures = {wheel, body};
  ConnectorDescription strut;
  strut.name = "strut";
  strut.from = "wheel.w";
  strut.to = "body.1";
  parts.connectors = {strut};
  parts.inputs = {{"road", InputKind::base_displacement, "wheel.ground"}, {"push", InputKind::force, "body.2"}};
  return parts;
}

Sensor sensor_at(const std::string& name, const std::string& point) {
  Sensor sensor{.name = name};
  sensor.output.points = {{point, 1.0}};
  return sensor;
}

const SchematicNode& node(const SchematicGraph& graph, const std::string& name) {
  return *std::ranges::find(graph.nodes, name, &SchematicNode::name);
}

TEST(SchematicGraph, LayersCountFromTheGround) {
  const auto graph = schematic_graph(quarter_car(), {}, {});
  EXPECT_EQ(node(graph, "wheel.ground").layer, 0);
  EXPECT_EQ(node(graph, "wheel.w").layer, 1);
  EXPECT_EQ(node(graph, "body.1").layer, 2);
  EXPECT_EQ(node(graph, "body.2").layer, 3);
  EXPECT_EQ(graph.layers, 4);
  EXPECT_EQ(node(graph, "wheel.ground").kind, SchematicNodeKind::ground);
  EXPECT_EQ(node(graph, "wheel.ground").inputs, std::vector<std::string>{"road"});
  EXPECT_EQ(node(graph, "body.2").inputs, std::vector<std::string>{"push"});
}

TEST(SchematicGraph, EveryNodeStandsOnAGroundOfItsOwn) {
  auto parts = quarter_car();
  parts.substructures[1].springs.push_back({"stay", "2", "ground", 5.0});
  parts.substructures[1].springs.push_back({"side", "1", "ground", 5.0});
  parts.inputs.push_back({"floor", InputKind::base_displacement, "body.ground"});
  const auto graph = schematic_graph(parts, {}, {});
  EXPECT_EQ(std::ranges::count(graph.nodes, SchematicNodeKind::ground, &SchematicNode::kind), 3);
  EXPECT_EQ(std::ranges::count_if(graph.nodes,
                                  [](const auto& each) {
                                    return each.name == "body.ground" &&
                                           each.inputs == std::vector<std::string>{"floor"};
                                  }),
            2);
}

TEST(SchematicGraph, StandsAboveWhatCarriesIt) {
  StructureParts parts;
  LumpedSubstructure car{.name = "car", .masses = {{"left", 1.0}, {"right", 1.0}, {"top", 1.0}}};
  car.springs = {{"a", "ground", "left", 1.0},
                 {"b", "ground", "right", 1.0},
                 {"c", "left", "top", 1.0},
                 {"d", "right", "top", 1.0}};
  parts.substructures = {car};
  const auto graph = schematic_graph(parts, {}, {});
  const double left = node(graph, "car.left").position, right = node(graph, "car.right").position;
  EXPECT_GE(right - left, 1.0 - 1e-12);
  EXPECT_NEAR(node(graph, "car.top").position, 0.5 * (left + right), 1e-2) << "sweeps halve what is left";
  for (const auto& each : graph.nodes)
    if (each.kind == SchematicNodeKind::ground)
      EXPECT_NEAR(std::min(std::abs(each.position - left), std::abs(each.position - right)), 0.0, 1e-2);
}

TEST(SchematicGraph, TellsSpringsFromDashpotsAndConnectors) {
  const auto graph = schematic_graph(quarter_car(), {}, {.unknown_connectors = {"strut"}});
  std::vector<SchematicEdgeKind> kinds;
  for (const auto& edge : graph.edges) kinds.push_back(edge.kind);
  using enum SchematicEdgeKind;
  EXPECT_EQ(kinds, (std::vector{spring, spring_and_dashpot, dashpot, connector})) << "a spring of nothing is not drawn";
  EXPECT_TRUE(graph.edges.back().unknown);
  EXPECT_FALSE(graph.edges.front().unknown);
}

TEST(SchematicGraph, PutsSensorsWhereTheyMeasure) {
  const auto graph = schematic_graph(
      quarter_car(), {sensor_at("a2", "body.2"), sensor_at("m", "body.mean"), sensor_at("load", "strut")}, {});
  EXPECT_EQ(node(graph, "body.2").sensors, std::vector<std::string>{"a2"});
  EXPECT_EQ(node(graph, "body.mean").kind, SchematicNodeKind::point);
  EXPECT_EQ(node(graph, "body.mean").sensors, std::vector<std::string>{"m"});
  EXPECT_EQ(graph.edges[3].label, "strut [load]");
  // A combination hangs on what it combines.
  EXPECT_EQ(std::ranges::count(graph.edges, SchematicEdgeKind::link, &SchematicEdge::kind), 2);
}

TEST(SchematicGraph, ALargeSubstructureIsABoxWithItsUsedPoints) {
  const auto graph = schematic_graph(quarter_car(), {sensor_at("a2", "body.2")}, {.most_masses = 1});
  EXPECT_EQ(node(graph, "body").kind, SchematicNodeKind::box);
  EXPECT_EQ(node(graph, "body.1").kind, SchematicNodeKind::point);
  EXPECT_EQ(node(graph, "wheel.w").kind, SchematicNodeKind::mass);
  EXPECT_EQ(std::ranges::count(graph.edges, SchematicEdgeKind::link, &SchematicEdge::kind), 2);
}

TEST(SchematicGraph, WhatHangsOnNoGroundIsThereToo) {
  StructureParts parts;
  LumpedSubstructure free{.name = "free", .masses = {{"a", 1.0}, {"b", 1.0}}};
  free.springs = {{"k", "a", "b", 1.0}};
  parts.substructures = {free};
  const auto graph = schematic_graph(parts, {}, {});
  EXPECT_EQ(node(graph, "free.a").layer, 1);
  EXPECT_EQ(node(graph, "free.b").layer, 2);
}

TEST(Schematic, NamesEverythingAndEscapesNames) {
  auto parts = quarter_car();
  parts.connectors[0].name = "<strut>";
  const std::string svg = schematic_svg(parts, {sensor_at("a&b", "body.2")}, {});
  for (const std::string text : {"wheel.w", "body.1", "body.2", "road", "push", "a&amp;b", "&lt;strut&gt;"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  EXPECT_EQ(svg.find("<strut>"), std::string::npos);
}

TEST(Schematic, OfNothingIsEmpty) { EXPECT_EQ(schematic_svg({}, {}), ""); }

}  // namespace
}  // namespace kalfem
