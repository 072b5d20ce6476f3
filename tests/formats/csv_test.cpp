// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/csv.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/tables/lvm.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

class CsvFiles : public testing::Test {
protected:
  fs::path file(const std::string& text, const std::string& name = "record.csv") const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  ScratchFolder folder_{"csv"};
};

template <typename Read>
std::vector<Issue> issues_of(Read read) {
  try {
    read();
  } catch (const InvalidInput& error) {
    return error.issues();
  }
  return {};
}

TEST_F(CsvFiles, ReadsAPlainFile) {
  const auto series = read_csv(file("t,a [m/s2],b\n0.5,1,-2e-3\n0.6,+1.5,4\n0.7,2,.5\n"));
  EXPECT_DOUBLE_EQ(series.sample_rate, 10.0);
  EXPECT_DOUBLE_EQ(series.start, 0.5);
  ASSERT_EQ(series.channels.size(), 2u);
  EXPECT_EQ(series.channels[0].name, "a");
  EXPECT_EQ(series.channels[0].unit, "m/s2");
  EXPECT_EQ(series.values, (Eigen::MatrixXd(2, 3) << 1, 1.5, 2, -2e-3, 4, 0.5).finished());
}

TEST_F(CsvFiles, ReadsWhatOtherProgramsWrite) {
  const Eigen::MatrixXd expected = (Eigen::MatrixXd(2, 3) << 1.5, -3, 5, 2, 4e3, 6.25).finished();
  const std::string german =
      "\xEF\xBB\xBF# written by a spreadsheet\r\n\"Zeit\";\"a; b\";c;\r\n0,0;1,5;2;\r\n\r\n0,1;-3;4E3;\r\n% "
      "end\r\n0,2;5;6,25;\r\n";
  const auto series = read_csv(file(german));
  EXPECT_EQ(series.values, expected);
  EXPECT_EQ(series.channels[0].name, "a; b");
  EXPECT_EQ(series.sample_rate, 10.0);
  EXPECT_EQ(read_csv(file("time\ta\tc\n0\t1.5\t2\n1\t-3\t4e3\n2\t5\t6.25\n")).values, expected);
  EXPECT_EQ(read_csv(file("  t   a c\n 0  1.5 2\n 1 -3   4e3\n 2  5   6.25")).values, expected);
  EXPECT_EQ(read_csv(file("t [ms];a;c\n0;1.5;2\n1;-3;4e3\n2;5;6.25\n")).sample_rate, 1000.0);
}

TEST_F(CsvFiles, ReadsWithoutHeaderOrTime) {
  const auto path = file("1,2\n3,4\n5,6\n");
  const auto series = read_csv(path, {.sample_rate = 50});
  EXPECT_EQ(series.values.rows(), 2);
  EXPECT_EQ(series.channels[1].name, "column_2");
  EXPECT_EQ(series.sample_rate, 50.0);
  EXPECT_EQ(read_csv(path, {.time_column = "2"}).sample_rate, 0.5);
  EXPECT_EQ(read_csv(path, {.time_column = "column_1"}).start, 1.0);
  EXPECT_EQ(read_csv_table(path).values.rows(), 3);
  EXPECT_EQ(issues_of([&] { read_csv(path); }).size(), 1u);
  EXPECT_EQ(issues_of([&] { read_csv(path, {.time_column = "3"}); }).empty(), false);
}

TEST_F(CsvFiles, ChosenColumnsAreReadAndOthersMayHoldAnything) {
  const auto path = file("t,a,remark,b\n0,1,start,2\n1,3,,4\n2,5,NaN,6\n");
  const auto series = read_csv(path, {.columns = {"b", "a"}});
  EXPECT_EQ(series.values, (Eigen::MatrixXd(2, 3) << 2, 4, 6, 1, 3, 5).finished());
  const auto issues = issues_of([&] { read_csv(path, {.columns = {"remarks"}}); });
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_NE(issues[0].what.find("did you mean 'remark'"), std::string::npos);
}

TEST_F(CsvFiles, BadCellsAreAllReportedWithLineAndColumn) {
  const auto path = file("# comment\nt,a,b\n0,1,2\n1,nan,3\n2,,x1\n3,4,inf\n4,5\n5,1e999,7\n");
  const auto issues = issues_of([&] { read_csv(path); });
  ASSERT_EQ(issues.size(), 6u);
  const int lines[] = {4, 5, 5, 6, 7, 8};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(issues[i].location.line, lines[i]);
  EXPECT_EQ(issues[0].location.file, path.string());
  EXPECT_NE(issues[0].what.find("'a' holds 'nan'"), std::string::npos);
  EXPECT_NE(issues[1].what.find("'a' is empty"), std::string::npos);
  EXPECT_NE(issues[2].what.find("'b' holds 'x1'"), std::string::npos);
  EXPECT_FALSE(issues[0].fix.empty());
}

