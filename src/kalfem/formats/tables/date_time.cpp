// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/date_time.hpp"

#include <charconv>
#include <chrono>
#include <cmath>
#include <utility>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

constexpr double seconds_a_day = 86400.0;

/// Takes numbers and signs off the front of a text.
class Scanner {
public:
  explicit Scanner(std::string_view text) : text_(text) {}

  /// A whole number of so many digits.
  std::optional<int> digits(std::size_t least, std::size_t most) {
    std::size_t count = 0;
    while (count < text_.size() && text_[count] >= '0' && text_[count] <= '9') ++count;
    int value = 0;
    if (count < least || count > most) return std::nullopt;
    std::from_chars(text_.data(), text_.data() + count, value);
    text_.remove_prefix(count);
    return value;
  }
  bool skip(char c) {
    if (!text_.starts_with(c)) return false;
    text_.remove_prefix(1);
    return true;
  }
  char skip_any(std::string_view characters) {
    if (text_.empty() || characters.find(text_.front()) == std::string_view::npos) return '\0';
    const char c = text_.front();
    text_.remove_prefix(1);
    return c;
  }
  void skip_blanks() { text_ = trimmed(text_); }
  [[nodiscard]] std::string_view rest() const { return text_; }

private:
  std::string_view text_;
};

std::optional<std::int64_t> days_of(int year, int month, int day) {
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

/// Three numbers with the same sign between them; the year is the one of four digits.
std::optional<std::int64_t> read_date(Scanner& text, DateOrder order) {
  const Scanner begin = text;
  const auto first = text.digits(1, 4);
  const char sign = first ? text.skip_any("-/.") : '\0';
  const auto second = sign != '\0' ? text.digits(1, 2) : std::nullopt;
  const auto third = second && text.skip(sign) ? text.digits(1, 4) : std::nullopt;
  const auto date = [&]() -> std::optional<std::int64_t> {
    if (!third) return std::nullopt;
    if (*first > 999) return days_of(*first, *second, *third);
    if (*third < 1000) return std::nullopt;
    const bool day_first = sign == '.' || *first > 12 || (*second <= 12 && order == DateOrder::day_first);
    return day_first ? days_of(*third, *second, *first) : days_of(*third, *first, *second);
  }();
  if (!date) text = begin;
  return date;
}

/// Hours of a clock of twelve, by AM or PM behind the time.
bool take_half_of_day(Scanner& text, int& hours) {
  const std::string word = lower_case(text.rest());
  const bool before = word.starts_with("am") || word.starts_with("a.m."),
             after = word.starts_with("pm") || word.starts_with("p.m.");
  if (!before && !after) return true;
  if (hours < 1 || hours > 12) return false;
  hours = hours % 12 + (after ? 12 : 0);
  text = Scanner(text.rest().substr(word[1] == '.' ? 4 : 2));
  return true;
}

/// "+01:00", "-0530", "Z": seconds ahead of Greenwich.
std::optional<double> read_zone(Scanner& text) {
  if (text.skip('Z') || text.rest().empty()) return 0.0;
  const char sign = text.skip_any("+-");
  const auto hours = sign != '\0' ? text.digits(2, 4) : std::nullopt;
  if (!hours) return std::nullopt;
  const bool together = *hours > 99;
  const int minutes = together ? *hours % 100 : text.skip(':') ? text.digits(2, 2).value_or(0) : 0;
  const double offset = 3600.0 * (together ? *hours / 100 : *hours) + 60.0 * minutes;
  return sign == '-' ? -offset : offset;
}

std::optional<double> read_clock(Scanner& text) {
  auto hours = text.digits(1, 2);
  const auto minutes = hours && text.skip(':') ? text.digits(2, 2) : std::nullopt;
  if (!minutes || *minutes > 59) return std::nullopt;
  double seconds = 0.0;
  if (text.skip(':')) {
    const auto whole = text.digits(2, 2);
    if (!whole || *whole > 60) return std::nullopt;
    seconds = *whole;
    if (text.skip_any(".,:") != '\0') {
      const std::string_view before = text.rest();
      std::size_t count = 0;
      while (count < before.size() && before[count] >= '0' && before[count] <= '9') ++count;
      const auto fraction = parse_number("0." + std::string(before.substr(0, count)), '.');
      if (count == 0 || !fraction) return std::nullopt;
      seconds += *fraction;
      text = Scanner(before.substr(count));
    }
  }
  text.skip_blanks();
  if (!take_half_of_day(text, *hours) || *hours > 24) return std::nullopt;
  text.skip_blanks();
  const auto zone = read_zone(text);
  if (!zone) return std::nullopt;
  return 3600.0 * *hours + 60.0 * *minutes + seconds - *zone;
}

}  // namespace

std::optional<DateTime> parse_date_time(std::string_view text, DateOrder order) {
  constexpr std::size_t longest = 48;
  Scanner scanner(trimmed(text));
  if (scanner.rest().size() < 4 || scanner.rest().size() > longest) return std::nullopt;
  DateTime result;
  if (const auto days = read_date(scanner, order)) {
    result.days = *days;
    result.has_date = true;
    if (scanner.rest().empty()) return result;
    if (scanner.skip_any("T ,;_") == '\0') return std::nullopt;
    scanner.skip_blanks();
  }
  const auto seconds = read_clock(scanner);
  if (!seconds || !scanner.rest().empty()) return std::nullopt;
  result.seconds = *seconds;
  result.has_time = true;
  return result;
}

namespace {

double seconds_between(const DateTime& from, const DateTime& to) {
  return static_cast<double>(to.days - from.days) * seconds_a_day + (to.seconds - from.seconds);
}

/// Of the cells from the first to the last, in days; infinite where one of both is no date in that order.
double span_of(const std::vector<std::string_view>& cells, DateOrder order) {
  const auto first = parse_date_time(cells.front(), order), last = parse_date_time(cells.back(), order);
  return first && last ? std::abs(static_cast<double>(last->days - first->days)) : HUGE_VAL;
}

}  // namespace

StampColumn read_stamp_column(const std::vector<std::string_view>& cells) {
  StampColumn column;
  column.seconds.setConstant(std::ssize(cells), NAN);
  if (cells.empty()) return column;
  const DateOrder order = span_of(cells, DateOrder::day_first) < span_of(cells, DateOrder::month_first)
                              ? DateOrder::day_first
                              : DateOrder::month_first;
  std::optional<DateTime> first, before;
  bool timed = false;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (is_missing_value(cells[k])) continue;
    auto stamp = parse_date_time(cells[k], order);
    if (!stamp) {
      column.odd = k;
      return column;
    }
    if (before && !stamp->has_date)
      stamp->days = before->days + (stamp->seconds < before->seconds - 0.5 * seconds_a_day ? 1 : 0);
    if (!first) first = stamp;
    before = stamp;
    timed = timed || stamp->has_time;
    column.seconds[static_cast<Eigen::Index>(k)] = seconds_between(*first, *stamp);
  }
  column.dates_only = !timed;
  return column;
}

}  // namespace kalfem
