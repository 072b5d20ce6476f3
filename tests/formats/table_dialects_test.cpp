// SPDX-License-Identifier: Apache-2.0
// Encodings, dates, names of times and preambles of tables, as programs write them.
#include <gtest/gtest.h>

#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/formats/tables/date_time.hpp"
#include "kalfem/formats/tables/measured_table.hpp"
#include "kalfem/formats/tables/table_titles.hpp"

namespace kalfem {
namespace {

using Numbers = std::vector<double>;

/// Characters of two bytes, the first or the second one zero.
std::string in_utf16(std::u16string_view text, bool big_endian) {
  std::string bytes;
  for (const char16_t unit : text)
    for (const int shift : {big_endian ? 8 : 0, big_endian ? 0 : 8}) bytes += static_cast<char>(unit >> shift & 0xff);
  return bytes;
}

class TableDialects : public testing::Test {
protected:
  std::filesystem::path write(const std::string& bytes) const {
    std::ofstream(folder_ / "run.csv", std::ios::binary) << bytes;
    return folder_ / "run.csv";
  }
  MeasuredFile read(const std::string& bytes) const { return read_measured_file(write(bytes)); }
  static Numbers values(const MeasuredChannel& channel) { return {channel.values.begin(), channel.values.end()}; }
  ScratchFolder folder_{"table_dialects"};
};

TEST_F(TableDialects, TitlesAreReadInEveryEncoding) {
  const std::u16string text = u"Zeit [s];Winkel [°];Weg [µm]\r\n0,0;1,5;2\r\n0,5;2,5;3\r\n1,0;3,5;4\r\n";
  const std::string latin1 = "Zeit [s];Winkel [\xB0];Weg [\xB5m]\r\n0,0;1,5;2\r\n0,5;2,5;3\r\n1,0;3,5;4\r\n";
  for (const std::string& bytes : {in_utf16(u"\uFEFF" + text, false), in_utf16(u"\uFEFF" + text, true),
                                   in_utf16(text, false), latin1, utf8_of(text)}) {
    const auto file = read(bytes);
    ASSERT_EQ(file.channels.size(), 2u);
    EXPECT_EQ(file.channels[0].unit, "°");
    EXPECT_EQ(file.channels[1].unit, "µm");
    EXPECT_EQ(values(file.channels[0]), (Numbers{1.5, 2.5, 3.5}));
    EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.5);
    const Record record =
        read_record_file(write(bytes), {{.column = "Weg [µm]", .owner = "sensors.w", .unit = "m"}}, {});
    EXPECT_DOUBLE_EQ(record.values(0, 2), 4e-6);
  }
}

TEST_F(TableDialects, LinesMayEndInCarriageReturnsAlone) {
  EXPECT_EQ(values(read("t,a\r0,1\r1,2\r2,3\r").channels.at(0)), (Numbers{1, 2, 3}));
}

TEST_F(TableDialects, NumbersMayHaveFortransExponentsOrQuotedDecimalCommas) {
  EXPECT_EQ(values(read(" t a\n 0.0D+00 1.0D+00\n 1.0D+00 2.5D-01\n 2.0D+00 -3.D0\n").channels.at(0)),
            (Numbers{1, 0.25, -3}));
  EXPECT_EQ(values(read("\"t\",\"a\"\n\"0,0\",\"1,5\"\n\"0,1\",\"2,5\"\n\"0,2\",\"3,5\"\n").channels.at(0)),
            (Numbers{1.5, 2.5, 3.5}));
}

TEST_F(TableDialects, TimesHaveManyNames) {
  const std::string rows = ",a\n0,1\n0.1,2\n0.35,3\n0.4,4\n0.5,5\n0.6,6\n";  // uneven: evenness does not give them away
  for (const char* name : {"Elapsed Time (s)", "Temps", "time stamp [s]", "\"Time, s\"", "Time / s", "t1", "run_time",
                           "Zeit  1 - Standardabtastrate [s]"}) {
    const auto file = read(name + rows);
    ASSERT_EQ(file.channels.size(), 1u) << name;
    EXPECT_EQ(file.channels[0].times.size(), 6) << name;
    const Record record =
        read_record_file(folder_ / "run.csv", {{.column = "a", .owner = "sensors.a", .unit = "m"}}, {.missing = true});
    EXPECT_EQ(record.values.rows(), 1);
  }
  EXPECT_DOUBLE_EQ(read("time_ms,a\n0,1\n100,2\n350,3\n").channels.at(0).times[2], 0.35);
}

TEST_F(TableDialects, NamesAloneMakeNoTimes) {
  EXPECT_EQ(read("Time constant,a\n3,1\n2,2\n5,3\n").channels.size(), 2u);                // does not increase
  EXPECT_EQ(read("t,a,Time of flight [mm]\n0,1,1\n1,2,2\n2,3,3\n").channels.size(), 2u);  // no unit of time
  EXPECT_EQ(read("t,T [K]\n0,290\n1,291\n2,292\n").channels.size(), 1u);                  // a temperature
}

TEST_F(TableDialects, ChannelsMayHaveTimesOfTheirOwnByNumberOrName) {
  for (const char* titles :
       {"Time 1 [s],a,Time 2 [s],b", "Time a,a,Time b,b", "a_time,a,b_time,b", "Time,a,Time.1,b"}) {
    const auto file = read(std::string(titles) + "\n0,1,5,10\n1,2,5.5,11\n2,3,6,12\n3,4,,\n");
    ASSERT_EQ(file.channels.size(), 2u) << titles;
    EXPECT_DOUBLE_EQ(file.channels[1].start, 5.0);
    EXPECT_DOUBLE_EQ(file.channels[1].interval, 0.5);
  }
}

TEST_F(TableDialects, DatesAndTimesOfDayAreTimes) {
  for (const char* rows :
       {"2024-03-05T14:02:03.25,1\n2024-03-05T14:02:03.75,2\n2024-03-05T14:02:04.25,3\n",
        "3/5/2024 2:02:03.25 PM,1\n3/5/2024 2:02:03.75 PM,2\n3/5/2024 2:02:04.25 PM,3\n",
        "23:59:59.25,1\n23:59:59.75,2\n00:00:00.25,3\n",
        "2024-03-05T14:02:03.25+01:00,1\n2024-03-05T14:02:03.75+01:00,2\n2024-03-05T13:02:04.25Z,3\n",
        "31/12/2024 23:59:59.25,1\n31/12/2024 23:59:59.75,2\n01/01/2025 00:00:00.25,3\n"}) {
    const auto file = read(std::string("Stamp,a [g]\n") + rows);
    ASSERT_EQ(file.channels.size(), 1u) << rows;
    EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.5) << rows;
    EXPECT_EQ(file.channels[0].unit, "g");
    EXPECT_EQ(file.notes.size(), 1u);  // from when on
  }
  const auto german =
      read("Zeit;a\n05.03.2024 14:02:03,25;1,5\n05.03.2024 14:02:03,75;2,5\n05.03.2024 14:02:04,25;3\n");
  EXPECT_EQ(values(german.channels.at(0)), (Numbers{1.5, 2.5, 3}));
  EXPECT_DOUBLE_EQ(german.channels[0].interval, 0.5);
  const auto apart = read("Date,Time,a\n2024-03-05,14:02:03,1\n2024-03-05,14:02:04,2\n2024-03-05,14:02:05,3\n");
  EXPECT_DOUBLE_EQ(apart.channels.at(0).interval, 1.0);
  EXPECT_EQ(apart.skipped.size(), 1u);
}