TEST_F(CsvFiles, ManyBadCellsAreCounted) {
  std::string text = "t,a\n";
  for (int k = 0; k < 100; ++k) text += std::to_string(k) + ",bad\n";
  const auto issues = issues_of([&] { read_csv(file(text)); });
  ASSERT_EQ(issues.size(), 13u);
  EXPECT_NE(issues.back().what.find("88 more"), std::string::npos);
}

std::string stamped(int count, double rate, int decimals, int missing = -1) {
  std::string text = "t,a\n";
  char line[64];
  for (int k = 0; k < count; ++k) {
    if (k == missing) continue;
    std::snprintf(line, sizeof line, "%.*f,%d\n", decimals, k / rate, k);
    text += line;
  }
  return text;
}

TEST_F(CsvFiles, RoundedTimeStampsAreAcceptedAndTheRateIsRecovered) {
  EXPECT_DOUBLE_EQ(read_csv(file(stamped(4000, 500, 4))).sample_rate, 500.0);
  EXPECT_DOUBLE_EQ(read_csv(file(stamped(36000, 3004.8, 4))).sample_rate, 3004.8);
  EXPECT_DOUBLE_EQ(read_csv(file(stamped(20000, 1024, 6))).sample_rate, 1024.0);
  // nine decimals over 147 s tell the rate to 2e-9
  EXPECT_NEAR(read_csv(file(stamped(90000, 610.3516, 9))).sample_rate, 610.3516, 1e-8);
}

TEST_F(CsvFiles, AMissingSampleIsReportedAtItsLine) {
  for (const int decimals : {4, 9}) {
    const auto issues = issues_of([&] { read_csv(file(stamped(4000, 3004.8, decimals, 1234))); });
    ASSERT_EQ(issues.size(), 1u);
    EXPECT_EQ(issues[0].location.line, 1236);  // one header line, 1234 samples, then the one after the gap
    EXPECT_NE(issues[0].why.find("1 samples are missing"), std::string::npos);
  }
}

TEST_F(CsvFiles, TimeThatDoesNotRiseOrIsTooCoarseIsRefused) {
  EXPECT_EQ(issues_of([&] { read_csv(file("t,a\n0,1\n0.1,2\n0.1,3\n0.2,4\n0.3,5\n0.4,1\n")); }).at(0).location.line, 4);
  EXPECT_FALSE(issues_of([&] { read_csv(file("t,a\n3,1\n2,2\n1,3\n")); }).empty());
  EXPECT_FALSE(issues_of([&] { read_csv(file("t,a\n0,1\n")); }).empty());
  const auto coarse = file(stamped(4000, 3004.8, 3));
  EXPECT_EQ(issues_of([&] { read_csv(coarse); }).size(), 1u);
  EXPECT_EQ(read_csv(coarse, {.sample_rate = 3004.8}).sample_rate, 3004.8);
  EXPECT_EQ(issues_of([&] { read_csv(coarse, {.sample_rate = 2990}); }).size(), 1u);
}

TEST_F(CsvFiles, BadOptionsAndFilesAreRefused) {
  const auto path = file("t,a\n0,1\n1,2\n");
  EXPECT_EQ(
      issues_of([&] { read_csv(path, {.separator = '|', .decimal = '\'', .sample_rate = NAN, .jitter = NAN}); }).size(),
      4u);
  EXPECT_FALSE(issues_of([&] { read_csv(path, {.sample_rate = -1}); }).empty());
  EXPECT_FALSE(issues_of([&] { read_csv(folder_ / "absent.csv"); }).empty());
  EXPECT_FALSE(issues_of([&] { read_csv(folder_); }).empty());
  EXPECT_FALSE(issues_of([&] { read_csv(file("")); }).empty());
  EXPECT_FALSE(issues_of([&] { read_csv(file("t,a\n")); }).empty());
  EXPECT_FALSE(issues_of([&] { read_csv(file("t,a,a\n0,1,2\n1,2,3\n")); }).empty());
}

TEST_F(CsvFiles, WhatIsWrittenReadsBackTheSame) {
  Record series{256.0, -0.25, {{"frame p5, z", "m/s2"}, {"b", ""}}, Eigen::MatrixXd::Random(2, 1000) * 1e-7};
  for (const char separator : {',', ';', '\t'}) {
    write_csv(folder_ / "out.csv", series, separator);
    const auto back = read_csv(folder_ / "out.csv");
    EXPECT_EQ(back.values, series.values);
    EXPECT_EQ(back.sample_rate, 256.0);
    EXPECT_EQ(back.start, -0.25);
    EXPECT_EQ(back.channels[0].name, "frame p5, z");
    EXPECT_EQ(back.channels[0].unit, "m/s2");
  }
  EXPECT_THROW(write_csv(folder_ / "out.csv" / "below.csv", series), InvalidInput);
}

