// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tdms/tdms.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "kalfem/base/invalid_input.hpp"
#include "tdms_file.hpp"

// Layouts of the format's description and of npTDMS's tests.
namespace kalfem {
namespace {

using Eigen::VectorXd;
using test::raw;
using test::TdmsWriter;
using Numbers = std::vector<double>;

constexpr std::uint32_t i8 = 1, i16 = 2, i32 = 3, i64 = 4, u8 = 5, u16 = 6, u32 = 7, u64 = 8, f32 = 9, f64 = 10,
                        text_type = 0x20, boolean = 0x21, time_type = 0x44;
const std::string first = "/'group'/'a'", second = "/'group'/'b'", third = "/'group'/'c'";

std::string ints(const Numbers& numbers) { return raw<std::int32_t>(numbers); }

Numbers values(const MeasuredFile& file, const std::string& name) {
  for (const auto& channel : file.channels)
    if (channel.name == name) return {channel.values.begin(), channel.values.end()};
  ADD_FAILURE() << "no channel " << name;
  return {};
}

MeasuredFile parsed(const TdmsWriter& writer) { return parse_tdms(writer.bytes, "run.tdms"); }

std::string skipped(const MeasuredFile& file) {
  std::string all;
  for (const auto& words : file.skipped) all += words + "\n";
  return all;
}

/// Two channels of two numbers in one segment.
TdmsWriter two_channels(const std::string& data = ints({1, 2, 3, 4}), std::uint32_t flags = TdmsWriter::usual,
                        double count = 2, bool unfinished = false) {
  TdmsWriter w;
  w.segment(flags, {w.object(first, w.index(i32, count)), w.object(second, w.index(i32, count))}, data, unfinished);
  return w;
}

TEST(Tdms, OneSegment) {
  const auto file = parsed(two_channels());
  EXPECT_EQ(file.format, "TDMS file");
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2}));
  EXPECT_EQ(values(file, "b"), (Numbers{3, 4}));
  EXPECT_TRUE(file.skipped.empty()) << skipped(file);
}

TEST(Tdms, InterleavedChannelsOfDifferentWidth) {
  TdmsWriter w;
  std::string rows;
  for (int k = 1; k <= 3; ++k)
    rows += raw<std::int8_t>({double(k)}) + raw<std::int16_t>({-double(k)}) + ints({10.0 * k});
  w.segment(TdmsWriter::usual | TdmsWriter::interleaved,
            {w.object(first, w.index(i8, 2)), w.object(second, w.index(i16, 2)), w.object(third, w.index(i32, 2))},
            rows);
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 3}));
  EXPECT_EQ(values(file, "b"), (Numbers{-1, -2, -3}));
  EXPECT_EQ(values(file, "c"), (Numbers{10, 20, 30}));
}

TEST(Tdms, ASegmentWithoutDescriptionGoesOnAsTheOneBefore) {
  auto w = two_channels();
  w.segment(TdmsWriter::raw_data, {}, ints({5, 6, 7, 8}));
  w.segment(TdmsWriter::usual, {w.object(first, w.as_before()), w.object(second, w.as_before())},
            ints({9, 10, 11, 12}));
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 5, 6, 9, 10}));
  EXPECT_EQ(values(file, "b"), (Numbers{3, 4, 7, 8, 11, 12}));
}

TEST(Tdms, ChunksWithoutDescription) {
  auto w = two_channels(ints({0, 1, 10, 11, 2, 3, 12, 13}));
  w.segment(TdmsWriter::raw_data, {}, ints({4, 5, 14, 15, 6, 7, 16, 17}));
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(values(file, "b"), (Numbers{10, 11, 12, 13, 14, 15, 16, 17}));
}

