#include <array>
#include <charconv>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/formats/tables/csv.hpp"

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
  write_file_atomically(path, text);
}

}  // namespace kalfem
