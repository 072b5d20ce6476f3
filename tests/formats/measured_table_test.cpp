// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/measured_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/hdf5/measured_hdf5.hpp"
#include "kalfem/formats/record_file.hpp"

namespace kalfem {
namespace {

using Numbers = std::vector<double>;

class MeasuredTables : public testing::Test {
protected:
  MeasuredFile read(const std::string& text) const {
    std::ofstream(folder_ / "run.csv", std::ios::binary) << text;
    return read_measured_table(folder_ / "run.csv");
  }
  static Numbers values(const MeasuredChannel& channel) { return {channel.values.begin(), channel.values.end()}; }
  ScratchFolder folder_{"measured_table"};
};

TEST_F(MeasuredTables, HaveUnitsInTheirTitles) {
  const auto file = read("t [ms],acc (g),Road [mm]\n0,1,4\n10,2,5\n20,3,6\n");
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(file.channels[0].name, "acc");
  EXPECT_EQ(file.channels[0].unit, "g");
  EXPECT_EQ(file.channels[1].unit, "mm");
  EXPECT_NEAR(file.channels[0].interval, 0.01, 1e-12);
  EXPECT_EQ(values(file.channels[1]), (Numbers{4, 5, 6}));
}

TEST_F(MeasuredTables, MayBeginWithOtherLinesAndHaveALineOfUnits) {
  const auto file = read(
      "Test bench 7\r\nDate;1.2.2026\r\nOperator;N. N.\r\n\r\nTime;Force;Stroke\r\ns;kN;[mm]\r\n"
      "0,0;1,5;-2,25\r\n0,5;2,5;3\r\n1,0;3,5;4\r\n");
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(file.channels[0].name, "Force");
  EXPECT_EQ(file.channels[0].unit, "kN");
  EXPECT_EQ(file.channels[1].unit, "mm");
  EXPECT_EQ(values(file.channels[1]), (Numbers{-2.25, 3, 4}));
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.5);
}

TEST_F(MeasuredTables, MayHaveATimeForEachChannel) {
  const auto file = read("Time [s],a [g],Time [s],b\n0,1,5,10\n1,2,5.5,11\n2,3,6,12\n3,4,,\n");
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 1.0);
  EXPECT_DOUBLE_EQ(file.channels[1].start, 5.0);
  EXPECT_DOUBLE_EQ(file.channels[1].interval, 0.5);
  EXPECT_EQ(values(file.channels[1]), (Numbers{10, 11, 12}));
}

TEST_F(MeasuredTables, KeepUnevenTimesAndMissingSamples) {
  const auto file = read("t,a\n0,1\n1,nan\n2,3\n5,4\n");
  EXPECT_EQ(file.channels[0].times, Eigen::Vector4d(0, 1, 2, 5));
  EXPECT_TRUE(std::isnan(file.channels[0].values[1]));
}

TEST_F(MeasuredTables, TakeAnEvenFirstColumnAsTimeAndListText) {
  const auto file = read("0 1.5 ok\n0.1 2.5 ok\n0.2 3.5 late\n");
  ASSERT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(file.channels[0].name, "column_2");
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.1);
  EXPECT_EQ(file.notes.size(), 1u);
  EXPECT_EQ(file.skipped, std::vector<std::string>{"column 'column_3' holds text"});
}

TEST_F(MeasuredTables, LoseALastLineThatWasCut) {
  const auto file = read("t,a,b\n0,1,2\n1,2,3\n2,3");
  EXPECT_EQ(values(file.channels[1]), (Numbers{2, 3}));
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST_F(MeasuredTables, NamePlacesThatAreNoNumbers) {
  try {
    read("t,a\n0,1\n1,x\n2,3\n3,4\n4,5\n");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("run.csv:3: column 'a' holds 'x'"), std::string::npos) << error.what();
  }
  EXPECT_THROW(read(""), InvalidInput);
  EXPECT_THROW(read("a,b\nc,d\ne,f\n"), InvalidInput);
}

TEST_F(MeasuredTables, OfHdf5FilesAreTheirDatasets) {
  const auto path = (folder_ / "run.h5").string();
  {
    auto file = Hdf5File::create(path);
    file.write_matrix("/run", (Eigen::MatrixXd(3, 2) << 1, 4, 2, 5, 3, 6).finished());
    file.set_attribute("/run", "fs", 50.0);
    file.set_attribute("/run", "unit", "g");
    file.write_strings("/names", {"a", "b"});
    file.close();
  }
  const auto file = read_measured_hdf5(path);
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(file.channels[1].name, "/run[1]");
  EXPECT_EQ(file.channels[1].unit, "g");
  EXPECT_DOUBLE_EQ(file.channels[1].interval, 0.02);
  EXPECT_EQ(values(file.channels[1]), (Numbers{4, 5, 6}));
  EXPECT_EQ(file.skipped.size(), 1u);
}

