// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/universal/fields.hpp"
#include "kalfem/formats/universal/function_header.hpp"
#include "kalfem/formats/universal/universal_text.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr int real_width = 13, double_width = 20;

/// What records 1 to 11 and the samples say.
struct FunctionText {
  int function = 1;
  std::string name;
  std::string description = {};
  MeasuredPlace response = {}, reference = {};
  UniversalAxis abscissa = {}, numerator = {}, denominator = {};
  double first = 0.0, step = 0.0;
  Eigen::VectorXd uneven = {};  ///< abscissa; empty: even
  Eigen::VectorXd real, imaginary = {};
};

/// A number in 13 columns, so that it reads back as the same where that is possible: with five decimals, or with as
/// many digits as fit.
std::string exact_column(double value, double (*read)(std::string_view, double)) {
  const std::string usual = real_column(value, real_width, 5);
  const auto back = [&](const std::string& text) {
    const auto number = universal_number(text);
    return number ? read(text, *number) : 0.0;
  };
  if (back(usual) == value) return usual;
  const std::string digits = shortest(value);
  if (digits.size() <= real_width && digits.find_first_of(".e") != std::string::npos)
    return std::string(real_width - digits.size(), ' ') + digits;
  return real_column(value, real_width, value < 0.0 ? 6 : 7);
}

double as_read(std::string_view /*text*/, double number) { return number; }
double step_as_read(std::string_view text, double number) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  return meant_step(text, number);
}

/// Whether the abscissa of the header reads back as it is.
bool is_exact(const FunctionText& text) {
  const std::string first = exact_column(text.first, as_read), step = exact_column(text.step, step_as_read);
  return universal_number(first) == text.first && step_as_read(step, *universal_number(step)) == text.step;
}

void refuse(const std::string& name, const std::string& what, const std::string& why) {
  throw InvalidInput("'" + name + "' " + what, why, "");
}

void check(const FunctionText& text) {
  if (text.uneven.size() > 0 && text.uneven.size() != text.real.size())
    refuse(text.name,
           "has " + std::to_string(text.real.size()) + " values at " + std::to_string(text.uneven.size()) + " places",
           "every value needs its time or frequency");
  const bool infinite = text.real.array().isInf().any() || text.imaginary.array().isInf().any();
  if (infinite || !text.uneven.allFinite() || !std::isfinite(text.first) || !std::isfinite(text.step) ||
      text.step < 0.0)
    refuse(text.name, "has an infinite value, or a step of its abscissa that is negative",
           "the format holds numbers only");
  for (const auto* axis : {&text.numerator, &text.denominator})
    if (axis->unit.size() > 20)
      refuse(text.name, "has the unit '" + axis->unit + "'", "a label has at most 20 characters");
}

std::string place_column(const MeasuredPlace& place, const std::string& component) {
  return " " + text_column(component, 10) + integer_column(place.node.value_or(0), 10) +
         integer_column(place.direction, 4);
}

std::string axis_record(const UniversalAxis& axis) {
  return integer_column(axis.type, 10) + "    0    0    0 " + text_column(axis.label, 20) + " " +
         text_column(axis.unit, 20) + "\n";
}

/// The name of the component in "wing:12:+Z".
std::string component_of(const std::string& name, const MeasuredPlace& place) {
  if (!place.node) return {};
  const std::size_t freedom = name.find(std::to_string(*place.node) + ":");
  return freedom == std::string::npos || freedom < 2 || name[freedom - 1] != ':' ? "" : name.substr(0, freedom - 1);
}

/// The five lines of text: the name first where no node names the function, then the parts of the description.
std::string text_records(const FunctionText& text) {
  std::vector<std::string> lines;
  for (std::string_view rest = text.description; !rest.empty();) {
    const std::size_t end = std::min(rest.find("; "), rest.size());
    lines.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 2, rest.size()));
  }
  if (lines.empty() || (!text.response.node && lines.front() != text.name)) lines.insert(lines.begin(), text.name);
  lines.resize(5);
  std::string records;
  for (const auto& line : lines) records += text_column(line, 80) + "\n";
  return records;
}

std::string records(const FunctionText& text) {
  const bool even = text.uneven.size() == 0;
  const std::string places =
      integer_column(text.function, 5) + integer_column(0, 10) + integer_column(1, 5) + integer_column(0, 10) +
      place_column(text.response, component_of(text.name, text.response)) + place_column(text.reference, "") + "\n";
  const std::string abscissa = integer_column(text.imaginary.size() > 0 ? 6 : 4, 10) +
                               integer_column(text.real.size(), 10) + integer_column(even ? 1 : 0, 10) +
                               (even ? exact_column(text.first, as_read) : real_column(0.0, real_width, 5)) +
                               (even ? exact_column(text.step, step_as_read) : real_column(0.0, real_width, 5)) +
                               real_column(0.0, real_width, 5) + "\n";
  return text_records(text) + places + abscissa + axis_record(text.abscissa) + axis_record(text.numerator) +
         axis_record(text.denominator) + axis_record({});
}