const std::string lvm_header =
    "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n\t\n"
    "Channels\t2\t\t\nSamples\t3\t3\t\nY_Unit_Label\tmm\tg\t\nX0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.002\t0.002\t\n"
    "***End_of_Header***\t\t\t\n";

// Its times are read before its values: rate, values, order and the lines of mistakes are those of a short table.
TEST_F(CsvFiles, OfMoreThanAMillionRowsIsReadAsAShortOne) {
  constexpr int rows = 1'050'000;
  const auto table = [](int bad_row, bool swapped) {
    std::string text = "t,a,b\n";
    text.reserve(20 * rows);
    for (int k = 0; k < rows; ++k) {
      const int at = swapped && k == 500'000 ? k + 1 : swapped && k == 500'001 ? k - 1 : k;
      text += std::to_string(at) + "e-3," + (k == bad_row ? "x" : std::to_string(at % 997)) + ",1\n";
    }
    return text;
  };
  const CsvOptions options{.columns = {"a"}, .uneven = true};
  for (const bool swapped : {false, true}) {
    const Record record = read_csv(file(table(-1, swapped)), options);
    ASSERT_EQ(record.samples(), rows);
    ASSERT_EQ(record.values.rows(), 1);
    EXPECT_EQ(record.sample_rate, 1000.0);
    for (const Eigen::Index k : {0, 499'999, 500'000, 500'001, rows - 1}) EXPECT_EQ(record.values(0, k), k % 997) << k;
  }
  const auto issues = issues_of([&] { read_csv(file(table(900'000, false)), options); });
  ASSERT_EQ(issues.size(), 1U);
  EXPECT_EQ(issues[0].location.line, 900'002);
}

TEST_F(CsvFiles, LabViewFileWithComments) {
  const auto read = read_lvm(file(
      lvm_header + "X_Value\ta (Filtered)\tb\tComment\n0.000\t1.5\t2\tstarted, by hand\n0.002\t3\t4\n0.004\t5\t6\n"));
  EXPECT_DOUBLE_EQ(read.channels[0].interval, 0.002);
  EXPECT_EQ(read.channels[0].name, "a (Filtered)");
  EXPECT_EQ(read.channels[1].unit, "g");
  EXPECT_EQ(read.channels[0].values, Eigen::Vector3d(1.5, 3, 5));
  EXPECT_EQ(read.channels[1].values, Eigen::Vector3d(2, 4, 6));
}

TEST_F(CsvFiles, DamagedLabViewFilesAreRefused) {
  const std::string names = "X_Value\ta\tb\tComment\n";
  const auto read = [&](const std::string& text) { return issues_of([&] { read_lvm(file(text)); }); };
  EXPECT_FALSE(read("").empty());
  EXPECT_FALSE(read("Channels\t2\n1\t2\t3\n").empty());
  const auto issues = read(lvm_header + names + "0.000\t1\tx\n0.002\t3\n0.004\t5\t\n");
  ASSERT_GE(issues.size(), 2u);
  EXPECT_EQ(issues[0].location.line, 14);
  EXPECT_EQ(issues[1].location.line, 15);
}

TEST(HalfCarRig, DecimatedLabViewFileEqualsTheCsv) {
  const fs::path folder = data_folder("halfcar-rig");
  if (!fs::exists(folder / "Centre_p0000_t1.1_r1.lvm"))
    KALFEM_ABSENT("the measured half-car records are absent; set KALFEM_DATA to the folder that holds halfcar-rig");
  const auto lvm = read_lvm(folder / "Centre_p0000_t1.1_r1.lvm");
  const auto csv = read_csv(folder / "Centre_p0000_t1.1_r1_500Hz.csv");
  EXPECT_DOUBLE_EQ(lvm.channels[0].interval, 1.0 / 5000.0);
  EXPECT_DOUBLE_EQ(csv.sample_rate, 500.0);
  ASSERT_EQ(lvm.channels.size(), 4u);
  ASSERT_EQ(lvm.channels[0].values.size(), 40000);
  ASSERT_EQ(csv.samples(), 4000);
  EXPECT_EQ(lvm.channels[0].unit, "mm");
  // The CSV holds means of ten samples, in metres with seven decimals.
  Eigen::MatrixXd means = Eigen::MatrixXd::Zero(4, 4000);
  for (int j = 0; j < 4; ++j)
    for (int k = 0; k < 10; ++k)
      means.row(j) += lvm.channels[std::size_t(j)].values(Eigen::seqN(k, 4000, 10)).transpose() * 1e-4;
  EXPECT_LT((means - csv.values).cwiseAbs().maxCoeff(), 0.51e-7);
}

}  // namespace
}  // namespace kalfem