TEST_F(TableDialects, ADamagedDateIsNamedWithItsLine) {
  try {
    read("Stamp,a\n10:00:00,1\n10:00:61,2\n10:00:02,3\n10:00:03,4\n");
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("run.csv:3: column 'Stamp' holds '10:00:61'"), std::string::npos)
        << error.what();
  }
}

TEST_F(TableDialects, NamesMayStandInTheLastComment) {
  const auto file = read("# bench 4\n# t, acc [g], b\n0.0 1 4\n0.5 2 5\n1.0 3 6\n");
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(file.channels[0].name, "acc");
  EXPECT_EQ(file.channels[0].unit, "g");
  EXPECT_EQ(file.channels[0].other_names, std::vector<std::string>{"column_2"});
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.5);
  EXPECT_EQ(read("# two words\n0 1\n1 2\n2 4\n").channels.at(0).other_names.at(0), "column_2");
}

TEST_F(TableDialects, ARateAboveTheTableCountsWhereThereAreNoTimes) {
  const std::string rows = "\na,b\n1,5\n3,2\n2,7\n";
  EXPECT_DOUBLE_EQ(read("Bench\nSample rate: 1000 Hz\n" + rows).channels.at(0).interval, 1e-3);
  EXPECT_DOUBLE_EQ(read("Sampling frequency [kHz],2\n" + rows).channels.at(0).interval, 5e-4);
  EXPECT_DOUBLE_EQ(read("dt = 2 ms\nBench\n" + rows).channels.at(0).interval, 2e-3);
  EXPECT_EQ(read("Bench 1000\nOffset: 2\n" + rows).channels.at(0).interval, 0.0);
  EXPECT_EQ(stated_rate("Abtastrate;0,5;Hz", ','), 0.5);
  EXPECT_FALSE(stated_rate("offset 7", '.'));
}

TEST_F(TableDialects, ANumberThatIsCutOffIsLeftOut) {
  std::string text = "t,a\n";
  for (int i = 0; i < 40; ++i) text += std::to_string(i) + ",1.250\n";
  EXPECT_EQ(read(text).channels.at(0).values.size(), 40);
  text.pop_back();
  EXPECT_EQ(read(text).channels.at(0).values.size(), 40);  // without a line end, but with all digits
  text.pop_back();
  const auto cut = read(text);
  EXPECT_EQ(cut.channels.at(0).values.size(), 39);
  EXPECT_EQ(cut.notes.size(), 1u);
}

TEST_F(TableDialects, UnitsMayBeWrittenOut) {
  const auto file = read("t,a [Volts],b [Newtons],a [V]\n0,1,4,1\n1,2,5,2\n2,3,6,3\n");
  EXPECT_EQ(file.channels.at(0).unit, "V");
  EXPECT_EQ(file.channels.at(1).unit, "N");
}

TEST(DateTimes, AreThoseThatProgramsWrite) {
  EXPECT_EQ(parse_date_time("1970-01-02")->days, 1);
  EXPECT_DOUBLE_EQ(parse_date_time("12:00:00.125 AM")->seconds, 0.125);
  EXPECT_DOUBLE_EQ(parse_date_time("14:02:03:250")->seconds, 50523.25);
  EXPECT_DOUBLE_EQ(parse_date_time("2024-01-01 10:00:00-0530")->seconds, 15.5 * 3600);
  EXPECT_EQ(parse_date_time("05/03/2024", DateOrder::day_first)->days, parse_date_time("2024-03-05")->days);
  for (const char* text : {"", "1.5", "10", "24/13/2024", "2024-02-30", "10:60:00", "10:00:00 x", "12.5:00", "1/2/3"})
    EXPECT_FALSE(parse_date_time(text)) << text;
}

}  // namespace
}  // namespace kalfem
