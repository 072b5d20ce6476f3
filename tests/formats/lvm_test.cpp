// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/lvm.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/record_file.hpp"

// What LabVIEW programs leave on a disk, beside what their headers promise.
namespace kalfem {
namespace {

using Numbers = std::vector<double>;

class LvmFiles : public testing::Test {
protected:
  MeasuredFile read(const std::string& text) const { return read_lvm(write(text)); }

  std::filesystem::path write(const std::string& text) const {
    std::ofstream(folder_ / "run.lvm", std::ios::binary) << text;
    return folder_ / "run.lvm";
  }

  Record as_record(const std::string& text) const {
    const std::vector<WantedChannel> wanted = {{.column = "a", .owner = "sensors.a", .unit = "m/s^2"},
                                               {.column = "b", .owner = "sensors.b", .unit = "m"}};
    return read_record_file(write(text), wanted, {.missing = true});
  }

  std::string refusal_as_record(const std::string& text) const {
    try {
      as_record(text);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  static std::string file_header(const std::string& x_columns = "One", const std::string& separator = "Tab",
                                 const std::string& decimal = ".") {
    const char cell = separator == "Comma" ? ',' : '\t';
    const auto line = [&](const std::string& key, const std::string& value) { return key + cell + value + "\r\n"; };
    return line("LabVIEW Measurement", "") + line("Writer_Version", "2") + line("Separator", separator) +
           line("Decimal_Separator", decimal) + line("Multi_Headings", "Yes") + line("X_Columns", x_columns) +
           "***End_of_Header***\t\r\n\t\r\n";
  }

  static std::string segment(const std::string& samples, const std::string& rows, const std::string& start = "0\t0",
                             const std::string& titles = "X_Value\ta\tb\tComment") {
    return "Channels\t2\r\nSamples\t" + samples + "\r\nY_Unit_Label\tg\tmm\r\nX0\t" + start +
           "\r\nDelta_X\t0.1\t0.1\r\n***End_of_Header***\r\n" + titles + "\r\n" + rows;
  }

  static Numbers values(const MeasuredFile& file, std::size_t channel) {
    return {file.channels[channel].values.begin(), file.channels[channel].values.end()};
  }

  ScratchFolder folder_{"lvm"};
};

TEST_F(LvmFiles, KeepTheirIntervalAndUnits) {
  const auto file = read(file_header() + segment("3\t3", "0\t1\t4\r\n0.1\t2\t5\r\n0.2\t3\t6\r\n"));
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(values(file, 1), (Numbers{4, 5, 6}));
  EXPECT_EQ(file.channels[1].unit, "mm");
  EXPECT_EQ(file.channels[0].interval, 0.1);
  EXPECT_TRUE(file.notes.empty());
}

// "Separator,," and "Separator;;" write the separator as itself, with and without the cell behind it.
TEST_F(LvmFiles, NameTheirSeparatorOrWriteItAsItself) {
  const std::string text = file_header() + segment("3\t3", "0\t1.5\t4\r\n0.1\t2.5\t5\r\n0.2\t3.5\t6\r\n");
  for (const char separator : {'\t', ',', ';'}) {
    for (const std::string& said : {std::string(separator == '\t'  ? "Tab"
                                                : separator == ',' ? "Comma"
                                                                   : "Semicolon"),
                                    std::string(1, separator), std::string()}) {
      std::string written = text;
      written.replace(written.find("Tab"), 3, said);
      std::ranges::replace(written, '\t', separator);
      const auto file = read(written);
      ASSERT_EQ(file.channels.size(), 2u) << separator << said;
      EXPECT_EQ(values(file, 0), (Numbers{1.5, 2.5, 3.5})) << separator << said;
      EXPECT_EQ(values(file, 1), (Numbers{4, 5, 6})) << separator << said;
      EXPECT_EQ(file.channels[0].name, "a") << separator << said;
    }
  }
}

TEST_F(LvmFiles, HaveDecimalCommasBehindASemicolon) {
  std::string text = file_header("One", ";", ",") + segment("2\t2", "0\t1,5\t4\r\n0,1\t2,5\t5\r\n");
  std::ranges::replace(text, '\t', ';');
  const auto file = read(text);
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(values(file, 0), (Numbers{1.5, 2.5}));
}

TEST_F(LvmFiles, LoseTheLastLineOnlyWhereItWasCut) {
  const std::string rows = "0\t1\t4\t\r\n0.1\t2\t5\t\r\n";
  for (const std::string last : {"0.2", "0.2\t3", "0.2\t3\t6"}) {
    const auto file = read(file_header() + segment("40\t40", rows + last));
    EXPECT_EQ(values(file, 1), (Numbers{4, 5})) << last;
    ASSERT_EQ(file.notes.size(), 2u) << last;
    EXPECT_NE(file.notes[0].find("run.lvm:18: the last line is cut off"), std::string::npos) << file.notes[0];
    EXPECT_NE(file.notes[1].find("declares 40 samples, the file contains 2"), std::string::npos) << file.notes[1];
  }
  EXPECT_EQ(values(read(file_header() + segment("3\t3", rows + "0.2\t3\t6")), 1), (Numbers{4, 5, 6}));
}

TEST_F(LvmFiles, MayHaveMoreLinesThanTheyDeclare) {
  const auto file = read(file_header() + segment("1\t1", "0\t1\t4\r\n0.1\t2\t5\r\n"));
  EXPECT_EQ(values(file, 0), (Numbers{1, 2}));
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST_F(LvmFiles, HaveTheTimesOfTheirSamplesWhereTheseAreUneven) {
  const auto file = read(file_header() + segment("4\t4", "0\t1\t1\r\n0.1\t2\t2\r\n0.25\t3\t3\r\n0.3\t4\t4\r\n"));
  ASSERT_EQ(file.channels[0].times.size(), 4);
  EXPECT_EQ(file.channels[0].times[2], 0.25);
  EXPECT_EQ(file.channels[0].interval, 0.0);
  EXPECT_NE(refusal_as_record(file_header() + segment("4\t4", "0\t1\t1\r\n0.1\t2\t2\r\n0.25\t3\t3\r\n0.3\t4\t4\r\n"))
                .find("runs from 0.1 s to 0.25 s"),
            std::string::npos);
}

TEST_F(LvmFiles, HaveTheIntervalOfTheirTimesWhereTheHeaderContradicts) {
  const auto file = read(file_header() + segment("3\t3", "0\t1\t1\r\n0.05\t2\t2\r\n0.1\t3\t3\r\n"));
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.05);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("Delta_X is 0.1 s, but X_Value advances by 0.05 s"), std::string::npos) << file.notes[0];
}

TEST_F(LvmFiles, MayHaveTimesForEachChannel) {
  const auto file = read(file_header("Multi") + segment("3\t2", "0\t1\t0.5\t4\r\n0.1\t2\t0.7\t5\r\n0.2\t3\t\t\r\n",
                                                        "0\t0", "X_Value\ta\tX_Value\tb\tComment"));
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(values(file, 0), (Numbers{1, 2, 3}));
  EXPECT_EQ(values(file, 1), (Numbers{4, 5}));
  EXPECT_DOUBLE_EQ(file.channels[1].start, 0.5);
  EXPECT_DOUBLE_EQ(file.channels[1].interval, 0.2);
  const Record record =
      as_record(file_header("Multi") + segment("3\t2", "0\t1\t0.5\t4\r\n0.1\t2\t0.7\t5\r\n0.2\t3\t\t\r\n", "0\t0",
                                               "X_Value\ta\tX_Value\tb\tComment"));
  EXPECT_DOUBLE_EQ(record.sample_rate, 10.0);
  ASSERT_EQ(record.samples(), 8);
  EXPECT_DOUBLE_EQ(record.values(1, 7), 5e-3);
  EXPECT_TRUE(std::isnan(record.values(1, 6)));
}

TEST_F(LvmFiles, MayHaveNoTimes) {
  const auto file = read(file_header("No") + segment("2\t2", "\t1\t4\r\n\t2\t5\r\n", "3\t3", "\ta\tb\tComment"));
  EXPECT_EQ(values(file, 1), (Numbers{4, 5}));
  EXPECT_EQ(file.channels[1].start, 3.0);
  EXPECT_EQ(file.channels[1].interval, 0.1);
}

TEST_F(LvmFiles, JoinSegmentsThatGoOn) {
  const auto file = read(file_header() + segment("2\t2", "0\t1\t4\r\n0.1\t2\t5\r\n\r\n") +
                         segment("2\t2", "0.2\t3\t6\r\n0.3\t9\t9\r\n") + segment("1\t1", "0.9\t3\t6\r\n"));
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(values(file, 0), (Numbers{1, 2, 3, 9, 3}));
  ASSERT_EQ(file.channels[0].times.size(), 5);
  EXPECT_EQ(file.channels[0].times[4], 0.9);
}

TEST_F(LvmFiles, NumberSegmentsThatBeginAgain) {
  const std::string text =
      file_header() + segment("2\t2", "0\t1\t4\r\n0.1\t2\t5\r\n") + segment("2\t2", "0\t3\t6\r\n0.1\t9\t9\r\n");
  const auto file = read(text);
  ASSERT_EQ(file.channels.size(), 4u);
  EXPECT_EQ(file.channels[0].name, "a (segment 1)");
  EXPECT_EQ(file.channels[3].name, "b (segment 2)");
  EXPECT_EQ(values(file, 3), (Numbers{6, 9}));
}

TEST_F(LvmFiles, MayUseCommasAndSpecialBlocks) {
  const auto file =
      read(file_header("One", "Tab", ",") +
           "***Start_Special***\r\nChannels\t99\r\n***End_Special***\r\nChannels\t1\r\nSamples\t2\r\nX0\t3,6E+9\r\n"
           "Delta_X\t0,5\r\n***End_of_Header***\r\nX_Value\ta\tComment\r\n0,0\t1,5\r\n0,5\t2,5\r\n");
  ASSERT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(values(file, 0), (Numbers{1.5, 2.5}));
  EXPECT_EQ(file.channels[0].start, 0.0);  // not the seconds since 1904
  EXPECT_EQ(file.channels[0].interval, 0.5);
}

TEST_F(LvmFiles, SayWhichSegmentWasCutInItsHeader) {
  const auto file = read(file_header() + segment("2\t2", "0\t1\t4\r\n0.1\t2\t5\r\n") + "Channels\t2\r\nSamp");
  EXPECT_EQ(values(file, 0), (Numbers{1, 2}));
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("segment 2 is cut off"), std::string::npos);
}

TEST_F(LvmFiles, MayHaveAnotherDecimalSignThanTheirHeaderSays) {
  const auto file = read(file_header() + segment("2\t2", "0,0\t1,5\t4,0\r\n0,1\t2,5\t5,0\r\n"));
  EXPECT_EQ(values(file, 0), (Numbers{1.5, 2.5}));
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST_F(LvmFiles, MayHaveUnitsInTheirNames) {
  const auto file = read(file_header() + "Channels\t2\r\nSamples\t2\t2\r\nX0\t0\t0\r\nDelta_X\t0.1\t0.1\r\n" +
                         "***End_of_Header***\r\nX_Value\ta [g]\tWinkel (\xB0)\r\n0\t1\t2\r\n0.1\t2\t3\r\n");
  EXPECT_EQ(file.channels[0].name, "a");
  EXPECT_EQ(file.channels[0].unit, "g");
  EXPECT_EQ(file.channels[1].name, "Winkel");
  EXPECT_EQ(file.channels[1].unit, "\u00B0");
}

TEST_F(LvmFiles, MayLeaveOutTheCellsOfAChannelThatHasEnded) {
  const auto file = read(file_header() + segment("3\t1", "0\t1\t4\r\n0.1\t2\r\n0.2\t3\r\n"));
  EXPECT_EQ(values(file, 0), (Numbers{1, 2, 3}));
  EXPECT_EQ(values(file, 1), (Numbers{4}));
}

TEST_F(LvmFiles, WithoutAHeaderAreTables) {
  const auto file = read("0.0\t1\t4\r\n0.1\t2\t5\r\n0.2\t3\t6\r\n");
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(values(file, 1), (Numbers{4, 5, 6}));
  EXPECT_NEAR(file.channels[0].interval, 0.1, 1e-12);
}

TEST_F(LvmFiles, OfFrequencyAreFunctions) {
  const auto file =
      read(file_header() + "Channels\t1\r\nSamples\t2\r\nX_Dimension\tFrequency\r\nX0\t0\r\nDelta_X\t5\r\n" +
           "***End_of_Header***\r\nX_Value\ta\r\n0\t1\r\n5\t2\r\n");
  EXPECT_TRUE(file.channels.empty());
  ASSERT_EQ(file.functions.size(), 1u);
  EXPECT_EQ(file.functions[0].lines[1], 5.0);
  EXPECT_EQ(file.functions[0].values[1].real(), 2.0);
}

}  // namespace
}  // namespace kalfem
