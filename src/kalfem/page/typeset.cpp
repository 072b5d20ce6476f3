// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/typeset.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

namespace kalfem {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
/// What a name or a symbol of a unit may hold; bytes of UTF-8 beyond ASCII belong to letters.
bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || (c & 0x80) != 0; }

std::string raised(std::string_view exponent) {
  static constexpr std::array<std::string_view, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : exponent) text += c == '-' ? "⁻" : c == '+' ? "" : digits[static_cast<std::size_t>(c - '0')];
  return text;
}

/// Digits of "8.89" with the decimal point `power` places further right.
std::string shifted(std::string_view mantissa, int power) {
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  std::string digits(mantissa.substr(0, point));
  if (point < mantissa.size()) digits += mantissa.substr(point + 1);
  int at = static_cast<int>(point) + power;
  if (at <= 0) digits.insert(0, static_cast<std::size_t>(1 - at), '0'), at = 1;
  if (static_cast<std::size_t>(at) >= digits.size())
    return digits.append(static_cast<std::size_t>(at) - digits.size(), '0');
  return digits.insert(static_cast<std::size_t>(at), 1, '.');
}

/// Reads a text from left to right; each taker returns whether it wrote what stands at `at_`.
class Typesetter {
public:
  explicit Typesetter(std::string_view text) : text_(text) {}

  std::string typeset() {
    while (at_ < text_.size())
      if (!(take_typed() || take_power_of_unit() || take_number() || take_plus_minus())) result_ += text_[at_++];
    return std::move(result_);
  }

private:
  [[nodiscard]] char before() const { return at_ > 0 ? text_[at_ - 1] : ' '; }
  [[nodiscard]] char at(std::size_t place) const { return place < text_.size() ? text_[place] : ' '; }
  [[nodiscard]] std::size_t end_of_digits(std::size_t from) const {
    while (is_digit(at(from))) ++from;
    return from;
  }

  bool take_typed() {
    if (at(at_) != '`') return false;
    const std::size_t end = text_.find('`', at_ + 1);
    if (end == std::string_view::npos) return false;
    result_ += text_.substr(at_, end + 1 - at_);
    at_ = end + 1;
    return true;
  }

  bool take_power_of_unit() {
    if (at(at_) != '^' || !(is_word(before()) || before() == ')')) return false;
    const std::size_t first = at_ + 1 + (at(at_ + 1) == '-' ? 1 : 0), end = end_of_digits(first);
    if (end == first || at(end) == '.') return false;
    result_ += raised(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end;
    return true;
  }

  /// Only numbers with an exponent that stand alone: neither inside a name nor inside a hash.
  bool take_number() {
    if (!is_digit(at(at_)) || is_word(before()) || before() == '.') return false;
    std::size_t end = end_of_digits(at_);
    if (at(end) == '.') end = end_of_digits(end + 1);
    const auto mantissa = text_.substr(at_, end - at_);
    const std::size_t sign = end + 1, digits = sign + (at(sign) == '-' || at(sign) == '+' ? 1 : 0);
    const std::size_t after = end_of_digits(digits);
    if (at(end) != 'e' || after == digits || after - digits > 3 || is_word(at(after)))
      return result_ += mantissa, at_ = end, true;
    int power = 0;
    std::from_chars(text_.data() + digits, text_.data() + after, power);
    if (at(sign) == '-') power = -power;
    constexpr int least = -4, most = 6;
    result_ += power >= least && power <= most ? shifted(mantissa, power)
                                               : std::string(mantissa) + "×10" + raised(std::to_string(power));
    at_ = after;
    return true;
  }

  bool take_plus_minus() {
    if (!text_.substr(at_).starts_with("+- ")) return false;
    result_ += "±";
    at_ += 2;
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::string result_;
};

}  // namespace

std::string typeset(std::string_view text) { return Typesetter(text).typeset(); }

}  // namespace kalfem
