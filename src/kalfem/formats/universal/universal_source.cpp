#include "kalfem/formats/universal/universal_source.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <utility>

namespace kalfem {
namespace {

constexpr std::size_t mark_columns = 6;

std::string_view trimmed_end(std::string_view line) {
  while (!line.empty() && (line.back() == ' ' || line.back() == '\t' || line.back() == '\r')) line.remove_suffix(1);
  return line;
}

}  // namespace

bool is_universal_mark(std::string_view line) {
  const std::string_view text = trimmed_end(line);
  return text.size() >= 2 && text.size() <= mark_columns && text.ends_with("-1") &&
         text.find_first_not_of(' ') == text.size() - 2;
}

UniversalSource::UniversalSource(const std::filesystem::path& file)
    : stream_(std::make_unique<std::ifstream>(file, std::ios::binary)), file_(file.string()) {
  if (!*stream_ || std::filesystem::is_directory(file))
    throw InvalidInput(
        Issue{{file_, 0}, "the file cannot be read", "it does not exist or is not readable", "check the path"});
  measure();
}

UniversalSource::UniversalSource(std::string content, std::string name)
    : stream_(std::make_unique<std::istringstream>(std::move(content))), file_(std::move(name)) {
  measure();
}

void UniversalSource::measure() {
  stream_->seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(0, stream_->tellg()));
  stream_->seekg(0);
}

bool UniversalSource::next() {
  if (std::exchange(again_, false)) return true;
  if (!std::getline(*stream_, line_)) return false;
  cut_off_ = stream_->eof();
  if (line_.ends_with('\r')) line_.pop_back();
  if (number_ == 0 && line_.starts_with("\xEF\xBB\xBF")) line_.erase(0, 3);
  ++number_;
  return true;
}

void UniversalSource::rewind() {
  stream_->clear();
  stream_->seekg(0);
  number_ = 0;
  again_ = cut_off_ = false;
}

InvalidInput UniversalSource::problem(std::string what, std::string why, std::string fix) const {
  return InvalidInput(Issue{place(), std::move(what), std::move(why), std::move(fix)});
}

std::uint64_t UniversalSource::bytes_left() {
  if (stream_->eof()) return 0;
  return size_ - std::min(size_, static_cast<std::uint64_t>(stream_->tellg()));
}

bool UniversalSource::mark_follows(std::uint64_t bytes) {
  const std::uint64_t left = bytes_left();
  if (bytes >= left) return false;
  const auto here = stream_->tellg();
  std::array<char, 32> buffer{};
  stream_->seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
  stream_->read(buffer.data(), buffer.size());
  std::string_view text(buffer.data(), static_cast<std::size_t>(stream_->gcount()));
  stream_->clear();
  stream_->seekg(here);
  text.remove_prefix(std::min(text.find_first_not_of(" \r\n"), text.size()));
  return text.starts_with("-1") && text.substr(2).find_first_not_of(" \r") == text.substr(2).find('\n');
}

std::string UniversalSource::take(std::uint64_t bytes) {
  std::string content(bytes, '\0');
  stream_->read(content.data(), static_cast<std::streamsize>(bytes));
  number_ += static_cast<int>(std::ranges::count(content, '\n'));
  return content;
}

}  // namespace kalfem
