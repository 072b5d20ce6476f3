// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <complex>
#include <numbers>

#include "formats/universal_texts.hpp"

// Nodes, elements, lines, shapes, units and headers of universal files, and what surrounds the datasets.
namespace kalfem {
namespace {

using universal_text::dataset;
using universal_text::formatted;
using universal_text::Function;

class UniversalGeometry : public UniversalFiles {};

const std::string millimetres =
    dataset("164",
            "         5mm (milli-newton)            2\n  1.00000000000000000D+03  1.00000000000000000D+03  "
            "1.00000000000000000D+00\n  2.73149999999999977D+02\n");

TEST_F(UniversalGeometry, NodesOfBothDatasetsAreInMetres) {
  const std::string nodes =
      dataset("15", formatted("%10d%10d%10d%10d%13.5E%13.5E%13.5E\n", 7, 0, 1, 8, -2400.0, -950.0, 0.0)) +
      dataset("2411",
              "      3992         1         1        11\n   2.0940900802612305D+01   "
              "1.3069399833679199D+01  -3.9683275171308864D+01\n");
  const auto plain = read(nodes);
  ASSERT_EQ(plain.nodes.size(), 2u);
  EXPECT_EQ(plain.nodes[0].number, 7);
  EXPECT_EQ(plain.nodes[0].position[1], -950.0);
  EXPECT_EQ(plain.nodes[1].position[2], -3.9683275171308864e+01);
  const auto scaled = read(millimetres + nodes);
  EXPECT_DOUBLE_EQ(scaled.nodes[0].position[0], -2.4);
  EXPECT_TRUE(scaled.skipped.empty());
  const auto local = read(dataset("15", "1 0 3 8 0.0 1.0 2.0\n"));
  EXPECT_EQ(local.nodes[0].position[2], 2.0);
  EXPECT_NE(local.skipped.at(0).find("local axes"), std::string::npos);
}

TEST_F(UniversalGeometry, UnitsThatStandBehindDataHoldForThem) {
  const std::string nodes =
      dataset("15", formatted("%10d%10d%10d%10d%13.5E%13.5E%13.5E\n", 7, 0, 1, 8, -2400.0, -950.0, 0.0));
  const auto file = read(nodes + millimetres);
  ASSERT_EQ(file.nodes.size(), 1u);
  EXPECT_DOUBLE_EQ(file.nodes[0].position[0], -2.4);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("dataset 164 stands behind data"), std::string::npos);
}

TEST_F(UniversalGeometry, ElementsAndTraceLinesKeepTheirNodes) {
  const auto file =
      read(dataset("2412",
                   "         1        11         0         0         6         2\n         0         0         0\n"
                   "      3992      9678\n         2        44         1         1         7         4\n"
                   "         1         2         3         4\n") +
           dataset("82", formatted("%10d%10d%10d\n%-80s\n", 3, 9, 8, "Stator") +
                             "         1         2         3         0         4         5         0         6\n"
                             "         1         0         0         0\n"));
  ASSERT_EQ(file.lines.size(), 5u);
  EXPECT_EQ(file.lines[0].nodes, (std::vector<long>{3992, 9678}));
  EXPECT_EQ(file.lines[1].kind, 44);
  EXPECT_EQ(file.lines[1].nodes.size(), 4u);
  EXPECT_EQ(file.lines[2].name, "Stator");
  EXPECT_EQ(file.lines[2].nodes, (std::vector<long>{1, 2, 3}));
  EXPECT_EQ(file.lines[4].nodes, (std::vector<long>{6, 1}));
}

std::string shape_55(int analysis, int type, const std::string& numbers, const std::string& values) {
  return dataset("55",
                 formatted("%-80s\n%-80s\n%-80s\n%-80s\n%-80s\n", "First bending", "NONE", "NONE", "NONE", "NONE") +
                     formatted("%10d%10d%10d%10d%10d%10d\n", 1, analysis, 2, 8, type, 3) + numbers + values);
}

TEST_F(UniversalGeometry, ModesAtNodesHaveFrequencyAndDamping) {
  const std::string values =
      "         7\n 1.00000E+00-2.00000E+00 3.00000E+00\n         9\n 4.00000E+00 5.00000E+00 6.00000E+00\n";
  const auto real =
      read(shape_55(2, 2,
                    "         2         4         0         3\n 1.25000E+01 1.00000E+00 2.00000E-02 0.00000E+00\n",
                    values))
          .shapes.at(0);
  EXPECT_EQ(real.name, "First bending");
  EXPECT_EQ(real.frequency, 12.5);
  EXPECT_EQ(real.damping, 0.02);
  EXPECT_EQ(real.nodes, (std::vector<long>{7, 9}));
  EXPECT_EQ(real.values(0, 1), std::complex<double>(-2, 0));
  const auto hysteretic =
      read(shape_55(2, 2,
                    "         2         4         0         3\n 1.25000E+01 1.00000E+00 0.00000E+00 6.00000E-02\n",
                    values))
          .shapes.at(0);
  EXPECT_EQ(hysteretic.damping, 0.03);
  const auto complex =
      read(shape_55(3, 5,
                    "         2         6         0         1\n-3.00000E+00 4.00000E+00 0.00000E+00 0.00000E+00 "
                    "0.00000E+00 0.00000E+00\n",
                    "         7\n 1.00000E+00-2.00000E+00 3.00000E+00 4.00000E+00 5.00000E+00-6.00000E+00\n"))
          .shapes.at(0);
  EXPECT_DOUBLE_EQ(complex.frequency, 5.0 / (2.0 * std::numbers::pi));
  EXPECT_DOUBLE_EQ(complex.damping, 0.6);
  EXPECT_EQ(complex.values(0, 2), std::complex<double>(5, -6));
  const auto transient = read(shape_55(4, 2, "         2         1         0         1\n 1.00000E+00\n", values));
  EXPECT_TRUE(transient.shapes.empty());
  EXPECT_NE(transient.skipped.at(0).find("analysis type 4"), std::string::npos);
}

std::string shape_2414(int location, int analysis, const std::string& real, const std::string& values) {
  return dataset(
      "2414",
      "         1\nMode shape record 1\n" + formatted("%10d\n", location) + "NONE\nNONE\nNONE\nNONE\nNONE\n" +
          formatted("%10d%10d%10d%10d%10d%10d\n", 1, analysis, 2, 8, 5, 3) +
          "         0         0         1         0         0         4         0         0\n         0         0\n" +
          real + values);
}

TEST_F(UniversalGeometry, AnalysisDataAtNodesAreShapes) {
  const std::string values = "      3992\n  1.0  0.0  2.0  0.5 -3.0 -0.0\n";
  const auto mode = read(shape_2414(1, 2, "0 2.5E+02 0 1 1.0E-02 0\n0 0 0 0 0 0\n", values)).shapes.at(0);
  EXPECT_EQ(mode.name, "Mode shape record 1");
  EXPECT_EQ(mode.frequency, 250.0);
  EXPECT_EQ(mode.damping, 0.01);
  EXPECT_EQ(mode.values(0, 1), std::complex<double>(2, 0.5));
  const auto complex = read(shape_2414(1, 3, "0 0 0 1 0 0\n-3 4 0 0 0 0\n", values)).shapes.at(0);
  EXPECT_DOUBLE_EQ(complex.damping, 0.6);
  const auto fixed = read(millimetres + shape_2414(1, 1, "0 0 0 0 0 0\n0 0 0 0 0 0\n", values)).shapes.at(0);
  EXPECT_DOUBLE_EQ(fixed.values(0, 0).real(), 1e-3) << "a static shape in metres";
  const auto elements = read(shape_2414(2, 2, "0 1 0 0 0 0\n0 0 0 0 0 0\n", "1 2 3\n1 2 3\n"));
  EXPECT_TRUE(elements.shapes.empty());
  EXPECT_NE(elements.skipped.at(0).find("not at nodes"), std::string::npos);
}

TEST_F(UniversalGeometry, UnknownDatasetsAreListedByTheirNumbers) {
  const auto file =
      read(dataset("151", "Rig\nNONE\nTestLab\n01-Jan-20\n01-Jan-20\nTestLab 15\n01-Jan-20\n") +
           dataset("2420", "x\n") + dataset("18", "1\n") + dataset("18", "2\n") + Function{.points = 1}.with("1\n"));
  EXPECT_EQ(file.description, "Rig; TestLab; TestLab 15");
  EXPECT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(file.skipped, (std::vector<std::string>{"dataset 18 is not read (2 times)", "dataset 2420 is not read"}));
}

TEST_F(UniversalGeometry, MarksMayBePaddedMissingAtAnEndOrWithoutLineEnd) {
  const std::string one = Function{.points = 1}.with("1\n");
  std::string padded = one;
  padded.replace(0, 7, "    -1" + std::string(74, ' ') + "\r\n");
  EXPECT_EQ(read(padded + "\n" + one.substr(0, one.size() - 1)).channels.size(), 2u);
  EXPECT_EQ(read(one.substr(0, one.size() - 7)).channels.size(), 1u) << "all samples are there";
  std::string joined = one + one;  // the mark that closes the first dataset is missing
  joined.erase(joined.find("    -1\n", 10), 7);
  EXPECT_EQ(read(joined).channels.size(), 2u);
  const auto framed = read("exported by a program\n" + one + "some words\n");
  EXPECT_EQ(framed.channels.size(), 1u);
  EXPECT_NE(framed.skipped.at(0).find("line 1: 2 lines"), std::string::npos);
}

TEST_F(UniversalGeometry, TruncatedFilesAreRefusedWithTheirLine) {
  const std::string nodes = dataset("2411", "1 0 0 0\n1.0 2.0 3.0\n2 0 0 0\n4.0 5.0 6.0\n");
  EXPECT_NE(refusal(nodes.substr(0, nodes.size() - 7)).find("test.unv:6: dataset 2411 (from line 2): the file ends"),
            std::string::npos)
      << refusal(nodes.substr(0, nodes.size() - 7));
  EXPECT_NE(refusal(dataset("2411", "1 0 0 0\n1.0 2.0\n")).find("2 numbers"), std::string::npos);
  EXPECT_NE(refusal(dataset("2411", "1 0 0 0\n")).find("ends before the coordinates of node 1"), std::string::npos);
  EXPECT_NE(refusal(dataset("58", "one line\n")).find("ends before"), std::string::npos);
  EXPECT_NE(refusal(dataset("164", "1\n0.0 1.0 1.0\n")).find("not positive"), std::string::npos);
  EXPECT_NE(refusal("hello\n").find("not a universal file"), std::string::npos);
  EXPECT_NE(refusal("").find("not a universal file"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
