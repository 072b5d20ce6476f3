// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh_scanner.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>

namespace kalfem {

namespace {

const char* const mend_truncated = "export the mesh again; the file may be truncated or damaged";

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

std::string to_string(std::string_view word) { return "'" + printable(word) + "'"; }

}  // namespace

std::string printable(std::string_view word) {
  std::string text(word.substr(0, 40));
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 32 || c > 126; }, '?');
  return text;
}

void GmshScanner::skip_blanks() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
}

bool GmshScanner::at_end() {
  skip_blanks();
  return at_ == text_.size();
}

bool GmshScanner::next_is(std::string_view word) {
  skip_blanks();
  return std::string_view(text_).substr(at_).starts_with(word);
}

std::string_view GmshScanner::line() {
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  std::string_view content = std::string_view(text_).substr(at_, end - at_);
  if (content.ends_with('\r')) content.remove_suffix(1);
  at_ = std::min(end + 1, text_.size());
  return trimmed(content);
}

std::size_t GmshScanner::start() {
  if (!binary_) skip_blanks();
  return at_;
}

std::string_view GmshScanner::word(const char* what) {
  if (at_end()) fail(at_, "the file ends instead of " + std::string(what) + " is expected", "", mend_truncated);
  std::size_t end = at_;
  while (end < text_.size() && !is_space(text_[end])) ++end;
  const auto found = std::string_view(text_).substr(at_, end - at_);
  if (found.front() == '$')
    fail(at_, "the section ends instead of " + std::string(what) + " is expected",
         "it announces more entries than it has", mend_truncated);
  return found;
}

std::int64_t GmshScanner::text_integer(const char* what) {
  const std::string_view found = word(what);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
  if (error == std::errc::result_out_of_range)
    fail(at_, std::string(what) + " is " + to_string(found), "it must fit into 64 bits", "renumber the mesh");
  if (error != std::errc{} || end != found.data() + found.size())
    fail(at_, std::string(what) + " is " + to_string(found), "it must be a whole number", "correct the line");
  at_ += found.size();
  return value;
}

template <typename Number>
Number GmshScanner::bytes(const char* what) {
  if (text_.size() - at_ < sizeof(Number))
    fail(at_, "the file ends instead of " + std::string(what) + " is expected", "", mend_truncated);
  Number value{};
  std::memcpy(&value, text_.data() + at_, sizeof value);
  at_ += sizeof value;
  return value;
}

// One call reads a number from text or from binary data. Binary files store tags as 4 or 8 bytes, so int32() and
// int64() differ there; in text they are the same.
std::int64_t GmshScanner::int32(const char* what) { return binary_ ? bytes<std::int32_t>(what) : text_integer(what); }

std::int64_t GmshScanner::int64(const char* what) { return binary_ ? bytes<std::int64_t>(what) : text_integer(what); }

double GmshScanner::real(const char* what) {
  if (binary_) return bytes<double>(what);
  const std::string_view found = word(what);
  const char* const begin = found.data() + (found.front() == '+' && !found.starts_with("+-") ? 1 : 0);
  const char* const last = found.data() + found.size();
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, last, value);
  if (error == std::errc::invalid_argument || end != last)
    fail(at_, std::string(what) + " is " + to_string(found), "it must be a number", "correct the line");
  at_ += found.size();
  // Too large and too small are the same error; the C function tells them apart as infinity and nearly zero.
  return error == std::errc::result_out_of_range ? std::strtod(begin, nullptr) : value;
}

// A count is checked against the bytes that are left before memory is taken for it: a damaged file asks for any number.
std::int64_t GmshScanner::check_count(std::int64_t count, const char* items, std::size_t start, std::size_t words,
                                      std::size_t bytes) {
  const std::string announced = std::to_string(count) + " " + items + " are announced";
  if (count < 0) fail(start, announced, "a count cannot be negative", mend_truncated);
  const std::size_t shortest = binary_ ? bytes : 2 * words;  // a digit and a blank
  if (static_cast<std::uint64_t>(count) > (text_.size() - at_) / shortest + 1)
    fail(start, announced, "the rest of the file is too short for them", mend_truncated);
  return count;
}

// In text each record stands on a line of its own. Words alone would not show a missing number: the next line's first
// number would take its place.
void GmshScanner::end_record(std::size_t start, const char* what) {
  if (binary_) return;
  std::size_t next = at_;
  while (next < text_.size() && is_space(text_[next]) && text_[next] != '\n') ++next;
  const bool broken = std::memchr(text_.data() + start, '\n', at_ - start) != nullptr;
  if (!broken && (next == text_.size() || text_[next] == '\n')) return;
  fail(start, "the line holds too " + std::string(broken ? "few" : "many") + " numbers for " + what,
       "each must be on its own line", "correct the line");
}

void GmshScanner::end_section(std::string_view name) {
  const std::string end = "$End" + std::string(name);
  if (at_end()) fail(at_, "the file ends before " + end, "", mend_truncated);
  const std::size_t begin = at_;
  const std::string_view found = line();
  if (found == end) return;
  fail(begin, "there is " + to_string(found) + " where " + end + " is expected",
       "the section has more entries than it announces, or its end is missing", mend_truncated);
}

// A section that kalfem does not need is passed over as bytes; the end is looked for at the start of a line only.
void GmshScanner::skip_section(std::string_view name, std::size_t start) {
  const std::string end = "$End" + std::string(name);
  at_ = text_.find("\n" + end, start);
  if (at_ == std::string::npos) {
    at_ = text_.size();
    fail(start, "the section $" + printable(name) + " has no end", "", mend_truncated);
  }
  end_section(name);
}

// Lines are counted on from the last position, so that many messages cost one pass over the file.
int GmshScanner::line_of(std::size_t position) {
  if (position < counted_to_) {
    counted_to_ = 0;
    lines_ = 1;
  }
  const auto begin = text_.begin();
  lines_ += static_cast<int>(std::count(begin + static_cast<std::ptrdiff_t>(counted_to_),
                                        begin + static_cast<std::ptrdiff_t>(position), '\n'));
  counted_to_ = position;
  return lines_;
}

SourceLocation GmshScanner::place(std::size_t position) { return {problems_.file(), binary_ ? 0 : line_of(position)}; }

void GmshScanner::note(std::size_t position, const std::string& what, const std::string& why, const std::string& fix) {
  if (binary_)
    problems_.add(0, what + " (byte " + std::to_string(position) + ")", why, fix);
  else
    problems_.add(line_of(position), what, why, fix);
}

void GmshScanner::fail(std::size_t position, const std::string& what, const std::string& why, const std::string& fix) {
  note(position, what, why, fix);
  problems_.raise();
  throw InvalidInput(what, why, fix);  // not reached: a problem was just noted
}

}  // namespace kalfem
