// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/text_table.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/formats/tables/frf_table.hpp"

namespace kalfem {
namespace {

TEST(ChannelTitle, HoldsAUnitInBracketsOrInParenthesesThatLookLikeOne) {
  const struct {
    const char *title, *name, *unit;
  } cases[] = {{"a", "a", ""},
               {"a [g]", "a", "g"},
               {"a[m/s2]", "a", "m/s2"},
               {"Road [ mm ]", "Road", "mm"},
               {"Acc (g)", "Acc", "g"},
               {"Acc (G)", "Acc", "G"},
               {"Force (kN)", "Force", "kN"},
               {"F(N)", "F", "N"},
               {"a (m/s²)", "a", "m/s²"},
               {"a (in/sec^2)", "a", "in/sec^2"},
               {"H (dB)", "H", "dB"},
               {"level [counts]", "level", "counts"},
               {"phase (°)", "phase", "°"},
               // names
               {"Disp Sprung LH (Filtered)", "Disp Sprung LH (Filtered)", ""},
               {"Channel (2)", "Channel (2)", ""},
               {"Acc (1)", "Acc (1)", ""},
               {"a (left) (mm)", "a (left)", "mm"},
               {"[g]", "[g]", ""},
               {"(g)", "(g)", ""},
               {"", "", ""},
               {"a ()", "a ()", ""},
               {"(mm) of x", "(mm) of x", ""}};
  for (const auto& each : cases) {
    const Channel channel = channel_of(each.title);
    EXPECT_EQ(channel.name, each.name) << each.title;
    EXPECT_EQ(channel.unit, each.unit) << each.title;
  }
}

TEST(ChannelTitle, ChannelsAreFoundWithAndWithoutTheirUnit) {
  const std::vector<Channel> channels = {{"t", "s"}, {"a", "g"}, {"F (left)", "kN"}, {"x [m]", "m"}, {"x [mm]", "mm"}};
  EXPECT_EQ(find_channel(channels, "a"), 1);
  EXPECT_EQ(find_channel(channels, "a [g]"), 1);
  EXPECT_EQ(find_channel(channels, "a (g)"), 1);
  EXPECT_EQ(find_channel(channels, "F (left)"), 2);
  EXPECT_EQ(find_channel(channels, "F (left) [kN]"), 2);
  EXPECT_EQ(find_channel(channels, "x [mm]"), 4);
  EXPECT_EQ(find_channel(channels, "x"), -1);  // it could be either
  EXPECT_EQ(find_channel(channels, "a [mm]"), -1);
  EXPECT_EQ(find_channel(channels, "F"), -1);
}

class TitledFiles : public testing::Test {
protected:
  [[nodiscard]] std::filesystem::path file(const std::string& text) const {
    std::ofstream(folder_ / "table.csv", std::ios::binary) << text;
    return folder_ / "table.csv";
  }
  ScratchFolder folder_{"titles"};
};

TEST_F(TitledFiles, ColumnsOfOneNameAreToldApartByTheirUnits) {
  const auto path = file("t [ms],x (mm),x (m/s),a (g)\n0,1,2,3\n10,4,5,6\n20,7,8,9\n");
  const auto all = read_csv(path);
  EXPECT_DOUBLE_EQ(all.sample_rate, 100.0);
  EXPECT_EQ(all.channels[0].name, "x (mm)");
  EXPECT_EQ(all.channels[1].unit, "m/s");
  EXPECT_EQ(all.channels[2].name, "a");
  const auto chosen = read_csv(path, {.columns = {"a (g)", "x (m/s)"}});
  EXPECT_EQ(chosen.values(0, 1), 6.0);
  EXPECT_EQ(chosen.values(1, 1), 5.0);
  EXPECT_THROW(read_csv(path, {.columns = {"x"}}), std::exception);
}

TEST_F(TitledFiles, TimeMayBeInAnyUnitOfTime) {
  EXPECT_DOUBLE_EQ(read_csv(file("Time (ms),a\n0,1\n10,2\n20,3\n")).sample_rate, 100.0);
  EXPECT_DOUBLE_EQ(read_csv(file("time [sec],a\n0,1\n0.5,2\n1,3\n")).sample_rate, 2.0);
  EXPECT_DOUBLE_EQ(read_csv(file("t [h],a\n0,1\n0.001,2\n0.002,3\n"), {.sample_rate = 1.0 / 3.6}).sample_rate,
                   1.0 / 3.6);
  EXPECT_THROW(read_csv(file("t [m],a\n0,1\n1,2\n2,3\n")), std::exception);
}

TEST_F(TitledFiles, DecibelsAreSeenInTheTitle) {
  const auto frf = read_frf_table(file("f (kHz),H_mag [dB],H_phase (rad)\n1,20,0\n2,-20,0\n"));
  EXPECT_EQ(frf.lines[1], 2000.0);
  // rounding
  EXPECT_NEAR(std::abs(frf.values(0, 0)), 10.0, 1e-14);
  EXPECT_NEAR(std::abs(frf.values(1, 0)), 0.1, 1e-16);
  EXPECT_EQ(frf.outputs[0].unit, "");
  EXPECT_THROW(read_frf_table(file("f,H_mag,H_phase [mrad]\n1,20,0\n")), std::exception);
  EXPECT_THROW(read_frf_table(file("f,H_re [mm/N],H_im [m/N]\n1,20,0\n")), std::exception);
  EXPECT_THROW(read_frf_table(file("f,H_mag,H_std [dB]\n1,20,0\n")), std::exception);
}

}  // namespace
}  // namespace kalfem