TEST(Tdms, AddedGrownAndRemovedChannels) {
  auto w = two_channels();
  w.segment(TdmsWriter::metadata | TdmsWriter::raw_data, {w.object(third, w.index(i32, 2))}, ints({5, 6, 7, 8, 9, 10}));
  w.segment(TdmsWriter::metadata | TdmsWriter::raw_data, {w.object(second, w.index(i32, 3))},
            ints({11, 12, 13, 14, 15, 16, 17}));
  w.segment(TdmsWriter::usual, {w.object(first, w.index(i32, 2))}, ints({18, 19}));
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 5, 6, 11, 12, 18, 19}));
  EXPECT_EQ(values(file, "b"), (Numbers{3, 4, 7, 8, 13, 14, 15}));
  EXPECT_EQ(values(file, "c"), (Numbers{9, 10, 16, 17}));
}

TEST(Tdms, ChannelsThatTakeTurnsKeepTheirPlaceInTheList) {
  for (const std::uint32_t list : {TdmsWriter::new_list, 0u}) {
    TdmsWriter w;
    const auto flags = TdmsWriter::metadata | TdmsWriter::raw_data | list;
    w.segment(TdmsWriter::usual, {w.object(first, w.index(i32, 2)), w.object(second, w.no_data())}, ints({1, 2}));
    w.segment(flags, {w.object(first, w.no_data()), w.object(second, w.index(i32, 2))}, ints({3, 4}));
    w.segment(flags, {w.object(first, w.as_before()), w.object(second, w.no_data())}, ints({5, 6}));
    w.segment(flags, {w.object(first, w.as_before()), w.object(second, w.as_before())}, ints({7, 8, 9, 10}));
    const auto file = parsed(w);
    EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 5, 6, 7, 8}));
    EXPECT_EQ(values(file, "b"), (Numbers{3, 4, 9, 10}));
  }
}

TEST(Tdms, SegmentsWithoutDataCount) {
  TdmsWriter w;
  w.segment(TdmsWriter::metadata | TdmsWriter::new_list, {w.object(first, w.index(i32, 2))}, "");
  w.segment(TdmsWriter::usual, {w.object(first, w.as_before())}, ints({1, 2}));
  w.segment(TdmsWriter::metadata | TdmsWriter::new_list, {w.object(first, w.as_before())}, "");
  w.segment(TdmsWriter::usual, {w.object(first, w.as_before())}, ints({3, 4}));
  w.segment(TdmsWriter::metadata | TdmsWriter::raw_data, {w.object(first, w.index(i32, 0))}, "");
  EXPECT_EQ(values(parsed(w), "a"), (Numbers{1, 2, 3, 4}));
}

TEST(Tdms, AFinishedSegmentMayEndInASmallerChunk) {
  const auto file = parsed(two_channels(ints({1, 2, 3, 4, 5, 6})));
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 5}));
  EXPECT_EQ(values(file, "b"), (Numbers{3, 4, 6}));
  const auto rows =
      parsed(two_channels(ints({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}), TdmsWriter::usual | TdmsWriter::interleaved, 3));
  EXPECT_EQ(values(rows, "a"), (Numbers{1, 3, 5, 7, 9}));
  EXPECT_EQ(values(rows, "b"), (Numbers{2, 4, 6, 8, 10}));
}

TEST(Tdms, BytesThatAreNoWholeChunkAreNamed) {
  EXPECT_TRUE(skipped(parsed(two_channels(ints({1, 2, 3, 4, 5, 6})))).empty());
  EXPECT_NE(skipped(parsed(two_channels(ints({1, 2, 3, 4, 5})))).find("4 bytes at the end"), std::string::npos);
}

TEST(Tdms, ASegmentThatWasNeverFinishedKeepsWhatIsWhole) {
  auto w = two_channels();
  w.segment(TdmsWriter::raw_data, {}, ints({5, 6, 7, 8, 9, 10, 11}), true);
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 5, 6, 9, 10}));
  EXPECT_EQ(values(file, "b"), (Numbers{3, 4, 7, 8, 11}));
  EXPECT_NE(skipped(file).find("never finished"), std::string::npos) << skipped(file);
  EXPECT_NE(skipped(file).find("'b' misses the last 1 samples"), std::string::npos) << skipped(file);
  const auto rows =
      parsed(two_channels(ints({1, 2, 3, 4, 5, 6, 7}), TdmsWriter::usual | TdmsWriter::interleaved, 2, true));
  EXPECT_EQ(values(rows, "a"), (Numbers{1, 3, 5}));
  EXPECT_EQ(values(rows, "b"), (Numbers{2, 4, 6}));
  EXPECT_NE(skipped(rows).find("not a whole row"), std::string::npos) << skipped(rows);
}

