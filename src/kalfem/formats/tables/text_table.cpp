// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/text_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/mapped_file.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {

namespace {

constexpr std::size_t most_listed = 12;

bool is_blank(char c) { return c == ' ' || c == '\t'; }

std::string_view unquoted(std::string_view cell) {
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
  return cell;
}

std::vector<std::string_view> split_blanks(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin < line.size();) {
    if (is_blank(line[begin])) {
      ++begin;
      continue;
    }
    const bool quoted = line[begin] == '"';
    std::size_t end = quoted ? line.find('"', begin + 1) : line.find_first_of(" \t", begin);
    end = end == std::string_view::npos ? line.size() : end + (quoted ? 1 : 0);
    cells.push_back(unquoted(line.substr(begin, end - begin)));
    begin = end;
  }
  return cells;
}

}  // namespace

std::optional<std::string> utf16_as_utf8(std::string_view bytes) {
  constexpr std::size_t looked_at = 64;
  const auto zeros = [&](std::size_t first) {
    std::size_t count = 0;
    for (std::size_t i = first; i < std::min(bytes.size(), looked_at); i += 2) count += bytes[i] == 0 ? 1 : 0;
    return count;
  };
  bool big_endian = false;
  if (bytes.starts_with("\xFE\xFF") || bytes.starts_with("\xFF\xFE")) {
    big_endian = bytes.starts_with("\xFE\xFF");
    bytes.remove_prefix(2);
  } else {
    const std::size_t half = std::min(bytes.size(), looked_at) / 2;
    big_endian = zeros(0) == half && zeros(1) == 0;
    if (half < 8 || !(big_endian || (zeros(1) == half && zeros(0) == 0))) return std::nullopt;
  }
  std::u16string text(bytes.size() / 2, u'\0');
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto first = static_cast<unsigned char>(bytes[2 * i]), second = static_cast<unsigned char>(bytes[2 * i + 1]);
    text[i] = static_cast<char16_t>(big_endian ? first << 8U | second : second << 8U | first);
  }
  return utf8_of(text);
}

namespace {

std::string as_utf8(std::string_view bytes) {
  if (bytes.starts_with(byte_order_mark)) bytes.remove_prefix(byte_order_mark.size());
  if (auto converted = utf16_as_utf8(bytes)) return *std::move(converted);
  return std::string(bytes);
}

}  // namespace

// From each line end the last one within the next `longest_line` bytes is looked for, from behind: it is near the end.
void require_short_lines(std::string_view text, const std::string& source) {
  const char line_end = text.substr(0, longest_line + 1).find('\n') == std::string_view::npos ? '\r' : '\n';
  for (std::size_t begin = 0; text.size() - begin > longest_line;) {
    const std::size_t end = text.substr(begin, longest_line + 1).rfind(line_end);
    if (end == std::string_view::npos)
      throw InvalidInput(Issue{{source, static_cast<int>(std::ranges::count(text.substr(0, begin), line_end)) + 1},
                               "the line is longer than " + std::to_string(longest_line >> 20) + " MiB",
                               "no table or deck has such lines: the file is damaged, or it is no text",
                               "export it again, with line ends"});
    begin += end + 1;
  }
}

void require_columns(std::size_t columns, const std::string& source, int line) {
  constexpr std::size_t most = 50'000;
  if (columns > most)
    throw InvalidInput(Issue{{source, line},
                             "the table has " + std::to_string(columns) + " columns",
                             "at most " + std::to_string(most) + " channels are read",
                             "export it with one line a sample, and fewer channels"});
}

std::string read_text(const std::filesystem::path& path) {
  const MappedFile file(path);
  require_short_lines(file.bytes(), path.string());
  return as_utf8(file.bytes());
}

std::string read_content(const std::filesystem::path& path) { return as_utf8(MappedFile(path).bytes()); }

bool LineWalk::next(TextLine& line) {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find(line_end_);
  line.text = rest_.substr(0, end);
  if (line.text.ends_with('\r')) line.text.remove_suffix(1);
  line.number = ++number_;
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  return true;
}

