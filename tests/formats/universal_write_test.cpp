// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <complex>
#include <limits>
#include <random>

#include "formats/universal_texts.hpp"

// What is written as a universal file reads back: to the last digit as bytes, to the digits of the format as text.
namespace kalfem {
namespace {

using Eigen::Index;

class UniversalWriting : public testing::Test {
protected:
  MeasuredFile round_trip(const MeasuredFile& file, bool binary = true) const {
    write_universal(folder_ / "out.unv", file, {.binary = binary});
    return read_universal(folder_ / "out.unv");
  }
  Eigen::VectorXd random(Index count) {
    Eigen::VectorXd values(count);
    for (auto& value : values) value = std::normal_distribution<>(0.0, 1e3)(generator_);
    return values;
  }
  MeasuredChannel channel(const std::string& name, long node, int direction, double interval) {
    return {.name = name,
            .unit = "m/s^2",
            .quantity = "acceleration",
            .place = {node, direction},
            .start = 0.125,
            .interval = interval,
            .values = random(101)};
  }

  ScratchFolder folder_{"universal_writing"};
  std::mt19937 generator_{7};
};

TEST_F(UniversalWriting, ChannelsReadBackToTheLastDigitAsBytes) {
  MeasuredFile file;
  for (const double interval : {0.01, 1.0 / 2048.0, 1.0 / 3.0, 1.0 / 51200.0, 5e-5})
    file.channels.push_back(channel("12:+Z", 12, 3, interval));
  file.channels[0].description = "Wing tip; run 3";
  const auto back = round_trip(file);
  ASSERT_EQ(back.channels.size(), 5u);
  for (std::size_t j = 0; j < 5; ++j) {
    const auto &sent = file.channels[j], &read = back.channels[j];
    EXPECT_EQ(read.values, sent.values);
    EXPECT_EQ(read.interval, sent.interval) << j;
    EXPECT_EQ(read.start, sent.start);
    EXPECT_EQ(read.unit, sent.unit);
    EXPECT_EQ(read.quantity, sent.quantity);
    EXPECT_EQ(read.place.direction, 3);
    EXPECT_EQ(read.times.size(), 0);
  }
  EXPECT_EQ(back.channels[0].description, "Wing tip; run 3");
  EXPECT_TRUE(back.skipped.empty());
}

TEST_F(UniversalWriting, TimesReadBackToTheLastDigitAsBytes) {
  MeasuredFile file;
  file.channels = {channel("Träger", 0, 0, 0.0), channel("odd step", 7, -1, std::sqrt(2.0) / 100.0)};
  file.channels[0].place = {};
  file.channels[0].times = random(101);
  file.channels[0].values[3] = std::numeric_limits<double>::quiet_NaN();
  const auto back = round_trip(file);
  EXPECT_EQ(back.channels[0].name, "Träger");
  EXPECT_EQ(back.channels[0].times, file.channels[0].times);
  EXPECT_TRUE(std::isnan(back.channels[0].values[3]));
  ASSERT_EQ(back.channels[1].times.size(), 101) << "no column holds this step: the times are written";
  EXPECT_EQ(back.channels[1].times[100], 100.0 * file.channels[1].interval + 0.125);
  EXPECT_EQ(back.channels[1].name, "7:-X");
}

TEST_F(UniversalWriting, TextKeepsTheDigitsOfTheFormat) {
  MeasuredFile file;
  file.channels = {channel("12:+Z", 12, 3, 1.0 / 2048.0), channel("uneven", 3, 2, 0.0)};
  file.channels[1].times = Eigen::VectorXd::LinSpaced(101, 0.0, 10.0);
  const auto back = round_trip(file, false);
  EXPECT_EQ(back.channels[0].interval, 1.0 / 2048.0);
  for (std::size_t j = 0; j < 2; ++j)
    for (Index k = 0; k < 101; ++k)
      EXPECT_NEAR(back.channels[j].values[k], file.channels[j].values[k],
                  5.1e-13 * std::abs(file.channels[j].values[k]) * 10);
  EXPECT_TRUE(back.channels[1].times.isApprox(file.channels[1].times, 5e-6));
  const auto again = round_trip(back, false);
  EXPECT_EQ(again.channels[0].values, back.channels[0].values) << "nothing more is lost";
  EXPECT_EQ(again.channels[1].times, back.channels[1].times);
}

TEST_F(UniversalWriting, FunctionsOfFrequencyReadBack) {
  MeasuredFile file;
  MeasuredFunction frf{.name = "12:+Z/3:+X",
                       .unit = "(m/s^2)/(N)",
                       .kind = MeasuredFunctionKind::frequency_response,
                       .response = {12, 3},
                       .reference = {3, 1}};
  frf.lines = 0.03125 * Eigen::VectorXd::LinSpaced(64, 0.0, 63.0);
  frf.values = random(64) + std::complex<double>(0, 1) * random(64).cast<std::complex<double>>();
  MeasuredFunction coherence = frf;
  coherence.kind = MeasuredFunctionKind::coherence;
  coherence.unit = "";
  coherence.values = Eigen::VectorXcd::Constant(64, 0.9);
  coherence.lines = random(64).cwiseAbs();
  std::sort(coherence.lines.begin(), coherence.lines.end());
  file.functions = {frf, coherence};
  const auto back = round_trip(file);
  ASSERT_EQ(back.functions.size(), 2u);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_EQ(back.functions[j].lines, file.functions[j].lines);
    EXPECT_EQ(back.functions[j].values, file.functions[j].values);
    EXPECT_EQ(back.functions[j].unit, file.functions[j].unit);
    EXPECT_EQ(back.functions[j].kind, file.functions[j].kind);
    EXPECT_EQ(back.functions[j].reference.node, 3);
  }
  const auto text = round_trip(file, false);
  EXPECT_EQ(text.functions[0].lines, frf.lines);
  EXPECT_TRUE(text.functions[0].values.isApprox(frf.values, 1e-12));
}

TEST_F(UniversalWriting, ShapesAndGeometryReadBack) {
  MeasuredFile file{.description = "Ground vibration test"};
  file.nodes = {{1, {0.1, -1.0 / 3.0, 1e-300}}, {2000000001, {-2.5e10, 0, 1}}};
  file.lines = {{.number = 1, .name = "Wing", .nodes = {1, 2, 3, 4, 5, 6, 7, 8, 9}}};
  MeasuredShape real{.name = "Bending", .frequency = 12.5, .damping = 0.02, .nodes = {1, 2}};
  real.values = Eigen::MatrixXcd::Zero(2, 3);
  real.values.real() << 1, -2, 3, 4, 5, -6.25;
  MeasuredShape complex = real;
  complex.values.resize(2, 6);
  complex.values.setConstant({0.5, -0.25});
  MeasuredShape fixed = real;
  fixed.frequency = fixed.damping = 0.0;
  file.shapes = {real, complex, fixed};
  const auto back = round_trip(file);
  EXPECT_EQ(back.description, "Ground vibration test");
  ASSERT_EQ(back.nodes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back.nodes[i].number, file.nodes[i].number);
    EXPECT_EQ(back.nodes[i].position, file.nodes[i].position);
  }
  ASSERT_EQ(back.lines.size(), 1u);
  EXPECT_EQ(back.lines[0].nodes, file.lines[0].nodes);
  ASSERT_EQ(back.shapes.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back.shapes[i].values, file.shapes[i].values) << i;
    EXPECT_NEAR(back.shapes[i].frequency, file.shapes[i].frequency, 1e-4);
    EXPECT_NEAR(back.shapes[i].damping, file.shapes[i].damping, 1e-6);
    EXPECT_EQ(back.shapes[i].nodes, file.shapes[i].nodes);
  }
}