TEST(Tdms, AFileThatWasCutAnywhereSaysSo) {
  auto w = two_channels();
  const std::size_t whole = w.bytes.size();
  w.segment(TdmsWriter::usual, {w.object(first, w.index(i32, 2)), w.object(second, w.index(i32, 2))},
            ints({5, 6, 7, 8}));
  for (std::size_t size = whole + 1; size < w.bytes.size(); ++size) {
    const auto file = parse_tdms(std::string_view(w.bytes).substr(0, size), "run.tdms");
    EXPECT_EQ(values(file, "a").front(), 1) << size;
    EXPECT_FALSE(file.skipped.empty()) << size;
  }
}

TEST(Tdms, EveryNumberInBothByteOrders) {
  for (const bool big : {false, true}) {
    TdmsWriter w(big);
    const Numbers numbers{1, 2, 3, 100};
    std::vector<std::string> objects;
    std::string data;
    const auto add = [&]<class Stored>(std::uint32_t type, Stored) {
      objects.push_back(w.object("/'g'/'" + std::to_string(type) + "'", w.index(type, 4)));
      data += raw<Stored>(numbers, big);
    };
    add(i8, std::int8_t{});
    add(i16, std::int16_t{});
    add(i32, std::int32_t{});
    add(i64, std::int64_t{});
    add(u8, std::uint8_t{});
    add(u16, std::uint16_t{});
    add(u32, std::uint32_t{});
    add(u64, std::uint64_t{});
    add(f32, float{});
    add(f64, double{});
    add(0x19, float{});
    add(0x1a, double{});
    add(boolean, std::uint8_t{});
    w.segment(TdmsWriter::usual, objects, data);
    const auto file = parsed(w);
    ASSERT_EQ(file.channels.size(), 13u) << skipped(file);
    for (const auto& channel : file.channels) EXPECT_EQ(values(file, channel.name), numbers) << channel.name;
  }
}

TEST(Tdms, TimesUnitsAndNamesOfWaveforms) {
  TdmsWriter w;
  const auto start = [&](std::int64_t seconds, std::uint64_t fraction) {
    return w.text("wf_start_time") + w.word(time_type) + w.time(seconds, fraction);
  };
  w.segment(TdmsWriter::usual,
            {w.object("/", w.no_data()), w.object("/'g1'", w.no_data()),
             w.object("/'g1'/'x'", w.index(f64, 3),
                      {w.property("wf_increment", 0.01), w.property("wf_start_offset", 0.5),
                       w.property("unit_string", "g"), w.property("description", "top"), start(3600000000, 0)}),
             w.object("/'g2'/'x'", w.index(f64, 3),
                      {w.property("wf_increment", 0.02), start(3600000001, std::uint64_t{1} << 62)}),
             w.object("/'g2'/'it''s [mm]'", w.index(f64, 3))},
            raw<double>({1, 2, 3, 4, 5, 6, 7, 8, 9}));
  const auto file = parsed(w);
  ASSERT_EQ(file.channels.size(), 3u);
  EXPECT_EQ(file.channels[0].name, "g1/x");
  EXPECT_EQ(file.channels[0].unit, "g");
  EXPECT_EQ(file.channels[0].description, "top");
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.01);
  EXPECT_DOUBLE_EQ(file.channels[0].start, 0.5);
  EXPECT_EQ(file.channels[1].name, "g2/x");
  EXPECT_DOUBLE_EQ(file.channels[1].start, 1.25);
  EXPECT_EQ(file.channels[2].name, "it's");
  EXPECT_EQ(file.channels[2].unit, "mm");
  EXPECT_EQ(file.channels[2].interval, 0.0);
}