std::vector<TextLine> split_lines(std::string_view text) {
  std::vector<TextLine> lines;
  LineWalk reader(text);
  for (TextLine line; reader.next(line);) lines.push_back(line);
  return lines;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

bool has_content(std::string_view line) {
  const std::string_view content = trimmed(line);
  return !content.empty() && content.front() != '#' && content.front() != '%';
}

std::vector<TextLine> content_lines(std::string_view text) {
  std::vector<TextLine> lines;
  LineWalk reader(text);
  for (TextLine line; reader.next(line);)
    if (has_content(line.text)) lines.push_back(line);
  return lines;
}

// The second line tells more than the first, whose titles may hold blanks and commas. A comma comes after semicolon and
// tab, as it may be the decimal sign.
char find_separator(const std::vector<TextLine>& lines) {
  const std::string_view line = lines[std::min<std::size_t>(1, lines.size() - 1)].text;
  for (const char candidate : {';', '\t', ',', ' '})
    if (trimmed(line).find(candidate) != std::string_view::npos) return candidate;
  return line.find('\t') == std::string_view::npos ? ',' : '\t';  // a row that ends in empty cells
}

char find_decimal(const std::vector<TextLine>& lines, char separator) {
  constexpr int looked_at = 50;  // lines with such a sign
  std::size_t commas = 0, points = 0;
  int found = 0;
  for (std::size_t i = 1; i < lines.size() && found < looked_at; ++i) {
    if (lines[i].text.find_first_of(",.") == std::string_view::npos) continue;
    const std::size_t before = commas + points;
    for (const auto cell : split_cells(lines[i].text, separator)) {
      if (cell.find(',') != std::string_view::npos && parse_number(cell, ',')) ++commas;
      if (cell.find('.') != std::string_view::npos && parse_number(cell, '.')) ++points;
    }
    found += commas + points > before ? 1 : 0;
  }
  return commas > points ? ',' : '.';
}

void split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  if (separator == ' ') {
    cells = split_blanks(line);
    return;
  }
  cells.clear();
  const bool has_quotes = line.find('"') != std::string_view::npos;
  bool quoted = false;
  std::size_t begin = 0;
  const auto add = [&](std::size_t end) {
    cells.push_back(unquoted(trimmed(line.substr(begin, end - begin))));
    begin = end + 1;
  };
  for (std::size_t i = 0; has_quotes && i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (!quoted && line[i] == separator) add(i);
  }
  if (!has_quotes)
    for (std::size_t i = line.find(separator); i != std::string_view::npos; i = line.find(separator, i + 1)) add(i);
  add(line.size());
}

std::vector<std::string_view> split_cells(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  split_cells(line, separator, cells);
  return cells;
}

namespace {

/// Fortran's letter of an exponent, D, as E. Nothing where the cell has none between digits.
std::optional<double> with_fortran_exponent(std::string_view cell) {
  const std::size_t letter = cell.find_first_of("dD");
  std::array<char, 64> copy{};
  if (letter == std::string_view::npos || letter == 0 || cell.size() > copy.size()) return std::nullopt;
  std::ranges::copy(cell, copy.begin());
  copy[letter] = 'E';
  double value = 0.0;
  const auto [end, error] = std::from_chars(copy.data(), copy.data() + cell.size(), value);
  return error == std::errc() && end == copy.data() + cell.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<double> parse_number(std::string_view cell, char decimal) {
  std::array<char, 64> copy{};
  if (decimal != '.') {
    if (cell.size() > copy.size() || cell.find('.') != std::string_view::npos) return std::nullopt;
    for (std::size_t i = 0; i < cell.size(); ++i) copy[i] = cell[i] == decimal ? '.' : cell[i];
    cell = {copy.data(), cell.size()};
  }
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (end != cell.data() + cell.size() || error == std::errc::invalid_argument) return with_fortran_exponent(cell);
  if (error == std::errc::result_out_of_range) return HUGE_VAL;
  return value;
}

bool is_missing_value(std::string_view cell) {
  constexpr std::array words{"", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "-nan(ind)", "1.#qnan"};
  return std::ranges::find(words, lower_case(cell)) != words.end();
}

void FileProblems::add(int line, std::string what, std::string why, std::string fix) {
  if (count_++ < most_listed) listed_.add({file_, line}, std::move(what), std::move(why), std::move(fix));
}

void FileProblems::raise() const {
  IssueList all = listed_;
  if (count_ > most_listed)
    all.add(all.issues().back().location,
            "and " + std::to_string(count_ - most_listed) + " more problems of this kind");
  all.raise();
}

NumberRows::NumberRows(std::vector<std::size_t> columns, std::vector<std::string> names, char decimal)
    : columns_(std::move(columns)), names_(std::move(names)), decimal_(decimal) {}

void NumberRows::reserve(std::size_t rows) {
  const Eigen::Index count = static_cast<Eigen::Index>(rows), apart = first_apart_ ? 1 : 0;
  if (keeps_lines_) lines_.reserve(rows);
  if (first_apart_) first_.conservativeResize(count);
  numbers_.conservativeResize(static_cast<Eigen::Index>(columns_.size()) - apart, count);
}

void NumberRows::add(int line, const std::vector<std::string_view>& cells, FileProblems& problems) {
  const auto row = static_cast<Eigen::Index>(size_++);
  if (row == numbers_.cols()) reserve(std::max<std::size_t>(64, 3 * size_ / 2));
  if (keeps_lines_) lines_.push_back(line);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::string_view cell = cells[columns_[i]];
    const std::optional<double> number = parse_number(cell, decimal_);
    const bool usable = number && std::isfinite(*number);
    const auto place = static_cast<Eigen::Index>(i) - (first_apart_ ? 1 : 0);
    (place < 0 ? first_[row] : numbers_(place, row)) = usable ? *number : NAN;
    if (usable) continue;
    const bool missing = is_missing_value(cell);
    if (missing && missing_from_ && i >= *missing_from_) continue;
    problems.add(line,
                 "column '" + names_[columns_[i]] + "' " +
                     (cell.empty() ? "is empty" : "holds '" + std::string(cell.substr(0, 40)) + "'"),
                 "every sample must be a finite number",
                 missing && !missing_from_ ? "repair or cut the record here, omit the column, or allow missing samples "
                                             "(record.skip_missing: true, or bridge_gaps of an input)"
                                           : "repair or cut the record here, or omit the column");
  }
}

Eigen::Map<const Eigen::MatrixXd> NumberRows::by_column() const {
  return {numbers_.data(), numbers_.rows(), static_cast<Eigen::Index>(size_)};
}

Eigen::MatrixXd NumberRows::take_by_column() {
  numbers_.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(size_));
  return std::move(numbers_);
}

