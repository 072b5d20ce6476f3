#include "kalfem/formats/wav.hpp"

#include <sndfile.h>

#include <algorithm>
#include <memory>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

[[noreturn]] void refuse(const std::filesystem::path& path, std::string what, std::string why) {
  throw InvalidInput(Issue{{path.string(), 0}, std::move(what), std::move(why), "export the file again"});
}

struct Close {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using Sound = std::unique_ptr<SNDFILE, Close>;

Sound open(const std::filesystem::path& path, SF_INFO& info) {
  Sound sound(sf_open(path.c_str(), SFM_READ, &info));
  if (!sound) refuse(path, "the WAV file cannot be read", sf_strerror(nullptr));
  const int kind = info.format & SF_FORMAT_TYPEMASK;
  if (kind != SF_FORMAT_WAV && kind != SF_FORMAT_WAVEX && kind != SF_FORMAT_RF64 && kind != SF_FORMAT_W64)
    refuse(path, "the file is no WAV file", "it holds sound of another format");
  if (info.channels < 1 || info.samplerate < 1)
    refuse(path, "the WAV file states no channels or no rate", "it is damaged");
  return sound;
}

/// What the library says about the block of samples: "data : 800 (should be 796)".
bool is_shorter_than_stated(SNDFILE* sound) {
  std::string log(1 << 14, '\0');
  log.resize(static_cast<std::size_t>(
      std::max(0, sf_command(sound, SFC_GET_LOG_INFO, log.data(), static_cast<int>(log.size())))));
  const auto data = log.find("data : ");
  return data != std::string::npos &&
         log.substr(data, log.find('\n', data) - data).find("should be") != std::string::npos;
}

/// Channels x samples, block by block: what a header states is not believed before it is read.
std::vector<std::vector<double>> read_samples(SNDFILE* sound, int channels) {
  constexpr sf_count_t block = 1 << 16;
  std::vector<std::vector<double>> samples(static_cast<std::size_t>(channels));
  std::vector<double> frames(static_cast<std::size_t>(channels) * block);
  while (true) {
    const sf_count_t count = sf_readf_double(sound, frames.data(), block);
    if (count <= 0) return samples;
    for (std::size_t c = 0; c < samples.size(); ++c)
      for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
        samples[c].push_back(frames[k * samples.size() + c]);
  }
}

}  // namespace

bool begins_wav(std::string_view head) {
  const bool container = head.starts_with("RIFF") || head.starts_with("RIFX") || head.starts_with("RF64");
  return container && head.size() >= 12 && head.substr(8, 4) == "WAVE";
}

MeasuredFile read_wav(const std::filesystem::path& path) {
  SF_INFO info{};
  const Sound sound = open(path, info);
  MeasuredFile file{.format = "WAV file"};
  const auto samples = read_samples(sound.get(), info.channels);
  if (samples.front().empty()) refuse(path, "the WAV file holds no samples", "it is empty or damaged");
  const char* title = sf_get_string(sound.get(), SF_STR_TITLE);
  for (const auto& channel : samples)
    file.channels.push_back({.name = "channel_" + std::to_string(file.channels.size() + 1),
                             .description = title == nullptr ? "" : title,
                             .interval = 1.0 / info.samplerate,
                             .values = Eigen::VectorXd::Map(channel.data(), std::ssize(channel))});
  if (std::ssize(samples.front()) < info.frames || is_shorter_than_stated(sound.get()))
    file.notes.push_back(path.string() + ": the file is shorter than it states; its " +
                         std::to_string(samples.front().size()) + " samples are taken");
  return file;
}

}  // namespace kalfem
