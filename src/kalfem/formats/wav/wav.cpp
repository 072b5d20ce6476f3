// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/wav/wav.hpp"

#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/formats/mapped_file.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/wav/wav_blocks.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::string_view begins_wave64 = "riff\x2E\x91\xCF\x11";

[[noreturn]] void refuse(const std::filesystem::path& path, std::string what, std::string why) {
  throw InvalidInput(Issue{{path.string(), 0}, std::move(what), std::move(why), "export the file again"});
}

std::string channel_name(std::size_t number) { return "channel_" + std::to_string(number + 1); }

// --- samples as they are stored ---

/// A whole number of three bytes.
double three_bytes(const char* at, bool big_endian) {
  const auto byte = [&](int i) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(at[big_endian ? 2 - i : i]));
  };
  const std::uint32_t bits = byte(0) << 8U | byte(1) << 16U | byte(2) << 24U;
  return static_cast<double>(static_cast<std::int32_t>(bits)) / 256.0;
}

template <class Stored>
double number(const char* at, bool big_endian) {
  return static_cast<double>(value_at<Stored>(at, big_endian));
}

double from_middle(const char* at, bool /*big_endian*/) {
  return static_cast<double>(static_cast<unsigned char>(*at)) - 128.0;
}

using Reader = double (*)(const char*, bool);

/// Reads a sample of so many bytes; null: they are compressed.
Reader reader_of(int kind, int bytes) {
  constexpr int whole_numbers = 1, floats = 3;
  if (kind == floats) return bytes == 4 ? number<float> : bytes == 8 ? number<double> : nullptr;
  if (kind != whole_numbers) return nullptr;
  constexpr Reader readers[] = {from_middle, number<std::int16_t>, three_bytes, number<std::int32_t>};
  return bytes >= 1 && bytes <= 4 ? readers[bytes - 1] : nullptr;
}

MeasuredFile read_plain(const std::filesystem::path& path, const WavBlocks& blocks, Reader reader) {
  const auto& format = blocks.format;
  const int bytes = format.frame / format.channels;
  const double full_scale = format.kind == 3 ? 1.0 : std::ldexp(1.0, 8 * bytes - 1);
  const auto frame = static_cast<std::size_t>(format.frame);
  const std::size_t frames = blocks.samples.size() / frame;
  if (frames == 0) refuse(path, "the WAV file holds no samples", "it is empty or damaged");
  MeasuredFile file{.format = "WAV file", .skipped = blocks.skipped};
  for (std::size_t c = 0; c < static_cast<std::size_t>(format.channels); ++c) {
    VectorXd values(static_cast<Index>(frames));
    const char* at = blocks.samples.data() + c * static_cast<std::size_t>(bytes);
    for (double& value : values) {
      value = reader(at, blocks.big_endian) / full_scale;
      at += frame;
    }
    file.channels.push_back({.name = channel_name(c),
                             .description = blocks.title,
                             .interval = 1.0 / format.rate,
                             .values = std::move(values)});
  }
  for (const auto& note : blocks.notes)
    file.notes.push_back(path.string() + ": " + note + "; its " + std::to_string(frames) + " samples are taken");
  if (const std::size_t rest = blocks.samples.size() % frame; rest > 0)
    file.notes.push_back(path.string() + ": " + std::to_string(rest) + " bytes at the end are no whole sample");
  return file;
}

// --- compressed samples ---

struct Close {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using Sound = std::unique_ptr<SNDFILE, Close>;

Sound open(const std::filesystem::path& path, SF_INFO& info) {
  require_regular_file(path);
  Sound sound(sf_open(path.c_str(), SFM_READ, &info));
  if (!sound) refuse(path, "the WAV file cannot be read", sf_strerror(nullptr));
  const int kind = info.format & SF_FORMAT_TYPEMASK;
  if (kind != SF_FORMAT_WAV && kind != SF_FORMAT_WAVEX && kind != SF_FORMAT_RF64 && kind != SF_FORMAT_W64)
    refuse(path, "the file is no WAV file", "it holds sound of another format");
  if (info.channels < 1 || info.samplerate < 1)
    refuse(path, "the WAV file states no channels or no rate", "it is damaged");
  return sound;
}

/// Channels x samples, block by block: what a header states is not believed before it is read.
std::vector<std::vector<double>> read_samples(SNDFILE* sound, int channels) {
  const sf_count_t block = std::max<sf_count_t>(1, (1 << 20) / channels);
  std::vector<std::vector<double>> samples(static_cast<std::size_t>(channels));
  std::vector<double> frames(static_cast<std::size_t>(channels) * static_cast<std::size_t>(block));
  while (true) {
    const sf_count_t count = sf_readf_double(sound, frames.data(), block);
    if (count <= 0) return samples;
    for (std::size_t c = 0; c < samples.size(); ++c)
      for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
        samples[c].push_back(frames[k * samples.size() + c]);
  }
}

MeasuredFile read_compressed(const std::filesystem::path& path, const WavBlocks& blocks) {
  SF_INFO info{};
  const Sound sound = open(path, info);
  MeasuredFile file{.format = "WAV file", .skipped = blocks.skipped};
  const auto samples = read_samples(sound.get(), info.channels);
  if (samples.front().empty()) refuse(path, "the WAV file holds no samples", "it is empty or damaged");
  for (const auto& channel : samples)
    file.channels.push_back({.name = channel_name(file.channels.size()),
                             .description = blocks.title,
                             .interval = 1.0 / info.samplerate,
                             .values = VectorXd::Map(channel.data(), std::ssize(channel))});
  if (std::ssize(samples.front()) < info.frames || !blocks.notes.empty())
    file.notes.push_back(path.string() + ": the file is shorter than it states; its " +
                         std::to_string(samples.front().size()) + " samples are taken");
  return file;
}

}  // namespace

bool begins_wav(std::string_view head) {
  if (head.starts_with(begins_wave64)) return true;
  const bool container =
      head.starts_with("RIFF") || head.starts_with("RIFX") || head.starts_with("RF64") || head.starts_with("BW64");
  return container && head.size() >= 12 && head.substr(8, 4) == "WAVE";
}

MeasuredFile read_wav(const std::filesystem::path& path) {
  const MappedFile mapped(path);
  if (!begins_wav(mapped.bytes())) refuse(path, "the file is no WAV file", "it does not begin as one");
  if (mapped.bytes().starts_with(begins_wave64)) return read_compressed(path, {});
  const WavBlocks blocks = find_wav_blocks(mapped.bytes());
  const auto& format = blocks.format;
  if (!blocks.has_format || format.channels < 1 || !(format.rate >= 1.0))
    refuse(path, "the WAV file states no channels or no rate", "it is damaged");
  if (!blocks.has_samples) refuse(path, "the WAV file holds no samples", "it is empty or damaged");
  const bool whole = format.frame > 0 && format.frame % format.channels == 0;
  const Reader reader = whole ? reader_of(format.kind, format.frame / format.channels) : nullptr;
  return reader != nullptr ? read_plain(path, blocks, reader) : read_compressed(path, blocks);
}

}  // namespace kalfem