Eigen::VectorXd NumberRows::take_first() {
  first_.conservativeResize(static_cast<Eigen::Index>(size_));
  return std::move(first_);
}

namespace {

constexpr double rate_agreement = 1e-3;

std::string shown(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 8).ptr};
}

/// By how much rounding to `unit` may move an interval; nothing when that is too much to see a gap. Coarse stamps that
/// count whole units (0, 1, 2 ...) are not rounded at all.
std::optional<double> visible_rounding(double unit, double interval) {
  if (unit < 0.75 * interval) return 1.01 * unit;
  const double units = interval / unit;
  if (std::round(units) >= 1.0 && std::abs(units - std::round(units)) < 1e-9) return 0.0;
  return std::nullopt;
}

void find_gaps(const Eigen::VectorXd& stamps, const std::vector<int>& lines, double interval, double tolerance,
               const std::string& column, FileProblems& problems) {
  tolerance += 8.0 * std::numeric_limits<double>::epsilon() * stamps.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 1; k < stamps.size(); ++k) {
    const double found = stamps(k) - stamps(k - 1);
    if (std::abs(found - interval) <= tolerance) continue;
    const double missing = std::round(found / interval) - 1.0;
    problems.add(lines[static_cast<std::size_t>(k)],
                 "'" + column + "' runs from " + shown(stamps(k - 1)) + " s to " + shown(stamps(k)) + " s",
                 found <= 0.0 ? "time must increase"
                              : "the usual interval is " + shown(interval) + " s" +
                                    (missing >= 1.0 ? "; " + shown(missing) + " samples are missing" : ""),
                 "cut the record here, resample it to equal intervals, or let samples be missing (record.skip_missing: "
                 "true, or bridge_gaps of an input)");
  }
}

}  // namespace

// A sampling rate from printed time stamps:
//   1. the typical interval, as the median over windows of many samples;
//   2. the unit of the last digit that was written, by which rounding may move an interval. Stamps too coarse to show a
//      missing sample are refused unless the rate is given;
//   3. every interval that differs by more than jitter and rounding is a gap, told with its line;
//   4. the rate is that of the whole span, rounded to the fewest decimals that its uncertainty allows.
TimeAxis time_axis(const Eigen::VectorXd& stamps, const std::vector<int>& lines, const TimeAxisOptions& options,
                   FileProblems& problems) {
  if (stamps.size() < 2) {
    problems.add(0, "the record has fewer than two samples", "a sampling rate needs two");
    return {};
  }
  const double interval = typical_interval(stamps);
  const double unit = resolution(stamps);
  if (!(interval > 0.0)) {
    problems.add(lines.front(), "the time column '" + options.column + "' does not increase", "time must increase",
                 "name the column with the time in seconds");
    return {};
  }
  const std::optional<double> rounding = visible_rounding(unit, interval);
  if (!rounding && !options.sample_rate) {
    problems.add(lines.front(),
                 "the time column '" + options.column + "' is rounded to " + shown(unit) + " s at intervals of " +
                     shown(interval) + " s",
                 "a missing sample could not be detected", "give the sampling rate");
    return {};
  }
  if (rounding) find_gaps(stamps, lines, interval, options.jitter * interval + *rounding, options.column, problems);

  const double span = stamps(stamps.size() - 1) - stamps(0);
  const double rate = static_cast<double>(stamps.size() - 1) / span;
  if (!options.sample_rate) return {stamps(0), roundest(rate, rate * (unit / span + 1e-9))};
  if (problems.empty() && !(std::abs(rate / *options.sample_rate - 1.0) <= rate_agreement + unit / span))
    problems.add(lines.front(),
                 "the time column '" + options.column + "' gives " + shown(rate) + " Hz, but " +
                     shown(*options.sample_rate) + " Hz was given",
                 "both must agree", "remove or correct the sampling rate");
  return {stamps(0), *options.sample_rate};
}

