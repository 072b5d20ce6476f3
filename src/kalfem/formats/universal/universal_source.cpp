// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/universal/universal_source.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/formats/tables/text_table.hpp"

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
    : mapped_(std::make_unique<const MappedFile>(file)), bytes_(mapped_->bytes()), file_(file.string()) {}

UniversalSource::UniversalSource(std::string content, std::string name)
    : content_(std::make_unique<const std::string>(std::move(content))), bytes_(*content_), file_(std::move(name)) {}

bool UniversalSource::next() {
  if (std::exchange(again_, false)) return true;
  if (at_ == bytes_.size()) return false;
  const auto rest = bytes_.substr(at_, longest_line + 1);
  const std::size_t length = std::min(rest.find('\n'), rest.size());
  ++number_;
  if (length > longest_line)
    throw problem("the line is longer than " + std::to_string(longest_line >> 20) + " MiB",
                  "no universal file has such lines: it is damaged", "export it again");
  cut_off_ = length == rest.size();
  line_ = rest.substr(0, length);
  at_ += length + (cut_off_ ? 0 : 1);
  if (line_.ends_with('\r')) line_.pop_back();
  if (number_ == 1 && line_.starts_with(byte_order_mark)) line_.erase(0, byte_order_mark.size());
  return true;
}

void UniversalSource::rewind() {
  at_ = 0;
  number_ = 0;
  again_ = cut_off_ = false;
}

InvalidInput UniversalSource::problem(std::string what, std::string why, std::string fix) const {
  return InvalidInput(Issue{place(), std::move(what), std::move(why), std::move(fix)});
}

bool UniversalSource::mark_follows(std::uint64_t bytes) const {
  constexpr std::size_t looked_at = 32;
  if (bytes >= bytes_left()) return false;
  std::string_view text = bytes_.substr(at_ + bytes, looked_at);
  text.remove_prefix(std::min(text.find_first_not_of(" \r\n"), text.size()));
  return text.starts_with("-1") && text.substr(2).find_first_not_of(" \r") == text.substr(2).find('\n');
}

std::string UniversalSource::take(std::uint64_t bytes) {
  std::string content(bytes_.substr(at_, bytes));
  at_ += content.size();
  number_ += static_cast<int>(std::ranges::count(content, '\n'));
  return content;
}

}  // namespace kalfem
