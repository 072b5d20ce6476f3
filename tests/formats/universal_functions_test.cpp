// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <complex>
#include <numbers>

#include "formats/universal_texts.hpp"

// Functions at nodal degrees of freedom: datasets 58 and 58b, as their description has them and as programs write them.
namespace kalfem {
namespace {

using universal_text::bytes_of;
using universal_text::dataset;
using universal_text::formatted;
using universal_text::Function;

Eigen::VectorXd vector(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

class UniversalFunctions : public UniversalFiles {
protected:
  MeasuredChannel channel(const std::string& content) const {
    const auto file = read(content);
    EXPECT_EQ(file.channels.size(), 1u);
    return file.channels.empty() ? MeasuredChannel{} : file.channels.front();
  }
  MeasuredFunction function(const std::string& content) const {
    const auto file = read(content);
    EXPECT_EQ(file.functions.size(), 1u);
    return file.functions.empty() ? MeasuredFunction{} : file.functions.front();
  }
};

TEST_F(UniversalFunctions, ATimeResponseIsAChannelWithPlaceUnitAndClock) {
  const auto c = channel(Function{.points = 7, .first = "5.00000E-01"}.with(
      " 1.00000E+00-2.00000E+00 3.00000E+00 4.00000E+00-5.00000E+00 6.00000E+00\n 7.00000E+00\n"));
  EXPECT_EQ(c.name, "12:+Z");
  EXPECT_EQ(c.other_names.front(), "Wing tip");
  EXPECT_EQ(c.place.node, 12);
  EXPECT_EQ(c.place.direction, 3);
  EXPECT_EQ(c.quantity, "acceleration");
  EXPECT_EQ(c.unit, "m/s^2");
  EXPECT_EQ(c.start, 0.5);
  EXPECT_EQ(c.interval, 0.01);
  EXPECT_EQ(c.values, vector({1, -2, 3, 4, -5, 6, 7}));
  EXPECT_EQ(c.times.size(), 0);
}

TEST_F(UniversalFunctions, NumbersAreReadAsFortranAndCWriteThem) {
  const Function four{.points = 4};
  const auto expected = vector({1.5, -2.25e-3, 3e10, -4e-101});
  EXPECT_EQ(channel(four.with(" 1.50000D+00-2.25000D-03 3.00000d+10-4.0000E-101\n")).values, expected) << "D exponents";
  EXPECT_EQ(channel(four.with("  .15000E+01 -.22500E-02  .30000E+11-4.00000-101\n")).values, expected) << "no letter";
  EXPECT_EQ(channel(four.with("1.5 -2.25e-3 3e10 -4e-101\r\n")).values, expected) << "free columns, \\r\\n";
  EXPECT_EQ(channel(four.with("1.5\n-2.25e-3\n\n3e10\n-4e-101     \n")).values, expected) << "one a line";
  EXPECT_EQ(channel(four.with("1.5000000e+00-2.2500000e-033.0000000e+10-4.00000e-101\n")).values, expected)
      << "full columns, no blank anywhere";
  EXPECT_EQ(channel(four.with(" 1.5000E+00-2.2500E-03 3.0000E+10-4.0000E-101\n")).values, expected)
      << "narrower columns that touch";
  const Function wide{.data = 4, .points = 3};
  EXPECT_EQ(channel(wide.with(" -1.234567890123E-01-1.234567890123D+002 0.000000000000E+00\n")).values,
            vector({-1.234567890123e-1, -1.234567890123e2, 0.0}));
}

TEST_F(UniversalFunctions, EveryCombinationOfPrecisionSpacingAndComplexIsReadAsText) {
  const auto real =
      channel(Function{.points = 2, .even = 0}.with(" 1.00000E+00 5.00000E+00 2.50000E+00-6.00000E+00\n"));
  EXPECT_EQ(real.times, vector({1, 2.5}));
  EXPECT_EQ(real.values, vector({5, -6}));
  EXPECT_EQ(real.interval, 0.0);
  EXPECT_EQ(real.start, 1.0);
  const auto fine = channel(Function{.data = 4, .points = 2, .even = 0}.with(
      formatted("%13.5E%20.12E%13.5E%20.12E\n", -1.0, -0.1234567890123, -0.5, -2.0)));
  EXPECT_EQ(fine.times, vector({-1, -0.5}));
  EXPECT_EQ(fine.values, vector({-0.1234567890123, -2}));

  const Function frf{
      .type = 4, .reference = 3, .reference_direction = 1, .points = 2, .abscissa = {18, "Frequency", "Hz"}};
  for (const int data : {5, 6}) {
    Function even = frf;
    even.data = data;
    even.step = "1.00000E+00";
    const int width = data == 6 ? 20 : 13, digits = data == 6 ? 12 : 5;
    std::string samples, uneven_samples;
    for (const double value : {-1.0, 2.0, -3.0, 4.0}) samples += formatted("%*.*E", width, digits, value);
    const auto read = function(even.with(samples + "\n"));
    EXPECT_EQ(read.kind, MeasuredFunctionKind::frequency_response);
    EXPECT_EQ(read.name, "12:+Z/3:+X");
    EXPECT_EQ(read.reference.node, 3);
    EXPECT_EQ(read.lines, vector({0, 1}));
    EXPECT_EQ(read.values[1], std::complex<double>(-3, 4));
    Function uneven = even;
    uneven.even = 0;
    for (const double line : {1.0, 4.0})
      uneven_samples += formatted("%13.5E%*.*E%*.*E\n", line, width, digits, -line, width, digits, 2 * line);
    const auto other = function(uneven.with(uneven_samples));
    EXPECT_EQ(other.lines, vector({1, 4}));
    EXPECT_EQ(other.values[1], std::complex<double>(-4, 8));
  }
}

TEST_F(UniversalFunctions, BytesAreFoundByTheirCountWhateverTheyHold) {
  // four bytes of a number, and eight of others, that spell an end mark and line ends
  float mark = 0, line = 0;
  std::memcpy(&mark, "  -1", 4);
  std::memcpy(&line, "\n   ", 4);
  const std::vector<float> floats = {1.5F, line, mark, line, -2.25F, line, mark, line};
  const Function single{.points = 8};
  for (const bool big : {false, true})
    for (const std::string closing : {"", "\n", "\r\n"}) {
      const auto values = channel(single.with_bytes(bytes_of(floats, big), big, closing)).values;
      ASSERT_EQ(values.size(), 8);
      EXPECT_EQ(values[0], 1.5);
      EXPECT_EQ(values[2], static_cast<double>(mark));
      EXPECT_EQ(values[4], -2.25);
    }
  const auto two = read(single.with_bytes(bytes_of(floats)) + single.with_bytes(bytes_of(floats), false, "\n"));
  ASSERT_EQ(two.channels.size(), 2u);
  EXPECT_EQ(two.channels[0].name, "12:+Z #1");
  EXPECT_EQ(two.channels[1].name, "12:+Z #2");
  EXPECT_EQ(two.channels[1].values, two.channels[0].values);
}

TEST_F(UniversalFunctions, EveryCombinationOfPrecisionSpacingAndComplexIsReadAsBytes) {
  const double third = 1.0 / 3.0;
  EXPECT_EQ(channel(Function{.data = 4, .points = 2}.with_bytes(bytes_of<double>({third, -third}), false)).values,
            vector({third, -third}));
  const auto uneven = channel(Function{.data = 4, .points = 2, .even = 0}.with_bytes(
      bytes_of<double>({0.1, third, 0.25, -third}, true), true, "\n"));
  EXPECT_EQ(uneven.times, vector({0.1, 0.25}));
  EXPECT_EQ(uneven.values, vector({third, -third}));
  const auto narrow = channel(Function{.data = 4, .points = 2, .even = 0}.with_bytes(
      bytes_of<float>({0.5F}) + bytes_of<double>({third}) + bytes_of<float>({0.75F}) + bytes_of<double>({-third})));
  EXPECT_EQ(narrow.times, vector({0.5, 0.75})) << "an abscissa of single precision beside doubles";
  EXPECT_EQ(narrow.values, vector({third, -third}));
  const auto frf = function(Function{.type = 4, .data = 5, .points = 2, .even = 0, .abscissa = {18}}.with_bytes(
      bytes_of<float>({1, 2, 3, 4, 5, 6})));
  EXPECT_EQ(frf.lines, vector({1, 4}));
  EXPECT_EQ(frf.values[1], std::complex<double>(5, 6));
}

TEST_F(UniversalFunctions, ACountOfBytesThatIsWrongIsCorrectedByTheEndMark) {
  // some programs count the points of complex numbers as real ones, or count nothing
  const Function frf{.type = 4, .data = 6, .points = 3, .step = "1.00000E+00", .abscissa = {18}};
  const std::string bytes = bytes_of<double>({1, 2, 3, 4, 5, 6});
  for (const long counted : {24L, 0L})
    EXPECT_EQ(function(frf.with_bytes(bytes, false, "", counted)).values[2], std::complex<double>(5, 6));
}

TEST_F(UniversalFunctions, AHeaderThatDeclaresMoreSamplesThanThereAreIsRefusedWithBothCounts) {
  const Function six{.points = 6};
  for (const std::string& content : {six.with(" 1.00000E+00 2.00000E+00\n"),                 // complete dataset
                                     six.with(" 1.00000E+00 2.00000E+00\n").substr(0, 900),  // cut off file
                                     six.with_bytes(bytes_of<float>({1, 2})),                // bytes
                                     Function{.points = 600}.with_bytes(bytes_of<float>({1, 2}))}) {
    const std::string text = refusal(content);
    EXPECT_NE(text.find("test.unv:9:"), std::string::npos) << text;
    EXPECT_NE(text.find("declares 6"), std::string::npos) << text;
  }
  const std::string text = refusal(six.with(" 1.00000E+00 2.00000E+00\n"));
  EXPECT_NE(text.find("the dataset has 2"), std::string::npos) << text;
  EXPECT_NE(refusal(Function{.points = 1}.with("1 2 3\n")).find("the dataset has 3"), std::string::npos)
      << "more samples than declared would be lost silently";
  EXPECT_EQ(channel(Function{.points = 2}.with("1 2 0 0 0 0\n")).values, vector({1, 2})) << "zeros fill the line up";
}

TEST_F(UniversalFunctions, DamagedNumbersAreRefusedWithTheirLinesAllAtOnce) {
  const Function two{.points = 2};
  const std::string text = refusal(two.with("1 *************\n") + two.with("1 2x\n"));
  EXPECT_NE(text.find("test.unv:14:"), std::string::npos) << text;
  EXPECT_NE(text.find("test.unv:29:"), std::string::npos) << text;
  EXPECT_NE(text.find("2x"), std::string::npos) << text;
}

TEST_F(UniversalFunctions, UnitsOfLabelsMayBeInLatin1AndInManySpellings) {
  const auto unit = [&](const std::string& label) {
    return channel(Function{.points = 1, .ordinate = {12, "Beschleunigung", label}}.with("1\n")).unit;
  };
  EXPECT_EQ(unit("m/s\xB2"), "m/s²");
  EXPECT_EQ(unit("m/s²"), "m/s²");
  EXPECT_EQ(unit("[m/s2]"), "m/s2");
  EXPECT_EQ(unit("M/SEC^2"), "m/s^2");
  EXPECT_EQ(unit("g"), "g");
  EXPECT_EQ(unit("counts"), "counts");
  EXPECT_EQ(unit("NONE"), "m/s^2");
  EXPECT_EQ(channel(Function{.points = 1, .ordinate = {2, "Dehnung", "\xB5m/m"}}.with("1\n")).unit, "µm/m");
  const auto latin =
      channel(Function{.points = 1, .text = "Tr\xE4ger", .ordinate = {8, "Tr\xE4gerh\xF6he", "mm"}}.with("1\n"));
  EXPECT_EQ(latin.unit, "mm");
  EXPECT_EQ(latin.other_names.front(), "Träger");
}

TEST_F(UniversalFunctions, WithoutLabelsTheDataTypeAndDataset164TellTheUnit) {
  const std::string millimetres = dataset("164", formatted("%10d%-20s%10d\n%25.17E%25.17E%25.17E\n%25.17E\n", 5,
                                                           "mm (milli-newton)", 2, 1e3, 1e3, 1.0, 273.15));
  const auto read_one = [&](universal_text::Axis axis, int direction = 3) {
    return channel(millimetres + Function{.direction = direction, .points = 1, .ordinate = axis}.with("5000\n"));
  };
  EXPECT_EQ(read_one({8}).values[0], 5.0);
  EXPECT_EQ(read_one({8}).unit, "m");
  EXPECT_EQ(read_one({12}).unit, "m/s^2");
  EXPECT_EQ(read_one({13}).quantity, "force");
  EXPECT_EQ(read_one({13}).values[0], 5.0);
  EXPECT_EQ(read_one({9}).unit, "N");
  EXPECT_EQ(read_one({8}, 6).unit, "rad");
  EXPECT_EQ(read_one({8}, -6).values[0], 5000.0) << "radians do not depend on the unit of length";
  EXPECT_EQ(read_one({1, "Stiffness", "NONE", -1, 1, 0}).unit, "m^-1 N^1") << "exponents of the general type";
  EXPECT_EQ(read_one({1, "Stiffness", "NONE", -1, 1, 0}).values[0], 5000.0);
  EXPECT_EQ(read_one({0}).unit, "");
  const auto labelled = read(millimetres + Function{.points = 1, .ordinate = {12, "A", "m/s^2"}}.with("5000\n"));
  EXPECT_EQ(labelled.channels[0].values[0], 5000.0) << "the label holds";
  ASSERT_EQ(labelled.skipped.size(), 1u);
  EXPECT_NE(labelled.skipped[0].find("12:+Z"), std::string::npos);
}

TEST_F(UniversalFunctions, FrequencyResponsesHaveTheUnitOfTheirQuotient) {
  const auto unit = [&](universal_text::Axis above, universal_text::Axis below) {
    return function(Function{.type = 4,
                             .reference = 3,
                             .reference_direction = 3,
                             .data = 5,
                             .points = 1,
                             .abscissa = {18},
                             .ordinate = above,
                             .denominator = below}
                        .with("1 2\n"))
        .unit;
  };
  EXPECT_EQ(unit({12}, {13}), "(m/s^2)/(N)");
  EXPECT_EQ(unit({12, "A", "g"}, {13, "F", "lbf"}), "(g)/(lbf)");
  EXPECT_EQ(unit({12, "A", "g/N"}, {13, "F", "N"}), "g/N") << "the numerator's label holds the whole quotient";
  EXPECT_EQ(unit({1, "A", "(1/N)*(m/s\xB2)"}, {0}), "(1/N)*(m/s²)");
  EXPECT_EQ(unit({0}, {0}), "");
}

TEST_F(UniversalFunctions, StepsOfFewDigitsMeanTheRoundRate) {
  const auto interval = [&](const std::string& step) {
    return channel(Function{.points = 1, .step = step}.with("1\n")).interval;
  };
  EXPECT_EQ(interval("4.88281E-04"), 1.0 / 2048.0);
  EXPECT_EQ(interval("1.95312E-05"), 1.0 / 51200.0);
  EXPECT_EQ(interval("5.00000E-005"), 5e-5);
  EXPECT_EQ(interval("1.23457E-03"), 1.0 / 810.0);
  EXPECT_EQ(interval("3.33300E-03"), 3.333e-3) << "a round interval stays";
  EXPECT_EQ(interval("4.8828125e-04"), 1.0 / 2048.0) << "a column filled by digits";
  EXPECT_NEAR(interval("1.23456E-03"), 1.23456e-3, 1e-12);
}

TEST_F(UniversalFunctions, OtherUnitsOfTheAbscissaAreConverted) {
  EXPECT_EQ(channel(Function{.points = 1, .step = "5.00000E-01", .abscissa = {17, "Time", "ms"}}.with("1\n")).interval,
            5e-4);
  const Function spectrum{.type = 2, .points = 2, .even = 0, .abscissa = {18, "w", "rad/s"}};
  const auto read_one = function(spectrum.with("0 1 6.283185307 1\n"));
  EXPECT_NEAR(read_one.lines[1], 1.0, 1e-9);
  EXPECT_EQ(read_one.kind, MeasuredFunctionKind::auto_spectrum);
}

TEST_F(UniversalFunctions, HeadersWithShiftedColumnsAreRead) {
  std::string text = Function{.points = 2, .component = "Tower left"}.with("1 2\n");
  const auto moved = [&](const std::string& from, const std::string& to) {
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos);
    text.replace(place, from.size(), to);
  };
  moved("    1         0    1         0 ", "1         0    1           0 ");
  moved("         2         2         1", "2 2 1 ");
  moved("        17    0    0    0 ", "17 0 0 0 ");
  const auto c = channel(text);
  EXPECT_EQ(c.name, "Tower left:12:+Z");
  EXPECT_EQ(c.values, vector({1, 2}));
  EXPECT_EQ(c.interval, 0.01);
}

TEST_F(UniversalFunctions, ChannelsWithoutAPlaceAreNamedByTheirTexts) {
  const auto c = channel(
      Function{.response = 0, .direction = 0, .points = 1, .text = "1x : m/s\xB2", .ordinate = {1, "1x", "m/s\xB2"}}
          .with("1\n"));
  EXPECT_EQ(c.name, "1x : m/s²");
  EXPECT_EQ(c.other_names, std::vector<std::string>{"1x"});
  EXPECT_FALSE(c.place.node.has_value());
  EXPECT_EQ(c.quantity, "acceleration") << "told by the unit";
  EXPECT_EQ(channel(Function{.response = 0, .direction = 0, .points = 1, .text = "NONE"}.with("1\n")).name,
            "function of line 2");
}

TEST_F(UniversalFunctions, WhatIsNeitherASignalNorAFrequencyFunctionIsListed) {
  const auto file = read(Function{.type = 7, .points = 1}.with("1\n") +
                         Function{.type = 12, .points = 1, .abscissa = {20}}.with("1\n") +
                         Function{.points = 0}.with("") + Function{.points = 2}.with("1 2\n"));
  EXPECT_EQ(file.channels.size(), 1u);
  ASSERT_EQ(file.skipped.size(), 3u);
  EXPECT_NE(file.skipped[0].find("type 7"), std::string::npos);
  EXPECT_NE(file.skipped[0].find("line 2"), std::string::npos);
}

TEST_F(UniversalFunctions, BytesOfOtherMachinesAreListedAndPassedOver) {
  std::string text = Function{.points = 2}.with_bytes(bytes_of<float>({1, 2}));
  text.replace(text.find("     2          11"), 6, "     3");
  const auto file = read(text + Function{.points = 1}.with("1\n"));
  EXPECT_EQ(file.channels.size(), 1u);
  ASSERT_EQ(file.skipped.size(), 1u);
  EXPECT_NE(file.skipped[0].find("IBM"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