/// A vector a channel, with the rate or the times beside them, as programs write them; no dataset is named.
TEST_F(MeasuredTables, OfHdf5FilesWithAVectorAChannelAreARecord) {
  const auto path = folder_ / "vectors.h5";
  {
    auto file = Hdf5File::create(path.string());
    file.write("/first/u", Eigen::Vector3d(1, 2, 3));
    file.write("/first/fs", Eigen::VectorXd::Constant(1, 50.0));
    file.write_matrix("/second/y", Eigen::RowVector4d(4, 5, 6, 7));
    file.write("/second/time", Eigen::Vector4d(1.0, 1.5, 2.0, 2.5));
    file.close();
  }
  const auto measured = read_measured_hdf5(path);
  ASSERT_EQ(measured.channels.size(), 2u);  // neither the rate nor the times are channels
  EXPECT_TRUE(measured.skipped.empty());
  EXPECT_EQ(measured.channels[1].name, "/second/y");
  EXPECT_DOUBLE_EQ(measured.channels[1].start, 1.0);
  EXPECT_DOUBLE_EQ(measured.channels[1].interval, 0.5);
  const Record record = read_record_file(path, {{.column = "u", .owner = "sensors.u", .unit = "m"}}, {});
  EXPECT_DOUBLE_EQ(record.sample_rate, 50.0);
  EXPECT_TRUE(record.values.isApprox(Eigen::RowVector3d(1, 2, 3)));
}

/// Samples stand along the longer side; the rate may stand at a group around.
TEST_F(MeasuredTables, OfHdf5FilesMayBeTurnedAndHaveTheirRateAbove) {
  const auto path = (folder_ / "turned.h5").string();
  {
    auto file = Hdf5File::create(path);
    file.write_matrix("/run/raw/a", (Eigen::MatrixXd(2, 4) << 1, 2, 3, 4, 5, 6, 7, 8).finished());
    file.set_attribute("/run", "fs", 50.0);
    file.write_matrix("/timed/b", (Eigen::MatrixXd(3, 2) << 1, 2, 3, 4, 5, 6).finished());
    file.write("/timed/t", Eigen::Vector2d(0.0, 0.5));
    file.close();
  }
  const auto file = read_measured_hdf5(path);
  ASSERT_EQ(file.channels.size(), 5u);
  EXPECT_EQ(values(file.channels[1]), (Numbers{5, 6, 7, 8}));
  EXPECT_DOUBLE_EQ(file.channels[1].interval, 0.02);
  EXPECT_EQ(values(file.channels[4]), (Numbers{5, 6}));
  EXPECT_DOUBLE_EQ(file.channels[4].interval, 0.5);
}

const char* const bench_table =
    "Test bench 7\r\nOperator;N. N.\r\n\r\nTime;Force;Stroke\r\ns;kN;[mm]\r\n"
    "0,0;1,5;-2,25\r\n0,5;2,5;3\r\n1,0;3,5;4\r\n";

TEST_F(MeasuredTables, WithPreambleAreRecordsInSI) {
  std::ofstream(folder_ / "bench.csv", std::ios::binary) << bench_table;
  const Record record = read_record_file(folder_ / "bench.csv",
                                         {{.column = "Stroke", .owner = "sensors.stroke", .unit = "m"},
                                          {.column = "Force", .owner = "sensors.force", .unit = "N"}},
                                         {});
  EXPECT_DOUBLE_EQ(record.sample_rate, 2.0);
  EXPECT_TRUE(record.values.isApprox((Eigen::MatrixXd(2, 3) << -2.25e-3, 3e-3, 4e-3, 1500, 2500, 3500).finished()));
}

TEST_F(MeasuredTables, ArePlainWithOneLineOfNamesAndOneOfTimesAtMost) {
  const auto is_plain = [&](const std::string& text) {
    std::ofstream(folder_ / "a.csv", std::ios::binary) << text;
    return is_plain_table(folder_ / "a.csv");
  };
  EXPECT_TRUE(is_plain("t,a\n0,1\n1,2\n2,3\n"));
  EXPECT_TRUE(is_plain("0,1\n1,2\n2,3\n"));
  EXPECT_TRUE(is_plain("# comment\nt,a\n0,x\n1,2\n2,3\n"));  // the plain reader names the line of the x
  EXPECT_TRUE(is_plain("0,x\n1,2\n2,3\n3,3\n"));
  EXPECT_TRUE(is_plain("no numbers\n"));
  EXPECT_FALSE(is_plain(bench_table));
  EXPECT_FALSE(is_plain("t,a\ns,mm\n0,1\n1,2\n2,3\n"));
  EXPECT_FALSE(is_plain("t,a,t,b\n0,1,0,2\n1,2,2,3\n2,3,4,5\n"));
}

TEST_F(MeasuredTables, RefuseADamagedRowAboveTheTable) {
  for (const char* text : {"Bench 7\nt,a\n0,x\n1,2\n2,3\n3,4\n", "Bench 7\n0,x\n1,2\n2,3\n3,4\n"}) try {
      read(text);
      ADD_FAILURE() << text;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("begins with a number"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace kalfem
