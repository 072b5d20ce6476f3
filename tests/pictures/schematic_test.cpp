// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/schematic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>

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

/// Half of a car: a body of heave and pitch on two wheels, each with a strut, a friction and a load beside it, and an
/// element between the two strokes.
StructureParts half_car() {
  StructureParts parts;
  LumpedSubstructure car{.name = "car", .masses = {{"heave", 400.0}, {"pitch", 80.0}, {"uL", 50.0}, {"uR", 50.0}}};
  for (const auto& [side, arm] : {std::pair{"L", -0.75}, {"R", 0.75}}) {
    const std::string s = side;
    car.points[s + "H"] = {{"heave", 1.0}, {"pitch", arm}};
    car.points["stroke_" + s + "H"] = {{"heave", 1.0}, {"pitch", arm}, {"u" + s, -1.0}};
    car.springs.push_back({"strut_" + s, "u" + s, s + "H", 2e4, 100.0});
    car.springs.push_back({"tyre_" + s, "ground", "u" + s, 1e5, 100.0});
  }
  parts.substructures = {car};
  const auto join = [&](const std::string& name, const std::string& from, const std::string& to) {
    ConnectorDescription connector;
    connector.name = name;
    connector.from = "car." + from;
    connector.to = "car." + to;
    parts.connectors.push_back(connector);
  };
  for (const std::string side : {"L", "R"}) {
    join("friction_" + side, "u" + side, side + "H");
    join("load_" + side, "u" + side, side + "H");
    join("tyreload_" + side, "ground", "u" + side);
  }
  join("cross", "stroke_RH", "stroke_LH");
  return parts;
}

struct Box {
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;
  std::string text = {};
};

/// The names in a picture, with the room that letters of its size take.
std::vector<Box> names_in(const std::string& svg) {
  static const std::regex text(
      "<text[^>]* x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"([^>]*)>(?:<tspan[^>]*>[^<]*</tspan>)?([^<]*)</text>");
  std::vector<Box> boxes;
  for (std::sregex_iterator at(svg.begin(), svg.end(), text), end; at != end; ++at) {
    const double x = std::stod((*at)[1]), y = std::stod((*at)[2]);
    const double width = 6.4 * static_cast<double>((*at)[4].length());
    const std::string attributes = (*at)[3];
    const double left = attributes.find("\"end\"") != std::string::npos      ? x - width
                        : attributes.find("\"middle\"") != std::string::npos ? x - 0.5 * width
                                                                             : x;
    boxes.push_back({left, left + width, y - 8.0, y, (*at)[4]});
  }
  return boxes;
}

/// Places all over the symbols of springs and dashpots.
std::vector<Eigen::Vector2d> places_of_symbols(const std::string& svg) {
  static const std::regex symbol(
      "translate\\(([-0-9.]+) ([-0-9.]+)\\) rotate\\(([-0-9.]+)\\)\"><path class=\"(part|joint)[^>]*H([0-9.]+)\"/>");
  std::vector<Eigen::Vector2d> places;
  for (std::sregex_iterator at(svg.begin(), svg.end(), symbol), end; at != end; ++at) {
    const double angle = std::stod((*at)[3]) * M_PI / 180.0, length = std::stod((*at)[5]);
    const Eigen::Vector2d begin(std::stod((*at)[1]), std::stod((*at)[2])), along(std::cos(angle), std::sin(angle)),
        across(-along[1], along[0]);
    for (int k = 0; k <= 20; ++k)
      for (int side = -11; side <= 11; ++side) places.push_back(begin + k / 20.0 * length * along + side * across);
  }
  return places;
}

TEST(Schematic, NoNameStandsOnASymbolOrAnotherName) {
  auto chain = quarter_car();
  for (const auto& parts : {half_car(), chain}) {
    std::vector<Sensor> sensors;
    for (const auto& substructure : parts.substructures)
      for (const auto& mass : substructure.masses)
        if (mass.dof != "heave" && mass.dof != "pitch")
          sensors.push_back(sensor_at("sensor_" + mass.dof, substructure.name + "." + mass.dof));
    if (parts.substructures.front().name == "car")
      for (const std::string side : {"L", "R"})
        sensors.push_back(sensor_at("sprung_" + side + "H", "car." + side + "H"));
    const auto svg = schematic_svg(parts, sensors, {});
    const auto names = names_in(svg);
    ASSERT_GE(names.size(), 6U);
    for (const auto& name : names) {
      for (const auto& place : places_of_symbols(svg))
        EXPECT_FALSE(place[0] > name.left && place[0] < name.right && place[1] > name.top && place[1] < name.bottom)
            << name.text << " stands on the symbol at " << place.transpose();
      for (const auto& other : names)
        EXPECT_TRUE(&name == &other || name.right <= other.left || other.right <= name.left ||
                    name.bottom <= other.top || other.bottom <= name.top)
            << name.text << " and " << other.text;
    }
  }
}

}  // namespace
}  // namespace kalfem