namespace {

bool is_known_unit(std::string_view text) {
  if (text == "G") return true;  // of accelerations
  try {
    parse_unit(text);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

/// A unit that kalfem knows, or at least a quotient or a power: "m/sec^2" must not pass for a part of the name.
bool is_written_like_a_unit(std::string_view text) {
  const bool only_numbers = text.find_first_not_of("0123456789.,-+ ") == std::string_view::npos;
  if (only_numbers) return false;
  const bool composed = text.find_first_of("/^") != std::string_view::npos || text.find("²") != std::string_view::npos;
  return composed || lower_case(text) == "db" || is_known_unit(text);
}

/// The title split at the last `open`, or with the unit left empty where it does not end with `close`.
Channel split_title(std::string_view title, char open, char close) {
  const std::size_t place = title.rfind(open);
  if (place == std::string_view::npos || place == 0 || !title.ends_with(close)) return {std::string(title), ""};
  const std::string_view unit = trimmed(title.substr(place + 1, title.size() - place - 2));
  return {std::string(trimmed(title.substr(0, place))), std::string(unit)};
}

}  // namespace

// "[...]" always holds a unit; "(...)" may be a part of the name, so its content must look like one.
Channel channel_of(std::string_view title) {
  if (Channel bracketed = split_title(title, '[', ']'); bracketed.name.size() < title.size()) return bracketed;
  Channel channel = split_title(title, '(', ')');
  if (is_written_like_a_unit(channel.unit)) return channel;
  return {std::string(title), ""};
}

bool is_time_name(std::string_view name) {
  constexpr std::array known{"t", "time", "t_s", "time_s", "x_value", "zeit"};
  return std::ranges::find(known, lower_case(name)) != known.end();
}

namespace {

constexpr std::array<std::string_view, 12> time_words = {"time",      "times",      "zeit",        "temps",
                                                         "tiempo",    "tempo",      "tid",         "tijd",
                                                         "timestamp", "timestamps", "zeitstempel", "uhrzeit"};
constexpr std::array<std::string_view, 8> time_units = {"s", "sec", "ms", "us", "ns", "min", "h", "sek"};

/// Letters between other characters, in small letters.
std::vector<std::string> letters_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80;
    if (letter)
      words.back() += c;
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  for (auto& word : words) word = lower_case(word);
  return words;
}

bool is_time_word(const std::string& word) { return std::ranges::find(time_words, word) != time_words.end(); }

}  // namespace

std::string unit_in_time_name(std::string_view name) {
  auto words = letters_of(name);
  if (words.size() < 2 || std::ranges::find(time_units, words.back()) == time_units.end()) return {};
  return words.back();
}

bool may_be_time_name(std::string_view name) {
  if (is_time_name(name)) return true;
  auto words = letters_of(name);
  if (!unit_in_time_name(name).empty()) words.pop_back();
  if (words.empty()) return false;
  if (words.front() == "t" && words.size() == 1) return name.starts_with('t');
  const bool stamp = words.size() > 1 && words.front() == "time" && words[1] == "stamp";
  return stamp || is_time_word(words.front()) || is_time_word(words.back());
}

bool increases(const Eigen::VectorXd& values) {
  Eigen::Index count = values.size();
  while (count > 0 && std::isnan(values[count - 1])) --count;
  for (Eigen::Index k = 1; k < count; ++k)
    if (!(values[k] > values[k - 1])) return false;
  return count > 1;
}

Eigen::Index find_channel(const std::vector<Channel>& channels, std::string_view wanted) {
  const auto place = [&](const auto& matches) {
    const auto found = std::ranges::find_if(channels, matches);
    return found == channels.end() ? Eigen::Index{-1} : static_cast<Eigen::Index>(found - channels.begin());
  };
  const Eigen::Index exact = place([&](const Channel& channel) { return channel.name == wanted; });
  if (exact >= 0) return exact;
  const Channel apart = channel_of(wanted);
  return place([&](const Channel& channel) {
    return !apart.unit.empty() && channel.name == apart.name && channel.unit == apart.unit;
  });
}

}  // namespace kalfem
