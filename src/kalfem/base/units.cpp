// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/units.hpp"

#include <charconv>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

constexpr std::size_t longest_text = 200;  // also bounds the depth of parentheses
constexpr int parts_per_power = 12;
constexpr double largest_power = 12.0;
constexpr double pi = std::numbers::pi;

struct NamedUnit {
  std::string_view symbol;
  bool takes_prefix;
  double factor;
  std::array<int, 6> powers;  ///< of m, kg, s, K, A, rad
};

// International yard and pound (1959): in = 25.4 mm, lb = 0.45359237 kg; standard gravity (CGPM 1901): 9.80665 m/s^2.
constexpr double inch = 0.0254, pound = 0.45359237, gravity = 9.80665;

constexpr NamedUnit named_units[] = {
    {"m", true, 1.0, {1}},
    {"g", true, 1e-3, {0, 1}},
    {"s", true, 1.0, {0, 0, 1}},
    {"K", true, 1.0, {0, 0, 0, 1}},
    {"A", true, 1.0, {0, 0, 0, 0, 1}},
    {"rad", true, 1.0, {0, 0, 0, 0, 0, 1}},
    {"Hz", true, 1.0, {0, 0, -1}},
    {"N", true, 1.0, {1, 1, -2}},
    {"Pa", true, 1.0, {-1, 1, -2}},
    {"J", true, 1.0, {2, 1, -2}},
    {"W", true, 1.0, {2, 1, -3}},
    {"V", true, 1.0, {2, 1, -3, 0, -1}},
    {"%", false, 1e-2, {}},
    {"ppm", false, 1e-6, {}},
    {"strain", true, 1.0, {}},
    {"ε", true, 1.0, {}},
    {"microstrain", false, 1e-6, {}},
    {"uE", false, 1e-6, {}},
    {"µE", false, 1e-6, {}},
    {"μE", false, 1e-6, {}},
    {"-", false, 1.0, {}},
    {"deg", false, pi / 180.0, {0, 0, 0, 0, 0, 1}},
    {"°", false, pi / 180.0, {0, 0, 0, 0, 0, 1}},
    {"rpm", false, pi / 30.0, {0, 0, -1, 0, 0, 1}},
    {"min", false, 60.0, {0, 0, 1}},
    {"h", false, 3600.0, {0, 0, 1}},
    {"t", false, 1e3, {0, 1}},
    {"bar", false, 1e5, {-1, 1, -2}},
    {"g0", false, gravity, {1, 0, -2}},
    {"gn", false, gravity, {1, 0, -2}},
    {"in", false, inch, {1}},
    {"ft", false, 12.0 * inch, {1}},
    {"lb", false, pound, {0, 1}},
    {"lbf", false, pound* gravity, {1, 1, -2}},
    {"psi", false, pound* gravity / (inch * inch), {-1, 1, -2}},
};

struct Prefix {
  std::string_view symbol;
  double factor;
};
constexpr Prefix prefixes[] = {{"p", 1e-12}, {"n", 1e-9}, {"µ", 1e-6}, {"μ", 1e-6}, {"u", 1e-6},
                               {"m", 1e-3},  {"c", 1e-2}, {"d", 1e-1}, {"h", 1e2},  {"k", 1e3},
                               {"M", 1e6},   {"G", 1e9},  {"T", 1e12}};

