// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/frf_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Complex = std::complex<double>;

class FrfTables : public testing::Test {
protected:
  FrequencyResponse read(const std::string& text, const FrfTableOptions& options = {}) const {
    std::ofstream(folder_ / "frf.csv", std::ios::binary) << text;
    return read_frf_table(folder_ / "frf.csv", options);
  }

  std::vector<Issue> issues(const std::string& text, const FrfTableOptions& options = {}) const {
    try {
      read(text, options);
    } catch (const InvalidInput& error) {
      return error.issues();
    }
    return {};
  }

  ScratchFolder folder_{"frf"};
};

TEST_F(FrfTables, ReadsComplexNumbersWithoutHeader) {
  const auto frf = read("0.03125+0j;-0.05+0.25j;1e-2-3.5e-1j\r\n0.0625+0j;2;-4j\r\n0.09375;1E+2+1E-2i;(3-2j)");
  EXPECT_EQ(frf.lines, Eigen::Vector3d(0.03125, 0.0625, 0.09375));
  ASSERT_EQ(frf.outputs.size(), 2u);
  EXPECT_EQ(frf.outputs[1].name, "H2");
  const Eigen::MatrixXcd expected = (Eigen::MatrixXcd(3, 2) << Complex(-0.05, 0.25), Complex(0.01, -0.35), Complex(2.0),
                                     Complex(0.0, -4.0), Complex(100.0, 0.01), Complex(3.0, -2.0))
                                        .finished();
  EXPECT_EQ(frf.values, expected);
  EXPECT_FALSE(frf.magnitudes_only);
  EXPECT_EQ(frf.deviations.size(), 0);
}

TEST_F(FrfTables, ReadsMagnitudesAndDecibelWithoutHeader) {
  const auto decibel = read("0,-20,40\n0.5,0,-6\n", {.content = FrfColumnContent::decibel});
  EXPECT_TRUE(decibel.magnitudes_only);
  // rounding, here and below
  EXPECT_NEAR(decibel.values(0, 0).real(), 0.1, 1e-15);
  EXPECT_NEAR(decibel.values(0, 1).real(), 100.0, 1e-13);
  const auto magnitudes = read("f, top, base_db\n0,2,20\n1,3,0\n", {.content = FrfColumnContent::magnitude});
  EXPECT_TRUE(magnitudes.magnitudes_only);
  EXPECT_EQ(magnitudes.values(1, 0), Complex(3.0));
  EXPECT_NEAR(magnitudes.values(0, 1).real(), 10.0, 1e-14);  // a name says more than `content`
  const auto negative = issues("1,-20\n2,-10\n", {.content = FrfColumnContent::magnitude});
  ASSERT_FALSE(negative.empty());
  EXPECT_NE(negative[0].what.find("is negative"), std::string::npos) << negative[0].what;
}

TEST_F(FrfTables, ReadsNamedColumnsInAnyOfTheirWays) {
  const auto parts =
      read("# comment\nfrequency_hz, top_re [m/s2/N], top_im, base_RE, base_IM\n1, 1, 2, 3, 4\n2, 5, 6, 7, 8\n");
  EXPECT_EQ(parts.outputs[0].name, "top");
  EXPECT_EQ(parts.outputs[0].unit, "m/s2/N");
  EXPECT_EQ(parts.values(1, 0), Complex(5.0, 6.0));
  EXPECT_EQ(parts.values(0, 1), Complex(3.0, 4.0));

  const auto polar = read("f [Hz]\tH_mag\tH_phase\tH_std\n1\t2\t90\t0.5\n3\t1\t-180\t0.25\n");
  EXPECT_NEAR(std::abs(polar.values(0, 0) - Complex(0.0, 2.0)), 0.0, 1e-15);
  EXPECT_NEAR(std::abs(polar.values(1, 0) + 1.0), 0.0, 1e-15);
  EXPECT_EQ(polar.deviations(1, 0), 0.25);

  const auto radians = read("f [rad/s];H_db;H_phase [rad]\n6,283185307179586;20;1,5707963267948966\n12,6;0;0\n");
  EXPECT_NEAR(radians.lines[0], 1.0, 1e-15);
  EXPECT_NEAR(std::abs(radians.values(0, 0) - Complex(0.0, 10.0)), 0.0, 1e-14);

  const auto magnitudes = read("% c\nf H_abs\n1 2\n\n2 3\n");
  EXPECT_TRUE(magnitudes.magnitudes_only);
  EXPECT_EQ(magnitudes.values(1, 0), Complex(3.0));

  const auto complex = read("f;a;b\n1;1+1j;2\n2;1-1j;3\n");
  EXPECT_EQ(complex.values(0, 1), Complex(2.0));
}

TEST_F(FrfTables, SelectsColumnsByName) {
  const std::string text = "index;f;a;b\n0;1;1+1j;2j\n1;2;1-1j;3j\n";
  const auto frf = read(text, {.frequency_column = "f", .outputs = {"b", "a"}});
  ASSERT_EQ(frf.outputs.size(), 2u);
  EXPECT_EQ(frf.outputs[0].name, "b");
  EXPECT_EQ(frf.values(1, 0), Complex(0.0, 3.0));
  EXPECT_EQ(frf.lines[1], 2.0);
}

TEST_F(FrfTables, NamesEveryPlaceThatIsWrong) {
  const auto found = issues("f;a\n1;1+1j\n2;x\n2;1+j\n3;\n-4;nan+1j\n5;1;2\n");
  EXPECT_EQ(found.size(), 1u);  // of another length: nothing else is looked at
  EXPECT_EQ(found[0].location.line, 7);
  const auto cells = issues("f;a\n1;1+1j\n2;x\n2;1+j\n3;\n-4;nan+1j\n5;inf\n");
  std::vector<int> lines;
  for (const auto& issue : cells) lines.push_back(issue.location.line);
  std::ranges::sort(lines);
  EXPECT_EQ(lines, (std::vector<int>{3, 4, 4, 5, 6, 6, 6, 7}));
}

TEST_F(FrfTables, RefusesNamesThatMakeNoFrf) {
  const auto only = [&](const std::string& text, const std::string& words, const FrfTableOptions& options = {}) {
    const auto found = issues(text, options);
    ASSERT_EQ(found.size(), 1u) << text;
    EXPECT_NE(to_string(found[0]).find(words), std::string::npos) << to_string(found[0]);
  };
  only("1;2;3\n2;3;4\n", "have no names");
  only("f;a_re\n1;2\n", "only one of the columns");
  only("f;a_re;a_im;a_mag\n1;2;3;4\n", "more than one form");
  only("f;a_phase;b_re;b_im\n1;2;3;4\n", "in no form");
  only("f;a_re;a_im;a_re\n1;2;3;4\n", "two columns");
  only("f;a_mag;b_re;b_im\n1;2;3;4\n", "have no phase");
  only("f;a_mag\n1;-2\n", "is negative");
  only("f;a_re;a_im\n1;2;3j\n", "the column is real elsewhere");
  only("f [min];a\n1;2j\n", "Hz, kHz and rad/s");
  only("f;accel\n1;2j\n", "did you mean 'accel'", {.outputs = {"acel"}});
  only("f;a\n1;2j\n", "no column 'g'", {.frequency_column = "g"});
  only("f;a\n", "no lines of numbers");
  only("", "no data");
  only("1\n2\n", "one column");
  EXPECT_THROW(read("1;2j\n", {.separator = '|'}), InvalidInput);
  EXPECT_THROW(read_frf_table(folder_ / "none.csv"), InvalidInput);
}

}  // namespace
}  // namespace kalfem