TEST(Tdms, TimeStampsOfAFractionOfANanosecondAreTheTimesOfTheirGroup) {
  TdmsWriter w;
  std::string data;
  const double step = 1e-9;
  for (int k = 0; k < 4; ++k)
    data += w.time(3800000000, static_cast<std::uint64_t>(std::ldexp(k * step + (k == 2 ? 3e-10 : 0.0), 64)));
  w.segment(TdmsWriter::usual, {w.object("/'g'/'stamp'", w.index(time_type, 4)), w.object("/'g'/'y'", w.index(f64, 4))},
            data + raw<double>({1, 2, 3, 4}));
  const auto file = parsed(w);
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(file.channels[0].unit, "s");
  ASSERT_EQ(file.channels[1].times.size(), 4);
  EXPECT_NEAR(file.channels[1].times[2], 2.3e-9, 1e-18);
  EXPECT_NEAR(file.channels[1].times[3], 3e-9, 1e-18);
}

TEST(Tdms, UnevenStampsOfTheSmallestUnitStayUneven) {
  TdmsWriter w;
  std::string data;
  for (const std::uint64_t fraction : {0, 1, 2, 5, 9}) data += w.time(3800000000, fraction);
  w.segment(TdmsWriter::usual, {w.object("/'g'/'stamp'", w.index(time_type, 5)), w.object("/'g'/'y'", w.index(f64, 5))},
            data + raw<double>({1, 2, 3, 4, 5}));
  const auto file = parsed(w);
  ASSERT_EQ(file.channels.at(1).times.size(), 5);
  EXPECT_DOUBLE_EQ(file.channels[1].times[3], std::ldexp(5.0, -64));
}

TEST(Tdms, AColumnOfTimesServesItsGroup) {
  TdmsWriter w;
  w.segment(TdmsWriter::usual, {w.object("/'g'/'Time'", w.index(f64, 4)), w.object("/'g'/'y'", w.index(f64, 4))},
            raw<double>({0.0, 0.1, 0.2, 0.3, 1, 2, 3, 4}));
  const auto file = parsed(w);
  EXPECT_DOUBLE_EQ(file.channels.back().interval, 0.1);
  EXPECT_EQ(file.channels.back().times.size(), 0);
}

TEST(Tdms, TextsAreSkippedAndListed) {
  TdmsWriter w;
  const auto texts =
      w.word(20 + 8) + w.word(text_type) + w.word(1) + w.number<std::uint64_t>(2) + w.number<std::uint64_t>(13);
  w.segment(TdmsWriter::usual, {w.object("/'g'/'remark'", texts), w.object(first, w.index(i32, 2))},
            w.word(2) + w.word(5) + "hello" + ints({7, 8}));
  const auto file = parsed(w);
  ASSERT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(values(file, "a"), (Numbers{7, 8}));
  EXPECT_NE(skipped(file).find("'g/remark' holds 2 texts"), std::string::npos) << skipped(file);
}

TEST(Tdms, ValuesAlongAFrequencyAxisAreAFunction) {
  TdmsWriter w;
  w.segment(TdmsWriter::usual,
            {w.object("/'g'/'h'", w.index(0x10000d, 2),
                      {w.property("wf_increment", 0.5), w.property("wf_start_offset", 2.0),
                       w.property("wf_xunit_string", "Hz")}),
             w.object("/'g'/'z'", w.index(0x08000c, 2))},
            raw<double>({1, 2, 3, 4}) + raw<float>({1, 2, 3, 4}));
  const auto file = parsed(w);
  ASSERT_EQ(file.functions.size(), 1u);
  EXPECT_EQ(file.functions[0].lines, Eigen::Vector2d(2.0, 2.5));
  EXPECT_EQ(file.functions[0].values[1], std::complex<double>(3, 4));
  EXPECT_NE(skipped(file).find("'g/z' holds complex numbers"), std::string::npos) << skipped(file);
}

