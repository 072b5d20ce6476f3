// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/measured_selection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/universal_texts.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/frequency_response_file.hpp"
#include "kalfem/formats/record_file.hpp"

// Which channels of a measured file a case asks for, and how they become one record.
namespace kalfem {
namespace {

using universal_text::Function;

Eigen::VectorXd vector(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

MeasuredChannel channel(const std::string& name, long node, int direction, const std::string& unit) {
  return {.name = name, .unit = unit, .place = {node, direction}, .interval = 0.01, .values = vector({1, 2, 3})};
}

class MeasuredSelection : public testing::Test {
protected:
  MeasuredFile file() const {
    MeasuredFile file{.format = "test"};
    file.channels = {channel("12:+Z", 12, 3, "m/s^2"), channel("14:-X", 14, -1, "g"), channel("hammer", 14, -1, "N"),
                     channel("mic", 0, 0, "Pa")};
    file.channels[3].place = {};
    file.channels[2].other_names = {"Force", "Channel 7"};
    return file;
  }
  Eigen::VectorXd values(const MeasuredFile& file, const std::string& name, const std::string& unit,
                         const RecordFileOptions& options = {}) const {
    return select_record(file, {{.column = name, .owner = "sensors.a", .unit = unit}}, options, "test.unv")
        .values.row(0)
        .transpose();
  }
  std::string refusal(const MeasuredFile& file, const std::vector<std::string>& names, const std::string& unit,
                      const RecordFileOptions& options = {}) const {
    std::vector<WantedChannel> wanted;
    for (const auto& name : names) wanted.push_back({.column = name, .owner = "sensors.a", .unit = unit});
    try {
      select_record(file, wanted, options, "test.unv");
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(MeasuredSelection, AFreedomHasManySpellings) {
  for (const char* text : {"12:+Z", "12+Z", "12z", "12:z", " 12 Z", "12Z+", "+12Z", "12.+z", "-12-Z"}) {
    const auto place = parse_freedom(text);
    ASSERT_TRUE(place) << text;
    EXPECT_EQ(place->node, 12) << text;
    EXPECT_EQ(place->direction, 3) << text;
  }
  for (const char* text : {"12-Z", "-12Z", "12:-z", "-12:+Z", "12Z-"})
    EXPECT_EQ(parse_freedom(text)->direction, -3) << text;
  EXPECT_EQ(parse_freedom("7:+RX")->direction, 4);
  for (const char* text : {"", "Z", "12", "a12Z", "12W", "12ZZ", "12:Z:1", "--12Z", "99999999999999999999Z"})
    EXPECT_FALSE(parse_freedom(text)) << text;
}

TEST_F(MeasuredSelection, ChannelsAreFoundByNameOtherNameAndPlace) {
  EXPECT_EQ(values(file(), "12:+Z", "m/s^2"), vector({1, 2, 3}));
  EXPECT_EQ(values(file(), "12z", "m/s^2"), vector({1, 2, 3}));
  EXPECT_EQ(values(file(), "Channel 7", "N"), vector({1, 2, 3}));
  EXPECT_EQ(values(file(), "mic [Pa]", "Pa"), vector({1, 2, 3}));
}

TEST_F(MeasuredSelection, AChannelAgainstTheDirectionIsTurned) {
  EXPECT_EQ(values(file(), "12-Z", "m/s^2"), vector({-1, -2, -3}));
  EXPECT_EQ(values(file(), "-12Z", "m/s^2"), vector({-1, -2, -3}));
  EXPECT_DOUBLE_EQ(values(file(), "14+X", "m/s^2")[0], -9.80665);
  EXPECT_DOUBLE_EQ(values(file(), "14:-X", "m/s^2")[0], 9.80665) << "its own name: as it is in the file";
}

TEST_F(MeasuredSelection, TheQuantityTellsChannelsOfOnePlaceApart) {
  EXPECT_EQ(values(file(), "14X", "N"), vector({-1, -2, -3}));
  auto two = file();
  two.channels[1].unit = "kN";
  const std::string text = refusal(two, {"14X"}, "N");
  EXPECT_NE(text.find("names 2 channels"), std::string::npos) << text;
  EXPECT_NE(text.find("'hammer' [N]"), std::string::npos) << text;
}

TEST_F(MeasuredSelection, ChannelsThatAreAbsentAreNamedAllAtOnce) {
  auto some = file();
  some.skipped = {"dataset 2420 is not read"};
  const std::string text = refusal(some, {"12:+Y", "hamer"}, "N");
  EXPECT_NE(text.find("'12:+Y'"), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean 'hammer'"), std::string::npos) << text;
  EXPECT_NE(text.find("dataset 2420"), std::string::npos) << text;
}

TEST_F(MeasuredSelection, UnitsAreThoseOfTheCaseOrTheFile) {
  EXPECT_NE(refusal(file(), {"mic"}, "m").find("Pa"), std::string::npos);
  auto unknown = file();
  unknown.channels[0].unit = "counts";
  EXPECT_NE(refusal(unknown, {"12z"}, "m").find("counts"), std::string::npos);
  unknown.channels[0].unit = "";
  EXPECT_EQ(values(unknown, "12z", "m"), vector({1, 2, 3}));
}

TEST_F(MeasuredSelection, ChannelsOfOneRecordMayHaveTheirOwnClocks) {
  const std::vector<WantedChannel> both = {{.column = "12Z", .owner = "a", .unit = "m/s^2"},
                                           {.column = "14:-X", .owner = "a", .unit = "m/s^2"}};
  auto other = file();
  other.channels[1].interval = 0.005;
  other.channels[1].values = vector({1, 2, 3, 4, 5});
  std::vector<std::string> notes;
  const auto rates = select_record(other, both, {.notes = &notes}, "f");
  EXPECT_EQ(rates.sample_rate, 200.0);
  EXPECT_EQ(rates.samples(), 5);
  EXPECT_EQ(rates.values(0, 2), 2.0);
  EXPECT_TRUE(std::isnan(rates.values(0, 1)));
  EXPECT_DOUBLE_EQ(rates.values(1, 1), 2 * 9.80665);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("'12:+Z' at 100 Hz"), std::string::npos) << notes[0];

  other = file();
  other.channels[1].start = 0.005;
  const auto between = select_record(other, both, {}, "f");
  EXPECT_EQ(between.sample_rate, 200.0);
  EXPECT_EQ(between.samples(), 6);
  EXPECT_EQ(between.values(0, 4), 3.0);
  EXPECT_DOUBLE_EQ(between.values(1, 5), 3 * 9.80665);
}

TEST_F(MeasuredSelection, ChannelsThatBeginOrEndApartNeedLeaveToLackSamples) {
  auto other = file();
  other.channels[1].start = 0.02;
  EXPECT_NE(refusal(other, {"12Z", "14X"}, "m/s^2").find("skip_missing"), std::string::npos);
  const auto record = select_record(other,
                                    {{.column = "14X", .owner = "a", .unit = "N"},
                                     {.column = "12Z", .owner = "a", .unit = "m/s^2"},
                                     {.column = "14:-X", .owner = "a", .unit = "m/s^2"}},
                                    {.missing = true}, "test.unv");
  EXPECT_EQ(record.start, 0.0);
  EXPECT_EQ(record.samples(), 5);
  EXPECT_EQ(record.values(1, 2), 3.0);
  EXPECT_TRUE(std::isnan(record.values(1, 3)));
  EXPECT_TRUE(std::isnan(record.values(2, 1)));
  EXPECT_DOUBLE_EQ(record.values(2, 4), 3 * 9.80665);
}

TEST_F(MeasuredSelection, TheRateIsThatOfTheTimesTheIntervalOrTheCase) {
  auto some = file();
  some.channels[0].interval = 0.0;
  EXPECT_NE(refusal(some, {"12Z"}, "m/s^2").find("sample_rate"), std::string::npos);
  const std::vector<WantedChannel> wanted = {{.column = "12Z", .owner = "a", .unit = "m/s^2"}};
  EXPECT_EQ(select_record(some, wanted, {.sample_rate = 50.0}, "f").sample_rate, 50.0);
  some.channels[0].times = vector({1.0, 1.25, 1.5});
  EXPECT_EQ(select_record(some, wanted, {}, "f").sample_rate, 4.0);
  EXPECT_EQ(select_record(some, wanted, {}, "f").start, 1.0);
  some.channels[0].times = vector({1.0, 1.25, 2.5});
  EXPECT_NE(refusal(some, {"12Z"}, "m/s^2").find("resample"), std::string::npos);
  EXPECT_NE(refusal(file(), {"12Z"}, "m/s^2", {.sample_rate = 99.0}).find("99 Hz was given"), std::string::npos);
}

TEST_F(MeasuredSelection, SamplesThatAreNoNumbersAreRefusedOrMissing) {
  auto some = file();
  some.channels[0].values[1] = std::numeric_limits<double>::infinity();
  EXPECT_NE(refusal(some, {"12Z"}, "m/s^2").find("at 0.01 s"), std::string::npos);
  EXPECT_TRUE(std::isnan(values(some, "12Z", "m/s^2", {.missing = true})[1]));
}

using UniversalRecords = UniversalFiles;

TEST_F(UniversalRecords, BecomeRecordsOfACase) {
  const auto path =
      file(Function{.points = 3, .ordinate = {12, "A", "g"}}.with("1 2 3\n") +
               Function{.response = 14, .direction = -1, .points = 3, .ordinate = {8, "d", "mm"}}.with("1 2 3\n"),
           "run.txt");
  const Record record = read_record_file(path,
                                         {{.column = "14+x", .owner = "sensors.d", .unit = "m"},
                                          {.column = "Wing tip", .owner = "sensors.a", .unit = "m/s^2"}},
                                         {});
  EXPECT_EQ(record.sample_rate, 100.0);
  EXPECT_EQ(record.values.row(0).transpose(), vector({-1e-3, -2e-3, -3e-3}));
  EXPECT_DOUBLE_EQ(record.values(1, 2), 3 * 9.80665);
  EXPECT_EQ(record.channels[0].name, "14+x");
}

TEST_F(UniversalRecords, GiveFrequencyResponsesOfOneInput) {
  const auto frf = [](long response, int direction, long reference, const std::string& samples) {
    return Function{.type = 4,
                    .response = response,
                    .direction = direction,
                    .reference = reference,
                    .reference_direction = -3,
                    .data = 5,
                    .points = 2,
                    .step = "1.00000E+00",
                    .text = "H",
                    .abscissa = {18},
                    .ordinate = {12},
                    .denominator = {13}}
        .with(samples);
  };
  const auto one = file(frf(1, 3, 9, "1 2 3 4\n") + frf(2, -3, 9, "5 6 7 8\n"));
  const auto all = read_frequency_responses(one);
  EXPECT_EQ(all.lines, vector({0, 1}));
  EXPECT_EQ(all.outputs[1].name, "2:-Z/9:-Z");
  EXPECT_EQ(all.outputs[1].unit, "(m/s^2)/(N)");
  EXPECT_EQ(all.values(1, 1), std::complex<double>(7, 8));
  EXPECT_FALSE(all.magnitudes_only);
  const auto turned = read_frequency_responses(one, {.outputs = {"2+Z", "2:+Z/9:+Z"}});
  EXPECT_EQ(turned.values(1, 0), std::complex<double>(-7, -8));
  EXPECT_EQ(turned.values(1, 1), std::complex<double>(7, 8)) << "turned twice";
  const auto two = file(frf(1, 3, 9, "1 2 3 4\n") + frf(1, 3, 8, "5 6 7 8\n"));
  EXPECT_THROW(read_frequency_responses(two), InvalidInput) << "two inputs";
  EXPECT_THROW(read_frequency_responses(two, {.outputs = {"1Z"}}), InvalidInput) << "ambiguous";
  EXPECT_EQ(read_frequency_responses(two, {.outputs = {"1z/8-z"}}).values(0, 0), std::complex<double>(5, 6));
  EXPECT_THROW(read_frequency_responses(two, {.content = FrfColumnContent::decibel}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