constexpr std::string_view superscripts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_space(char c) { return c == ' ' || c == '\t'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

Unit to_unit(const NamedUnit& named, double prefix = 1.0) {
  Unit unit{prefix * named.factor, {}};
  for (std::size_t i = 0; i < named.powers.size(); ++i) unit.dimension.twelfths[i] = parts_per_power * named.powers[i];
  return unit;
}

// Looks for the whole symbol first and for prefix and symbol after that, so a unit never loses to a prefixed one.
std::optional<Unit> find_unit(std::string_view symbol) {
  for (const auto& unit : named_units)
    if (unit.symbol == symbol) return to_unit(unit);
  for (const auto& prefix : prefixes) {
    if (!symbol.starts_with(prefix.symbol)) continue;
    for (const auto& unit : named_units)
      if (unit.takes_prefix && unit.symbol == symbol.substr(prefix.symbol.size())) return to_unit(unit, prefix.factor);
  }
  return std::nullopt;
}

/// What accelerometers are read in: g, milli-g and the like. A kilo-g is more likely a kilogram.
std::optional<Unit> find_gravity(std::string_view symbol) {
  constexpr std::string_view smaller[] = {"m", "µ", "μ", "u", "n"};
  if (symbol == "g" || symbol == "G") return find_unit("g0");
  for (const auto& prefix : prefixes)
    for (const auto usual : smaller)
      if (prefix.symbol == usual && symbol.starts_with(usual) && symbol.substr(usual.size()) == "g")
        return Unit{prefix.factor * gravity, find_unit("g0")->dimension};
  return std::nullopt;
}

Unit operator*(const Unit& a, const Unit& b) {
  Unit product{a.factor * b.factor, a.dimension};
  for (std::size_t i = 0; i < b.dimension.twelfths.size(); ++i)
    product.dimension.twelfths[i] += b.dimension.twelfths[i];
  return product;
}

/// Recursive descent:  product = [slash] factor { (slash | star | space) factor };  factor = atom [power];
/// atom = symbol | "1" | "(" product ")" | "sqrt(" product ")".
class UnitParser {
public:
  /// What the letter g stands for.
  enum class Gram { mass, gravity };
  explicit UnitParser(std::string_view text, Gram gram = Gram::mass) : text_(text), rest_(trim(text)), gram_(gram) {}

  Unit parse() {
    if (text_.size() > longest_text) fail("the text is too long");
    if (rest_.empty()) return {};
    const Unit unit = product();
    if (!rest_.empty()) fail("'" + std::string(rest_) + "' is not a unit");
    if (!std::isfinite(unit.factor) || unit.factor == 0.0) fail("its factor is out of range");
    return unit;
  }

private:
  [[noreturn]] void fail(const std::string& why) const {
    throw InvalidInput("unit '" + std::string(text_.substr(0, longest_text)) + "'", why,
                       "write units like m/s^2, kN/m, N s/m, %, deg");
  }

  void skip_spaces() { rest_ = trim(rest_); }

  bool take(std::string_view token) {
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }

  // Combines factors from left to right. A slash divides by the next factor alone; a product after it, as in N/m s,
  // is read differently by different people and is refused.
  Unit product() {
    Unit result = factor();
    bool divided = false;
    for (skip_spaces(); !rest_.empty() && rest_.front() != ')'; skip_spaces()) {
      if (take("/")) {
        result = result * power(factor(), -parts_per_power);
        divided = true;
      } else {
        if (divided) fail("a product after a slash is ambiguous; write N/(m s) or N s/m");
        if (!take("*")) take("·");
        result = result * factor();
      }
    }
    return result;
  }

  Unit factor() {
    skip_spaces();
    const Unit base = atom();
    return power(base, exponent());
  }

  Unit atom() {
    if (take("sqrt(")) return power(closed(), parts_per_power / 2);
    if (take("(")) return closed();
    if (take("1")) return {};
    return symbol();
  }

  Unit closed() {
    const Unit inside = product();
    if (!take(")")) fail("a ')' is missing");
    return inside;
  }

  // Stops before a superscript or a middle dot, whose bytes lie above 0x7F like those of the degree and micro signs.
  // In gravity mode g, mg and the like are accelerations; any other symbol is looked up as usual.
  /// The longest run of letters and signs that names a unit; g0 has a digit in it.
  Unit symbol() {
    std::size_t length = 0;
    const auto belongs = [](char c) { return is_letter(c) || c == '%' || static_cast<unsigned char>(c) >= 0x80; };
    while (length < rest_.size() && belongs(rest_[length]) && !starts_sign(rest_.substr(length))) ++length;
    if (rest_.starts_with("g0")) length = 2;
    if (rest_ == "-") length = 1;
    const auto gravity_unit = gram_ == Gram::gravity ? find_gravity(rest_.substr(0, length)) : std::nullopt;
    const auto unit = gravity_unit ? gravity_unit : find_unit(rest_.substr(0, length));
    if (!unit) fail(length == 0 ? "a unit is missing" : "'" + std::string(rest_.substr(0, length)) + "' is not known");
    rest_.remove_prefix(length);
    return *unit;
  }

  static bool starts_sign(std::string_view text) {
    for (const auto sign : superscripts)
      if (text.starts_with(sign)) return true;
    return text.starts_with("·") || text.starts_with("⁻");
  }

  /// The power that follows, in twelfths.
  int exponent() {
    if (take("^(") || take("**(")) return bracketed_exponent();
    if (take("^") || take("**")) return twelfths(number());
    if (!rest_.empty() && is_digit(rest_.front())) return twelfths(number());
    return superscript_exponent();
  }

  int bracketed_exponent() {
    skip_spaces();
    double value = number();
    skip_spaces();
    if (take("/")) {
      skip_spaces();
      value /= number();
    }
    skip_spaces();
    if (!take(")")) fail("a ')' is missing");
    return twelfths(value);
  }

  int superscript_exponent() {
    const bool negative = take("⁻");
    int value = 0, digits = 0;
    for (bool found = true; found && digits < 3;) {
      found = false;
      for (int digit = 0; digit < 10 && !found; ++digit) {
        found = take(superscripts[digit]);
        if (found) value = 10 * value + digit;
      }
      digits += found;
    }
    if (digits == 0) {
      if (negative) fail("a power is missing");
      return parts_per_power;
    }
    return twelfths(negative ? -value : value);
  }

  double number() {
    double value = 0.0;
    const auto [end, error] =
        std::from_chars(rest_.data(), rest_.data() + rest_.size(), value, std::chars_format::fixed);
    if (error != std::errc{}) fail("a power is missing");
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  // Powers are stored in twelfths, so that halves, thirds and quarters stay exact: m/s^2/sqrt(Hz) has a dimension
  // that can be compared without a tolerance.
  int twelfths(double exponent) const {
    const double parts = parts_per_power * exponent;
    if (!(std::abs(exponent) <= largest_power) || std::abs(parts - std::round(parts)) > 1e-9)
      fail("a power must be a multiple of 1/12 between -12 and 12");
    return static_cast<int>(std::lround(parts));
  }

  Unit power(Unit unit, int parts) const {
    if (parts == parts_per_power) return unit;
    unit.factor = std::pow(unit.factor, static_cast<double>(parts) / parts_per_power);
    for (int& part : unit.dimension.twelfths) {
      if (std::abs(part) > 100000 || part * parts % parts_per_power != 0) fail("its powers are out of range");
      part = part * parts / parts_per_power;
    }
    return unit;
  }

  std::string_view text_, rest_;
  Gram gram_;
};

/// The unit with g as gravity, where that makes it one of the wanted dimension.
std::optional<Unit> unit_with_gravity(std::string_view text, const Dimension& wanted) {
  try {
    const Unit unit = UnitParser(text, UnitParser::Gram::gravity).parse();
    return compatible(unit.dimension, wanted) ? std::optional(unit) : std::nullopt;
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

std::string shown(std::string_view text) { return "'" + std::string(text.substr(0, longest_text)) + "'"; }

/// A number, and the text of the unit behind it.
struct NumberAndUnit {
  double number = 0.0;
  std::string_view unit;
};

// std::from_chars knows no leading plus and no locale: the plus is skipped by hand, and a decimal comma gets a message
// of its own.
NumberAndUnit split_quantity(std::string_view text) {
  std::string_view digits = trim(text);
  if (digits.starts_with('+') && digits.size() > 1 && digits[1] != '-') digits.remove_prefix(1);
  double number = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error == std::errc::result_out_of_range)
    throw InvalidInput(shown(text), "the number is too large or too small", "");
  if (error != std::errc{})
    throw InvalidInput(shown(text) + " is not a number", "", "write a number with an optional unit, like 3 mm");
  if (!std::isfinite(number)) throw InvalidInput(shown(text) + " is not a finite number", "", "");
  const std::string_view unit = trim(digits.substr(static_cast<std::size_t>(end - digits.data())));
  if (unit.starts_with(','))
    throw InvalidInput(shown(text) + " is not a number", "", "write the decimals with a point");
  return {number, unit};
}

/// In SI. Throws InvalidInput where that is too large a number.
double scaled(double number, const Unit& unit, std::string_view text) {
  const double value = number * unit.factor;
  if (!std::isfinite(value)) throw InvalidInput(shown(text), "the number is too large", "");
  return value;
}

[[noreturn]] void fail_dimension(const std::string& given, std::string_view expected) {
  const Dimension wanted = parse_unit(expected).dimension;
  const std::string required = wanted == Dimension{} ? "a number without a unit" : std::string(expected);
  std::string fix = "give it in " + (wanted == Dimension{} ? "no unit or %" : required) + ", or as a bare number in SI";
  throw InvalidInput(given + " given where " + required + " is required", "", fix);
}

}  // namespace

bool operator==(const Quantity& a, const Quantity& b) {
  return a.value == b.value && a.dimension == b.dimension && a.bare == b.bare && a.per_cent == b.per_cent;
}

Unit parse_unit(std::string_view text) { return UnitParser(text).parse(); }

// The letter g is the gram in SI and standard gravity on data sheets of accelerometers. It is read as gravity only
// where that, and so not the gram, gives the expected dimension.
Unit parse_unit_as(std::string_view text, std::string_view expected_unit) {
  const Dimension wanted = parse_unit(expected_unit).dimension;
  if (const auto with_gravity = unit_with_gravity(text, wanted)) return *with_gravity;
  const Unit unit = parse_unit(text);
  if (!compatible(unit.dimension, wanted)) fail_dimension(std::string(trim(text)), expected_unit);
  return unit;
}

// The number marked as bare where no unit follows, which stands for SI.
Quantity parse_quantity(std::string_view text) {
  const auto [number, unit_text] = split_quantity(text);
  if (unit_text.empty()) return {number, {}, true};
  const Unit unit = parse_unit(unit_text);
  return {scaled(number, unit, text), unit.dimension, false, unit_text == "%"};
}

// The radian is a ratio, so angles compare with pure numbers. Rates are the exception: 1 Hz is 2 pi rad/s, and an
// exchange of both would be a factor of 2 pi.
bool compatible(const Dimension& a, const Dimension& b) {
  const auto without_angle = [](Dimension dimension) {
    dimension.twelfths.back() = 0;
    return dimension;
  };
  const Dimension rate{{0, 0, -parts_per_power, 0, 0, 0}};
  return without_angle(a) == without_angle(b) && (a == b || without_angle(a) != rate);
}

double to_si(std::string_view text, std::string_view expected_unit) {
  const Quantity quantity = parse_quantity(text);
  const Dimension wanted = parse_unit(expected_unit).dimension;
  if (quantity.bare || compatible(quantity.dimension, wanted)) return quantity.value;
  const auto [number, unit_text] = split_quantity(text);
  if (const auto with_gravity = unit_with_gravity(unit_text, wanted)) return scaled(number, *with_gravity, text);
  fail_dimension(std::string(trim(text)), expected_unit);
}

double to_si(const Quantity& quantity, std::string_view expected_unit) {
  if (!quantity.bare && !compatible(quantity.dimension, parse_unit(expected_unit).dimension))
    fail_dimension(shortest(quantity.value) + " " + si_unit(quantity.dimension), expected_unit);
  return quantity.value;
}

std::string si_unit(const Dimension& dimension) {
  for (const char* usual : {"N", "N/m", "N s/m", "N m", "Pa", "m/s", "m/s^2", "V"})
    if (parse_unit(usual).dimension == dimension) return usual;
  constexpr std::string_view symbols[] = {"m", "kg", "s", "K", "A", "rad"};
  std::string text;
  for (std::size_t i = 0; i < dimension.twelfths.size(); ++i) {
    const int parts = dimension.twelfths[i];
    if (parts == 0) continue;
    text += (text.empty() ? "" : " ") + std::string(symbols[i]);
    const int divisor = std::gcd(parts, parts_per_power);
    const int numerator = parts / divisor, denominator = parts_per_power / divisor;
    if (denominator != 1) text += "^(" + std::to_string(numerator) + "/" + std::to_string(denominator) + ")";
    if (denominator == 1 && numerator != 1) text += "^" + std::to_string(numerator);
  }
  return text.empty() ? "-" : text;
}

std::string shortest(double value) {
  std::array<char, 32> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end};
}

}  // namespace kalfem