// --- scales ---

struct ScaledChannel {
  TdmsWriter w;
  std::vector<std::string> properties;

  void set(int scale, const std::string& name, double value) {
    properties.push_back(w.property("NI_Scale[" + std::to_string(scale) + "]_" + name, value));
  }
  void type(int scale, const std::string& name) {
    properties.push_back(w.property("NI_Scale[" + std::to_string(scale) + "]_Scale_Type", name));
  }
  MeasuredFile read(int scales, bool at_group = false) {
    properties.push_back(w.property("NI_Number_Of_Scales", scales));
    const std::vector<std::string> none;
    w.segment(TdmsWriter::usual,
              {w.object("/'group'", w.no_data(), at_group ? properties : none),
               w.object(first, w.index(i16, 3), at_group ? none : properties)},
              raw<std::int16_t>({1, 2, 4}));
    return parsed(w);
  }
};

TEST(Tdms, LinearAndPolynomialScalesFollowEachOther) {
  for (const bool at_group : {false, true}) {
    ScaledChannel c;
    c.type(0, "Linear");
    c.set(0, "Linear_Slope", 2.0);
    c.set(0, "Linear_Y_Intercept", 10.0);
    c.set(0, "Linear_Input_Source", 4294967295.0);
    c.type(1, "Polynomial");
    c.set(1, "Polynomial_Coefficients_Size", 3);
    for (int i = 0; i < 3; ++i) c.set(1, "Polynomial_Coefficients[" + std::to_string(i) + "]", i + 1.0);
    c.set(1, "Polynomial_Input_Source", 0.0);
    const auto expected = [](double raw) {
      return 1.0 + 2.0 * (10.0 + 2.0 * raw) + 3.0 * std::pow(10.0 + 2.0 * raw, 2);
    };
    EXPECT_EQ(values(c.read(2, at_group), "a"), (Numbers{expected(1), expected(2), expected(4)}));
  }
}

TEST(Tdms, TableScalesInterpolateAndHoldBeyondTheirEnds) {
  ScaledChannel c;
  c.type(0, "Table");
  c.set(0, "Table_Scaled_Values_Size", 3);
  c.set(0, "Table_Pre_Scaled_Values_Size", 3);
  const Numbers inputs{3, 2, 1.5}, outputs{30, 10, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    c.set(0, "Table_Scaled_Values[" + std::to_string(i) + "]", inputs[i]);
    c.set(0, "Table_Pre_Scaled_Values[" + std::to_string(i) + "]", outputs[i]);
  }
  EXPECT_EQ(values(c.read(1), "a"), (Numbers{0, 10, 30}));
}

TEST(Tdms, AddedAndSubtractedScales) {
  for (const std::string kind : {"Add", "Subtract"}) {
    ScaledChannel c;
    c.type(0, "Linear");
    c.set(0, "Linear_Slope", 10.0);
    c.set(0, "Linear_Y_Intercept", 0.0);
    c.type(1, kind);
    c.set(1, kind + "_Left_Operand_Input_Source", 0.0);
    c.set(1, kind + "_Right_Operand_Input_Source", 4294967295.0);
    EXPECT_EQ(values(c.read(2), "a"), kind == "Add" ? (Numbers{11, 22, 44}) : (Numbers{-9, -18, -36}));
  }
}

TEST(Tdms, ScalesOfTemperatureSensorsAndCirclesAreListed) {
  ScaledChannel c;
  c.type(0, "RTD");
  c.w.segment(TdmsWriter::usual, {c.w.object(second, c.w.index(i16, 1))}, raw<std::int16_t>({5}));
  const auto file = c.read(1);
  EXPECT_EQ(file.channels.size(), 1u);
  EXPECT_NE(skipped(file).find("'group/a' is left out: its scale 'RTD' is not supported"), std::string::npos)
      << skipped(file);
  ScaledChannel circle;
  circle.w.segment(TdmsWriter::usual, {circle.w.object(second, circle.w.index(i16, 1))}, raw<std::int16_t>({5}));
  circle.type(0, "Linear");
  circle.set(0, "Linear_Slope", 1.0);
  circle.set(0, "Linear_Y_Intercept", 1.0);
  circle.set(0, "Linear_Input_Source", 0.0);
  EXPECT_NE(skipped(circle.read(1)).find("circle"), std::string::npos);
}