TEST_F(UniversalWriting, MeshesBecomeNodesAndElements) {
  Mesh mesh{.node_ids = {}, .nodes = Eigen::Matrix3Xd::Random(3, 23)};
  for (int i = 0; i < 23; ++i) mesh.node_ids.push_back(100 + i);
  std::vector<Index> hexahedron(20);
  for (int i = 0; i < 20; ++i) hexahedron[static_cast<std::size_t>(i)] = i;
  mesh.add_cell(CellShape::hexahedron20, 5, hexahedron);
  mesh.add_cell(CellShape::line2, 6, std::array<Index, 2>{21, 22});
  mesh.add_cell(CellShape::quadrilateral4, 7, std::array<Index, 4>{0, 1, 2, 3});
  const auto back = round_trip(geometry_of(mesh));
  ASSERT_EQ(back.nodes.size(), 23u);
  EXPECT_EQ(back.nodes[22].position[1], mesh.nodes(1, 22));
  ASSERT_EQ(back.lines.size(), 3u);
  EXPECT_EQ(back.lines[0].kind, 116);
  EXPECT_EQ(back.lines[0].nodes[1], 108) << "the middle of the first side stands between its corners";
  EXPECT_EQ(back.lines[0].nodes[8], 116) << "then the sides between the faces";
  EXPECT_EQ(back.lines[0].nodes[19], 115);
  EXPECT_EQ(back.lines[1].kind, 21);
  EXPECT_EQ(back.lines[1].nodes, (std::vector<long>{121, 122}));
  EXPECT_EQ(back.lines[2].kind, 94);
}

TEST_F(UniversalWriting, WhatTheFormatCannotHoldIsRefused) {
  MeasuredFile file;
  file.channels = {channel("12:+Z", 12, 3, 0.01)};
  file.channels[0].unit = "a unit with too many letters";
  EXPECT_THROW(round_trip(file), InvalidInput);
  file.channels[0].unit = "m";
  file.channels[0].values[0] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(round_trip(file), InvalidInput);
  file.channels[0].values[0] = 0.0;
  file.channels[0].times = Eigen::VectorXd::Zero(3);
  EXPECT_THROW(round_trip(file), InvalidInput);
  file.channels.clear();
  file.nodes = {{12345678901L, {}}};
  EXPECT_THROW(round_trip(file), InvalidInput);
}

}  // namespace
}  // namespace kalfem
