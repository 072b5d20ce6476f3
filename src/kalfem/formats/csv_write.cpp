#include <array>
#include <charconv>
#include <fstream>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/csv.hpp"

namespace kalfem {

namespace {

std::string title(const Channel& channel) {
  const std::string text = channel.unit.empty() ? channel.name : channel.name + " [" + channel.unit + "]";
  return text.find_first_of(";,\t \"") == std::string::npos ? text : '"' + text + '"';
}

/// The shortest text that reads back as the same number.
void append(std::string& text, double value) {
  std::array<char, 32> digits{};
  text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

}  // namespace

void write_csv(const std::filesystem::path& path, const TimeSeries& series, char separator) {
  std::string text = title({"t", "s"});
  for (const auto& channel : series.channels) (text += separator) += title(channel);
  text += '\n';
  for (Eigen::Index k = 0; k < series.samples(); ++k) {
    append(text, series.time(k));
    for (Eigen::Index j = 0; j < series.values.cols(); ++j) append(text += separator, series.values(k, j));
    text += '\n';
  }
  std::ofstream stream(path, std::ios::binary);
  stream << text << std::flush;
  if (!stream)
    throw InvalidInput(
        Issue{{path.string(), 0}, "the file cannot be written", "", "check the folder and its permissions"});
}

}  // namespace kalfem