// --- DAQmx ---

struct DaqmxScaler {
  std::uint32_t type, buffer, offset, id;
};

std::string daqmx_index(const TdmsWriter& w, double count, const std::vector<DaqmxScaler>& scalers,
                        const std::vector<std::uint32_t>& widths, bool digital = false) {
  std::string bytes =
      w.word(digital ? 0x1369 : 0x1269) + w.word(0xffffffffu) + w.word(1) + w.number<std::uint64_t>(count);
  bytes += w.word(static_cast<std::uint32_t>(scalers.size()));
  for (const auto& s : scalers)
    bytes += w.word(s.type) + w.word(s.buffer) + w.word(s.offset) + (digital ? std::string(1, '\0') : w.word(0)) +
             w.word(s.id);
  bytes += w.word(static_cast<std::uint32_t>(widths.size()));
  for (const auto width : widths) bytes += w.word(width);
  return bytes;
}

constexpr auto daqmx_flags = TdmsWriter::usual | TdmsWriter::daqmx;

TEST(Tdms, DaqmxChannelsShareTheRowsOfABuffer) {
  TdmsWriter w;
  // scalers of 16 bit; the scale of the second turns counts into volts
  w.segment(daqmx_flags,
            {w.object(first, daqmx_index(w, 2, {{3, 0, 0, 0}}, {4})),
             w.object(second, daqmx_index(w, 2, {{3, 0, 2, 0}}, {4}),
                      {w.property("NI_Number_Of_Scales", 2.0), w.property("NI_Scale[1]_Scale_Type", "Linear"),
                       w.property("NI_Scale[1]_Linear_Slope", 0.5), w.property("NI_Scale[1]_Linear_Y_Intercept", 1.0),
                       w.property("NI_Scale[1]_Linear_Input_Source", 0.0)})},
            raw<std::int16_t>({1, -2, 3, -4, 5, -6, 7, -8}));
  w.segment(TdmsWriter::raw_data | TdmsWriter::daqmx, {}, raw<std::int16_t>({9, -10, 11}));
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 3, 5, 7, 9}));
  EXPECT_EQ(values(file, "b"), (Numbers{0, -1, -2, -3, -4}));
}

TEST(Tdms, DaqmxBuffersOfSeveralCardsFollowEachOther) {
  TdmsWriter w;
  w.segment(daqmx_flags,
            {w.object(first, daqmx_index(w, 2, {{3, 0, 0, 0}}, {2, 4})),
             w.object(second, daqmx_index(w, 2, {{5, 1, 0, 0}}, {2, 4}))},
            raw<std::int16_t>({1, 2}) + ints({10, 20}) + raw<std::int16_t>({3, 4}) + ints({30, 40}));
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 2, 3, 4}));
  EXPECT_EQ(values(file, "b"), (Numbers{10, 20, 30, 40}));
}

TEST(Tdms, DaqmxDigitalLinesAreBits) {
  TdmsWriter w;
  w.segment(daqmx_flags,
            {w.object(first, daqmx_index(w, 4, {{0, 0, 0, 0}}, {2}, true)),
             w.object(second, daqmx_index(w, 4, {{0, 0, 10, 0}}, {2}, true))},
            std::string("\x01\x00\x00\x04\x01\x04\x02\x03", 8));
  const auto file = parsed(w);
  EXPECT_EQ(values(file, "a"), (Numbers{1, 0, 1, 0}));
  EXPECT_EQ(values(file, "b"), (Numbers{0, 1, 1, 0}));
}