std::string text_samples(const FunctionText& text) {
  const bool even = text.uneven.size() == 0, complex = text.imaginary.size() > 0;
  const Index per_line = even ? (complex ? 2 : 4) : (complex ? 1 : 2);
  std::string samples;
  for (Index k = 0; k < text.real.size(); ++k) {
    if (!even) samples += real_column(text.uneven[k], real_width, 5);
    samples += real_column(text.real[k], double_width, 12);
    if (complex) samples += real_column(text.imaginary[k], double_width, 12);
    if ((k + 1) % per_line == 0 || k + 1 == text.real.size()) samples += "\n";
  }
  return samples;
}

void append_bytes(std::string& bytes, double value) {
  const auto bits = std::bit_cast<std::array<char, sizeof(double)>>(value);
  bytes.append(bits.data(), bits.size());
}

std::string binary_samples(const FunctionText& text) {
  std::string bytes;
  for (Index k = 0; k < text.real.size(); ++k) {
    if (text.uneven.size() > 0) append_bytes(bytes, text.uneven[k]);
    append_bytes(bytes, text.real[k]);
    if (text.imaginary.size() > 0) append_bytes(bytes, text.imaginary[k]);
  }
  return bytes;
}

std::string dataset_of(const FunctionText& text, bool binary) {
  check(text);
  if (!binary) return dataset(58, records(text) + text_samples(text));
  const std::string bytes = binary_samples(text);
  const int order = std::endian::native == std::endian::little ? 1 : 2;
  const std::string identifier = "    58b" + integer_column(order, 6) + integer_column(2, 6) + integer_column(11, 12) +
                                 integer_column(static_cast<long>(bytes.size()), 12) + integer_column(0, 6) +
                                 integer_column(0, 6) + integer_column(0, 12) + integer_column(0, 12) + "\n";
  return "    -1\n" + identifier + records(text) + bytes + "    -1\n";
}

/// An even abscissa that the header cannot hold exactly becomes an uneven one, as bytes keep all digits.
void keep_digits(FunctionText& text, const Eigen::VectorXd& abscissa, bool binary) {
  if (!text.uneven.size() && binary && !is_exact(text)) text.uneven = abscissa;
}

/// "(m/s^2)/(N)" apart; the denominator is empty of any other unit.
std::pair<std::string, std::string> quotient(const std::string& unit) {
  const std::size_t middle = unit.find(")/(");
  if (middle == std::string::npos || !unit.starts_with('(') || !unit.ends_with(')')) return {unit, ""};
  return {unit.substr(1, middle - 1), unit.substr(middle + 3, unit.size() - middle - 4)};
}

UniversalAxis axis_of(const std::string& quantity, const std::string& unit) {
  if (unit.empty()) return {};
  const int type = data_type_of(quantity, unit);
  return {.type = type == 0 ? 1 : type, .label = quantity, .unit = unit};
}

int function_type(MeasuredFunctionKind kind) {
  switch (kind) {
    case MeasuredFunctionKind::frequency_response:
      return 4;
    case MeasuredFunctionKind::coherence:
      return 6;
    case MeasuredFunctionKind::auto_spectrum:
      return 2;
    case MeasuredFunctionKind::cross_spectrum:
      return 3;
    case MeasuredFunctionKind::other:
      break;
  }
  return 12;
}

Eigen::VectorXd even_abscissa(double first, double step, Index count) {
  Eigen::VectorXd abscissa(count);
  for (Index k = 0; k < count; ++k) abscissa[k] = static_cast<double>(k) * step + first;
  return abscissa;
}

}  // namespace

std::string function_dataset(const MeasuredChannel& channel, bool binary) {
  FunctionText text{.name = channel.name,
                    .description = channel.description,
                    .response = channel.place,
                    .abscissa = {.type = 17, .label = "Time", .unit = "s"},
                    .numerator = axis_of(channel.quantity, channel.unit),
                    .first = channel.start,
                    .step = channel.interval,
                    .uneven = channel.times,
                    .real = channel.values};
  check(text);
  keep_digits(text, even_abscissa(text.first, text.step, text.real.size()), binary);
  return dataset_of(text, binary);
}

std::string function_dataset(const MeasuredFunction& function, bool binary) {
  const auto [above, below] = quotient(function.unit);
  FunctionText text{.function = function_type(function.kind),
                    .name = function.name,
                    .description = function.description,
                    .response = function.response,
                    .reference = function.reference,
                    .abscissa = {.type = 18, .label = "Frequency", .unit = "Hz"},
                    .numerator = axis_of("", above),
                    .denominator = axis_of("", below),
                    .uneven = function.lines,
                    .real = function.values.real()};
  if (!function.values.imag().isZero(0.0)) text.imaginary = function.values.imag();
  check(text);
  const Index count = function.lines.size();
  if (count > 1) {
    const double step = (function.lines[count - 1] - function.lines[0]) / static_cast<double>(count - 1);
    FunctionText even = text;
    even.first = function.lines[0];
    even.step = step;
    const Eigen::VectorXd lines = even_abscissa(even.first, step, count);
    const double rounding = 1e-9 * function.lines.cwiseAbs().maxCoeff();
    const bool same = binary ? lines == function.lines && is_exact(even)
                             : step > 0.0 && (lines - function.lines).cwiseAbs().maxCoeff() <= rounding;
    if (same) {
      even.uneven.resize(0);
      return dataset_of(even, binary);
    }
  }
  return dataset_of(text, binary);
}

}  // namespace kalfem
