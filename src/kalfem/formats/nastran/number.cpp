#include "kalfem/formats/nastran/number.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace kalfem::nastran {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The number as std::from_chars reads it: no leading '+', 'e' before each exponent. Empty where it is none.
std::string_view normalised(std::string_view field, std::array<char, 64>& buffer) {
  std::size_t size = 0;
  bool in_exponent = false, has_digit = false;
  for (std::size_t i = 0; i < field.size(); ++i) {
    char c = field[i];
    const bool sign = c == '+' || c == '-';
    if (c == 'D' || c == 'd' || c == 'E') c = 'e';
    if (size + 2 > buffer.size() || !(is_digit(c) || sign || c == 'e' || c == '.')) return {};
    if (is_digit(c)) has_digit = true;
    if (c == 'e') {
      if (in_exponent || !has_digit) return {};
      in_exponent = true;
    } else if (sign && i > 0 && (size == 0 || buffer[size - 1] != 'e')) {
      if (in_exponent || !has_digit) return {};
      in_exponent = true;
      buffer[size++] = 'e';
    }
    if (c == '+' && i == 0) continue;
    buffer[size++] = c;
  }
  return has_digit ? std::string_view(buffer.data(), size) : std::string_view{};
}

}  // namespace

std::optional<std::int64_t> parse_integer(std::string_view field) {
  if (field.starts_with('+')) {
    field.remove_prefix(1);
    if (field.starts_with('-')) return std::nullopt;
  }
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return value;
}

std::optional<double> parse_real(std::string_view field) {
  std::array<char, 64> buffer;
  const auto text = normalised(field, buffer);
  if (text.empty()) return std::nullopt;
  // from_chars knows "e+3" and "e-3"; a sign after the 'e' stays as it is.
  const char* begin = text.data();
  const char* const last = begin + text.size();
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, last, value);
  if (end != last) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    const auto exponent = text.find('e');
    const bool tiny = exponent != std::string_view::npos && text.substr(exponent).starts_with("e-");
    return tiny ? std::optional(0.0) : std::nullopt;
  }
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace kalfem::nastran