TEST(Tdms, DaqmxScalersOfOneChannelAreAdded) {
  TdmsWriter w;
  w.segment(daqmx_flags,
            {w.object(first, daqmx_index(w, 2, {{3, 0, 0, 0}, {3, 0, 2, 1}}, {4}),
                      {w.property("NI_Number_Of_Scales", 3.0), w.property("NI_Scale[2]_Scale_Type", "Add"),
                       w.property("NI_Scale[2]_Add_Left_Operand_Input_Source", 0.0),
                       w.property("NI_Scale[2]_Add_Right_Operand_Input_Source", 1.0)})},
            raw<std::int16_t>({1, 10, 2, 20}));
  EXPECT_EQ(values(parsed(w), "a"), (Numbers{11, 22}));
}

TEST(Tdms, AScalerOutsideOfItsBufferIsDamage) {
  auto w = two_channels();
  w.segment(daqmx_flags, {w.object(first, daqmx_index(w, 2, {{3, 0, 3, 0}}, {4}))}, raw<std::int16_t>({1, 2, 3, 4}));
  EXPECT_NE(skipped(parsed(w)).find("outside of its buffer"), std::string::npos);
}

// --- size and damage ---

TEST(Tdms, FiveMillionChunksOfOneSampleTakeLessThanTwoSeconds) {
  constexpr int chunks = 5'000'000;
  for (const bool segments : {false, true}) {
    TdmsWriter w;
    const int in_one = segments ? 1 : chunks;
    w.segment(TdmsWriter::usual, {w.object(first, w.index(f64, 1))}, std::string(std::size_t(in_one) * 8, '\0'));
    if (segments) {
      TdmsWriter other;
      other.segment(TdmsWriter::raw_data, {}, raw<double>({2.5}));
      w.bytes.reserve(w.bytes.size() + std::size_t(chunks) * other.bytes.size());
      for (int k = 1; k < chunks; ++k) w.bytes += other.bytes;
    }
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(parsed(w).channels.front().values.size(), chunks);
    const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    RecordProperty(segments ? "segments_s" : "chunks_s", std::to_string(taken));
    EXPECT_LT(taken, 2.0);
  }
}

TEST(Tdms, OtherFilesAreRefused) {
  const auto refusal = [](const std::string& bytes) {
    try {
      parse_tdms(bytes, "x.tdms");
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal("hello").find("the file is no TDMS file"), std::string::npos);
  EXPECT_NE(refusal("TDSh").find("index of a TDMS file"), std::string::npos);
  EXPECT_NE(refusal("TDSm").find("holds no samples"), std::string::npos);
  TdmsWriter w;
  w.segment(TdmsWriter::metadata | TdmsWriter::new_list, {w.object(first, w.no_data())}, "");
  EXPECT_NE(refusal(w.bytes).find("holds no samples"), std::string::npos);
}

TEST(Tdms, AThousandDamagedFilesAreReadInPartOrRefused) {
  auto w = two_channels();
  w.segment(daqmx_flags, {w.object(third, daqmx_index(w, 2, {{3, 0, 0, 0}}, {4}), {w.property("wf_increment", 0.1)})},
            raw<std::int16_t>({1, 2, 3, 4}));
  w.segment(TdmsWriter::usual | TdmsWriter::interleaved, {w.object(first, w.index(f64, 2))}, raw<double>({1, 2, 3, 4}));
  std::mt19937 random(1);
  int read = 0;
  for (int i = 0; i < 1000; ++i) {
    auto bytes = w.bytes;
    for (auto changes = 1 + random() % 3; changes > 0; --changes) bytes[random() % bytes.size()] = char(random());
    if (i % 3 == 0) bytes.resize(random() % bytes.size());
    try {
      parse_tdms(bytes, "x.tdms");
      ++read;
    } catch (const InvalidInput&) {
    }
  }
  EXPECT_GT(read, 300);
}

}  // namespace
}  // namespace kalfem
