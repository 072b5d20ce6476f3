// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/formats/tables/csv.hpp"

// Records in which samples are missing, rows that are not wanted, and records that were cut off.
namespace kalfem {
namespace {

using Eigen::Index;

class Gaps : public testing::Test {
protected:
  [[nodiscard]] std::filesystem::path file(const std::string& text, const std::string& name = "record.csv") const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  template <typename Read>
  std::string errors_of(Read read) const {
    try {
      read();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }
  ScratchFolder folder_{"gaps"};
};

/// (sample, channel) that are NaN, channel by channel; everything else must be sample + 10 channel.
std::vector<std::pair<Index, Index>> missing_in(const Eigen::MatrixXd& values) {
  std::vector<std::pair<Index, Index>> missing;
  for (Index j = 0; j < values.rows(); ++j)
    for (Index k = 0; k < values.cols(); ++k) {
      if (std::isnan(values(j, k)))
        missing.emplace_back(k, j);
      else
        EXPECT_EQ(values(j, k), double(k + 10 * j));
    }
  return missing;
}

using Places = std::vector<std::pair<Index, Index>>;

TEST_F(Gaps, AreNaNWhereverTheyStand) {
  const auto path = file("t,a,b\n0,,nan\n0.1,1,11\n0.2,NA,12\n0.3,3,n/a\n0.4,4,\n0.5,None,null\n");
  const auto series = read_csv(path, {.missing = true});
  EXPECT_EQ(missing_in(series.values), (Places{{0, 0}, {2, 0}, {5, 0}, {0, 1}, {3, 1}, {4, 1}, {5, 1}}));
  EXPECT_DOUBLE_EQ(series.sample_rate, 10.0);
  const std::string refused = errors_of([&] { read_csv(path); });
  EXPECT_NE(refused.find(":2: column 'a' is empty"), std::string::npos) << refused;
  EXPECT_NE(refused.find("skip_missing"), std::string::npos) << refused;
}

TEST_F(Gaps, StandInEveryDialect) {
  const CsvOptions options{.missing = true};
  EXPECT_EQ(missing_in(read_csv(file("t\ta\tb\n0\t\t\n1\t1\t11\n2\t\t12\n"), options).values),
            (Places{{0, 0}, {2, 0}, {0, 1}}));
  EXPECT_EQ(missing_in(read_csv(file("t a b\n0 nan 10\n1 1 NA\n2 2 12\n"), options).values), (Places{{0, 0}, {1, 1}}));
  // Sixty rows pass before the first decimal comma shows.
  std::string german = "t;a\n";
  for (int k = 0; k < 60; ++k) german += std::to_string(k) + ";\n";
  const auto series = read_csv(file(german + "60;60,0\n61;61,0\n"), options);
  EXPECT_EQ(series.values(0, 61), 61.0);
  EXPECT_EQ(missing_in(series.values).size(), 60u);
}

TEST_F(Gaps, DoNotHideWhatIsNoNumber) {
  const CsvOptions options{.missing = true};
  const std::string refused = errors_of([&] { read_csv(file("t,a\n0,1\n1,x1\n2,inf\n3,1e999\n,5\n"), options); });
  for (const char* place : {":3: column 'a' holds 'x1'", ":4: column 'a' holds 'inf'", ":5: column 'a' holds '1e999'",
                            ":6: column 't' is empty"})
    EXPECT_NE(refused.find(place), std::string::npos) << refused;
  EXPECT_NE(errors_of([&] { read_csv(file("t,a,b\n0,1,2\n1,1\n2,1,2\n"), options); }).find(":3:"), std::string::npos);
}

TEST_F(Gaps, InTheFirstRowMakeNoHeader) {
  const auto series = read_csv(file("NA,10\n1,\n2,12\n"), {.missing = true, .sample_rate = 5.0});
  EXPECT_EQ(missing_in(series.values), (Places{{0, 0}, {1, 1}}));
  EXPECT_EQ(series.channels[0].name, "column_1");
}

TEST_F(Gaps, WithoutTimesABlankLineIsASample) {
  const CsvOptions options{.missing = true, .sample_rate = 5.0};
  EXPECT_EQ(missing_in(read_csv(file("a\n0\n\n2\n3\n\n\n"), options).values), (Places{{1, 0}}));
  EXPECT_EQ(missing_in(read_csv(file("a\tb\n0\t10\n\t\n2\t12\n"), options).values), (Places{{1, 0}, {1, 1}}));
  EXPECT_NE(errors_of([&] { read_csv(file("a\n0\n\n2\n"), {.sample_rate = 5.0}); }).find(":3: column 'a' is empty"),
            std::string::npos);
  // With times it says nothing.
  EXPECT_EQ(read_csv(file("t,a\n0,0\n\n1,1\n2,2\n"), {.missing = true}).samples(), 3);
}

TEST_F(Gaps, RowsBehindTheWantedOnesAreNotLookedAt) {
  const auto path = file("mode,f\n1,10.5\n2,20.5\n3,not found\n4,\n5\n");
  const auto table = read_csv_table(path, {.columns = {"f"}, .rows = 2});
  EXPECT_EQ(table.values, Eigen::Vector2d(10.5, 20.5));
  EXPECT_NE(errors_of([&] { read_csv_table(path, {.columns = {"f"}, .rows = 3}); }).find(":4:"), std::string::npos);
  EXPECT_EQ(read_csv_table(file("10.5\n20.5\nx\n"), {.rows = 2}).values, Eigen::Vector2d(10.5, 20.5));
  EXPECT_FALSE(errors_of([&] { read_csv_table(path, {.rows = 0}); }).empty());
}

std::string lvm(const std::string& samples, const std::string& rows) {
  return "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n\t\n"
         "Channels\t2\t\t\n" +
         samples + "X0\t0\t0\t\nDelta_X\t0.5\t0.5\t\n***End_of_Header***\t\t\t\nX_Value\ta\tb\tComment\n" + rows;
}

Record lvm_record(const std::filesystem::path& path, bool missing, std::vector<std::string>* notes = nullptr) {
  return read_record_file(path, {{.column = "a", .owner = "sensors.a", .unit = "m"}, {.column = "b", .unit = "m"}},
                          {.missing = missing, .notes = notes});
}

TEST_F(Gaps, OfLabViewFilesAreNaNToo) {
  const auto path = file(lvm("Samples\t3\t3\n", "0\tNaN\t10\n0.5\t1\t\n1\t2\t12\n"), "a.lvm");
  EXPECT_EQ(missing_in(lvm_record(path, true).values), (Places{{0, 0}, {1, 1}}));
  EXPECT_NE(errors_of([&] { lvm_record(path, false); }).find("channel 'a' is not a number at 0 s"), std::string::npos);
}

TEST_F(Gaps, TheLinesOfALabViewFileCountAndNotItsHeader) {
  const std::string rows = "0\t0\t10\n0.5\t1\t11\n1\t2\t12\n";
  EXPECT_EQ(lvm_record(file(lvm("Samples\t3\t3\n", rows), "a.lvm"), false).samples(), 3);
  EXPECT_EQ(lvm_record(file(lvm("", rows), "a.lvm"), false).samples(), 3);  // nothing is declared
  std::vector<std::string> notes;
  EXPECT_EQ(lvm_record(file(lvm("Samples\t40\t40\n", rows), "a.lvm"), false, &notes).samples(), 3);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("a.lvm:8: the header declares 40 samples, the file contains 3"), std::string::npos)
      << notes[0];
}

}  // namespace
}  // namespace kalfem
