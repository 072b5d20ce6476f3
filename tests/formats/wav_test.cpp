// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/wav/wav.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "tdms_file.hpp"

namespace kalfem {
namespace {

using test::raw;
using Numbers = std::vector<double>;

std::string u16(double value) { return raw<std::uint16_t>({value}); }
std::string u32(double value) { return raw<std::uint32_t>({value}); }
std::string u64(double value) { return raw<std::uint64_t>({value}); }

constexpr int whole_numbers = 1, floats = 3;

std::string format_block(int kind, int channels, int bits, int rate) {
  const int frame = channels * bits / 8;
  return "fmt " + u32(16) + u16(kind) + u16(channels) + u32(rate) + u32(rate * frame) + u16(frame) + u16(bits);
}

/// `stated`: bytes of the samples as the header has them.
std::string wav(int kind, int channels, int bits, const std::string& samples, std::size_t stated, int rate = 1000) {
  const std::string blocks = format_block(kind, channels, bits, rate) + "data" + u32(double(stated)) + samples;
  return "RIFF" + u32(double(4 + blocks.size())) + "WAVE" + blocks;
}

std::string three_bytes(const Numbers& numbers) {
  std::string bytes;
  for (const double number : numbers) bytes += raw<std::int32_t>({number}).substr(0, 3);
  return bytes;
}

class WavFiles : public testing::Test {
protected:
  MeasuredFile read(const std::string& bytes) const {
    std::ofstream(folder_ / "run.wav", std::ios::binary) << bytes;
    return read_wav(folder_ / "run.wav");
  }
  static Numbers values(const MeasuredFile& file, std::size_t channel) {
    return {file.channels[channel].values.begin(), file.channels[channel].values.end()};
  }
  ScratchFolder folder_{"wav"};
};

TEST_F(WavFiles, WholeNumbersHaveTheFullScaleOfOne) {
  const auto file = read(wav(whole_numbers, 2, 16, raw<std::int16_t>({16384, -32768, 0, 8192}), 8));
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(values(file, 0), (Numbers{0.5, 0.0}));
  EXPECT_EQ(values(file, 1), (Numbers{-1.0, 0.25}));
  EXPECT_EQ(file.channels[1].name, "channel_2");
  EXPECT_EQ(file.channels[1].interval, 1e-3);
  EXPECT_EQ(file.channels[1].unit, "");
  EXPECT_TRUE(file.notes.empty());
  EXPECT_EQ(values(read(wav(whole_numbers, 1, 24, three_bytes({4194304, -8388608}), 6)), 0), (Numbers{0.5, -1.0}));
}

TEST_F(WavFiles, FloatsAreAsTheyAre) {
  EXPECT_EQ(values(read(wav(floats, 1, 32, raw<float>({2.5, -7}), 8)), 0), (Numbers{2.5, -7}));
  EXPECT_EQ(values(read(wav(floats, 1, 64, raw<double>({1e-9, 3e4}), 16)), 0), (Numbers{1e-9, 3e4}));
}

TEST_F(WavFiles, LargeOnesStateTheirSizeElsewhere) {
  const auto samples = raw<float>({1, 2, 3});
  const std::string sizes = "ds64" + u32(28) + u64(0) + u64(12) + u64(3) + u32(0);
  const std::string blocks = sizes + format_block(floats, 1, 32, 48000) + "data" + u32(4294967295.0) + samples;
  const auto file = read("RF64" + u32(4294967295.0) + "WAVE" + blocks);
  EXPECT_EQ(values(file, 0), (Numbers{1, 2, 3}));
}

TEST_F(WavFiles, SayWhereTheyAreShorterThanTheyState) {
  const auto file = read(wav(whole_numbers, 1, 16, raw<std::int16_t>({1, 2, 3}), 4000));
  EXPECT_EQ(file.channels[0].values.size(), 3);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("shorter than it states"), std::string::npos);
}

TEST_F(WavFiles, OfRecordingsThatWereNeverFinishedKeepWhatIsThere) {
  const auto samples = raw<std::int16_t>({16384, -16384, 8192});
  for (const std::size_t stated : {std::size_t{0}, std::size_t{4294967295}}) {
    const auto file = read(wav(whole_numbers, 1, 16, samples, stated));
    EXPECT_EQ(values(file, 0), (Numbers{0.5, -0.5, 0.25}));
    EXPECT_EQ(file.notes.size(), 1u);
  }
}

TEST_F(WavFiles, LargeOnesSayWhereTheyAreCutOff) {
  const auto samples = raw<float>({1, 2, 3});
  const std::string sizes = "ds64" + u32(28) + u64(0) + u64(120) + u64(30) + u32(0);
  const std::string blocks = sizes + format_block(floats, 1, 32, 48000) + "data" + u32(4294967295.0) + samples;
  for (const std::string kind : {"RF64", "BW64"}) {
    const auto file = read(kind + u32(4294967295.0) + "WAVE" + blocks);
    EXPECT_EQ(values(file, 0), (Numbers{1, 2, 3}));
    ASSERT_EQ(file.notes.size(), 1u);
    EXPECT_NE(file.notes[0].find("shorter than it states"), std::string::npos);
  }
}

TEST_F(WavFiles, MayHaveOtherBlocksOfOddLengthWithAndWithoutAFillingByte) {
  const auto samples = raw<std::int16_t>({16384, -16384});
  for (const std::string& filling : {std::string(1, '\0'), std::string()}) {
    const std::string blocks = "JUNK" + u32(5) + "abcde" + filling + format_block(whole_numbers, 1, 16, 1000) + "LIST" +
                               u32(18) + "INFOINAM" + u32(6) + std::string("Run 7\0", 6) + "data" + u32(4) + samples +
                               "data" + u32(4) + samples;
    const auto file = read("RIFF" + u32(double(4 + blocks.size())) + "WAVE" + blocks);
    EXPECT_EQ(values(file, 0), (Numbers{0.5, -0.5}));
    EXPECT_EQ(file.channels[0].description, "Run 7");
    EXPECT_EQ(file.skipped.size(), 1u);  // the second block of samples
  }
}

TEST_F(WavFiles, OfTheExtensibleKindStateTheirKindElsewhere) {
  const std::string block = "fmt " + u32(40) + u16(0xfffe) + u16(1) + u32(1000) + u32(3000) + u16(3) + u16(24) +
                            u16(22) + u16(24) + u32(0) + u16(whole_numbers) + std::string(14, 'x');
  const std::string blocks = block + "data" + u32(3) + three_bytes({4194304});
  EXPECT_EQ(values(read("RIFF" + u32(double(4 + blocks.size())) + "WAVE" + blocks), 0), (Numbers{0.5}));
}

TEST_F(WavFiles, SayWhereBytesAreNoWholeSample) {
  const auto file = read(wav(whole_numbers, 2, 16, raw<std::int16_t>({1, 2, 3}), 6));
  EXPECT_EQ(file.channels[0].values.size(), 1);
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST_F(WavFiles, OtherFilesAreRefused) {
  for (const std::string& bytes :
       {std::string("hello"), std::string("RIFF\0\0\0\0WAVE", 12), wav(whole_numbers, 1, 16, "", 0)})
    EXPECT_THROW(read(bytes), InvalidInput);
}

TEST_F(WavFiles, DamagedOnesAreReadOrRefused) {
  const std::vector<std::string> sound = {wav(whole_numbers, 2, 24, three_bytes(Numbers(60, 1e6)), 180),
                                          wav(floats, 1, 32, raw<float>(Numbers(40, 0.5)), 160)};
  std::mt19937 random(1);
  int read_ones = 0;
  for (int i = 0; i < 100; ++i) {
    auto bytes = sound[i % 2];
    for (auto changes = 1 + random() % 3; changes > 0; --changes) bytes[random() % 60] = char(random());
    if (i % 3 == 0) bytes.resize(random() % bytes.size());
    try {
      read(bytes);
      ++read_ones;
    } catch (const InvalidInput&) {
    }
  }
  EXPECT_GT(read_ones, 10);
}

}  // namespace
}  // namespace kalfem
