// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/universal/fields.hpp"
#include "kalfem/formats/universal/function_header.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Widths of the columns of the samples, by precision and spacing.
std::span<const int> sample_widths(const FunctionHeader& header) {
  static constexpr std::array even = {20};
  static constexpr std::array single = {13};
  static constexpr std::array real = {13, 20};
  static constexpr std::array complex = {13, 20, 20};
  if (!header.double_precision) return single;
  if (header.even) return even;
  if (header.complex) return complex;
  return real;
}

[[noreturn]] void refuse_count(const UniversalReading& reading, const FunctionHeader& header, std::uint64_t found) {
  throw InvalidInput(Issue{
      {reading.source.place().file, header.line + 7},
      "the header declares " + std::to_string(header.points) + " points, the dataset has " + std::to_string(found),
      "samples are missing, or the header is wrong",
      "copy or export the file again, or correct the count in the header"});
}

/// Zeros that fill the last line up are no samples.
bool is_filling(std::span<const double> rest) {
  return rest.size() < 6 && std::ranges::all_of(rest, [](double value) { return value == 0.0; });
}

std::vector<double> read_text_samples(UniversalReading& reading, const FunctionHeader& header) {
  const auto per_point = static_cast<std::uint64_t>(header.numbers_per_point());
  const std::uint64_t wanted = header.points * per_point;
  const auto widths = sample_widths(header);
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(std::min(wanted, reading.source.bytes_left() / 2)));
  while (reading.source.next()) {
    if (is_universal_mark(reading.source.line())) {
      reading.source.put_back();
      break;
    }
    const std::string odd = append_numbers(reading.source.line(), widths, values);
    if (reading.source.is_cut_off() && !reading.source.line().empty())
      throw reading.source.problem("the file ends within a line of samples",
                                   "digits of the last one may be missing: the file is truncated",
                                   "copy or export it again");
    if (!odd.empty())
      throw reading.source.problem("'" + odd + "' is not a number",
                                   odd.find('*') != std::string::npos ? "it did not fit its column when it was written"
                                                                      : "every sample must be a finite number",
                                   "export the file again");
  }
  if (values.size() > wanted && is_filling(std::span(values).subspan(static_cast<std::size_t>(wanted))))
    values.resize(static_cast<std::size_t>(wanted));
  if (values.size() != wanted) refuse_count(reading, header, values.size() / per_point);
  return values;
}

template <typename Number, typename Bits>
double decoded(const char* bytes, bool swap) {
  Bits bits = 0;
  std::memcpy(&bits, bytes, sizeof bits);
  if (swap) {
    auto* const first = reinterpret_cast<unsigned char*>(&bits);
    std::reverse(first, first + sizeof bits);
  }
  return static_cast<double>(std::bit_cast<Number>(bits));
}

/// Bytes of the numbers of a point, one after the other.
struct PointLayout {
  std::vector<std::size_t> widths;
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const std::size_t width : widths) sum += width;
    return sum;
  }
};

/// The layouts that programs write. An uneven abscissa beside ordinates of double precision is of double precision too,
/// or of single precision, as its column of 13 in the ASCII form says.
std::vector<PointLayout> layouts(const FunctionHeader& header) {
  const std::size_t width = header.double_precision ? 8 : 4;
  std::vector<PointLayout> known = {{std::vector(static_cast<std::size_t>(header.numbers_per_point()), width)}};
  if (header.double_precision && !header.even) {
    known.push_back(known.front());
    known.back().widths.front() = 4;
  }
  return known;
}

[[noreturn]] void refuse_bytes(UniversalReading& reading, const FunctionHeader& header, const BinaryForm& form) {
  const std::uint64_t left = reading.source.bytes_left(), needed = header.points * layouts(header).front().bytes();
  std::string what = "the header declares " + std::to_string(header.points) + " points (" + std::to_string(needed) +
                     " bytes) and " + std::to_string(form.bytes) + " bytes, which are " +
                     std::to_string(form.bytes / layouts(header).front().bytes()) + " points";
  if (left < needed)
    what += "; the file has " + std::to_string(left) + " more bytes, which are " +
            std::to_string(left / layouts(header).front().bytes()) + " points";
  else
    what += "; no end mark follows them";
  throw InvalidInput(Issue{{reading.source.place().file, header.line + 7},
                           std::move(what),
                           "the file is truncated, or its line ends were converted as those of a text",
                           "copy it again as a binary file, or export it again"});
}

/// The layout of the count of bytes in the identifier; an end mark, or the end of the file, must follow. Where the
/// count is that of no layout, as some programs write it, the layout with an end mark behind its bytes.
PointLayout find_layout(UniversalReading& reading, const FunctionHeader& header, const BinaryForm& form) {
  const std::uint64_t left = reading.source.bytes_left();
  const auto known = layouts(header);
  for (const auto& layout : known) {
    const std::uint64_t bytes = header.points * layout.bytes();
    if (bytes != form.bytes) continue;
    if (bytes == left || reading.source.mark_follows(bytes)) return layout;
    refuse_bytes(reading, header, form);
  }
  for (const auto& layout : known)
    if (reading.source.mark_follows(header.points * layout.bytes())) return layout;
  refuse_bytes(reading, header, form);
}

std::vector<double> read_binary_samples(UniversalReading& reading, const FunctionHeader& header,
                                        const BinaryForm& form) {
  const PointLayout layout = find_layout(reading, header, form);
  const bool swap = (form.byte_order == 2) != (std::endian::native == std::endian::big);
  constexpr std::uint64_t points_at_once = 65536;
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(header.points) * layout.widths.size());
  for (std::uint64_t left = header.points; left > 0;) {
    const std::uint64_t count = std::min(left, points_at_once);
    const std::string bytes = reading.source.take(count * layout.bytes());
    for (const char* at = bytes.data(); at < bytes.data() + bytes.size();)
      for (const std::size_t width : layout.widths) {
        values.push_back(width == 4 ? decoded<float, std::uint32_t>(at, swap)
                                    : decoded<double, std::uint64_t>(at, swap));
        at += width;
      }
    left -= count;
  }
  return values;
}

/// The numbers of a function apart: abscissa and ordinate.
struct Samples {
  Eigen::VectorXd abscissa;  ///< empty: even
  Eigen::VectorXd real, imaginary;
};

Samples apart(const FunctionHeader& header, const std::vector<double>& values) {
  const Index columns = header.numbers_per_point(), points = static_cast<Index>(header.points);
  const Eigen::Map<const Eigen::MatrixXd> table(values.data(), columns, points);
  Samples samples;
  const Index ordinate = header.even ? 0 : 1;
  if (!header.even) samples.abscissa = table.row(0).transpose();
  samples.real = table.row(ordinate).transpose();
  samples.imaginary =
      header.complex ? Eigen::VectorXd(table.row(ordinate + 1).transpose()) : Eigen::VectorXd::Zero(points);
  return samples;
}

/// "12:+Z", with the name of the component before it where there is one; empty without a node or a direction.
std::string freedom_name(const FunctionPlace& place) {
  constexpr std::array names = {"X", "Y", "Z", "RX", "RY", "RZ"};
  if (place.node == 0 && place.direction == 0) return {};
  std::string name = std::to_string(place.node);
  if (place.direction != 0)
    name +=
        std::string(place.direction > 0 ? ":+" : ":-") + names[static_cast<std::size_t>(std::abs(place.direction)) - 1];
  return name;
}

MeasuredPlace place_of(const FunctionPlace& place) {
  if (place.node == 0 && place.direction == 0) return {};
  return {.node = place.node, .direction = place.direction};
}

/// A name and the other ones by which the function may be asked for: degree of freedom, component, label of the
/// ordinate, first line of text.
template <typename Measured>
void set_names(const FunctionHeader& header, bool quotient, Measured& measured) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  std::string freedom = freedom_name(header.response);
  const std::string reference = freedom_name(header.reference);
  if (quotient && !freedom.empty() && !reference.empty() && header.reference.node > 0) freedom += "/" + reference;
  const std::string& component = header.response.component;
  if (!freedom.empty() && !component.empty()) add(component + ":" + freedom);
  add(freedom);
  if (header.response.node == 0) add(component);
  const std::size_t specific = freedom.empty() ? 1 : 0;
  add(header.texts[0]);
  if (specific == 1) add(header.axes[1].label);
  if (header.response.node != 0) add(component);
  measured.name = names.empty() ? "function of line " + std::to_string(header.line) : names.front();
  if (!names.empty()) names.erase(names.begin());
  measured.other_names = names;
  for (const auto& text : header.texts)
    if (!text.empty()) measured.description += (measured.description.empty() ? "" : "; ") + text;
}

void skip(UniversalReading& reading, const FunctionHeader& header, const std::string& reason) {
  reading.file.skipped.push_back("line " + std::to_string(header.line) + ": the function '" +
                                 (header.texts[0].empty() ? freedom_name(header.response) : header.texts[0]) +
                                 "' of dataset 58 is not read: " + reason);
}

/// Factor from the abscissa's unit to the SI unit of that quantity.
double abscissa_factor(const UniversalAxis& axis, const std::string& si) {
  if (axis.unit.empty()) return 1.0;
  const std::string unit = axis.unit == "Hertz" || axis.unit == "hertz" || axis.unit == "HZ" ? "Hz" : axis.unit;
  if (si == "Hz" && (unit == "rad/s" || unit == "rpm" || unit == "RPM"))
    return unit == "rad/s" ? 0.5 / std::numbers::pi : 1.0 / 60.0;
  try {
    const Unit known = parse_unit(unit);
    return known.dimension == parse_unit(si).dimension ? known.factor : 1.0;
  } catch (const InvalidInput&) {
    return 1.0;
  }
}

bool is_time_response(const FunctionHeader& header) {
  constexpr int time = 17;
  return header.function == 1 || (header.function == 0 && header.axes[0].type == time);
}

void note_unit(UniversalReading& reading, const AxisUnit& unit, const std::string& name) {
  if (unit.contradicts && reading.contradicts.empty()) reading.contradicts = name;
}

void add_channel(UniversalReading& reading, const FunctionHeader& header, Samples samples) {
  if (header.complex && !samples.imaginary.isZero(0.0))
    return skip(reading, header, "a time response with imaginary parts has no meaning here");
  const UniversalAxis& ordinate = header.axes[1];
  const AxisUnit unit = unit_of(ordinate, header.response.direction, reading.units);
  const double seconds = abscissa_factor(header.axes[0], "s");
  MeasuredChannel channel;
  set_names(header, false, channel);
  channel.unit = unit.unit;
  channel.quantity = quantity_of(ordinate, header.response.direction, unit.unit);
  channel.place = place_of(header.response);
  channel.start = seconds * header.first;
  channel.interval = header.even ? seconds * header.step : 0.0;
  channel.times = seconds * samples.abscissa;
  if (channel.times.size() > 0) channel.start = channel.times[0];
  channel.values = unit.factor * samples.real;
  note_unit(reading, unit, channel.name);
  reading.file.channels.push_back(std::move(channel));
}

std::optional<MeasuredFunctionKind> kind_of(int function) {
  switch (function) {
    case 2:
    case 9:
    case 10:
      return MeasuredFunctionKind::auto_spectrum;
    case 3:
      return MeasuredFunctionKind::cross_spectrum;
    case 4:
    case 5:  // a transmissibility is the frequency response to a motion
      return MeasuredFunctionKind::frequency_response;
    case 6:
    case 21:
    case 26:
      return MeasuredFunctionKind::coherence;
    case 0:
    case 12:
    case 18:
    case 24:
      return MeasuredFunctionKind::other;
    default:
      return std::nullopt;
  }
}

void add_function(UniversalReading& reading, const FunctionHeader& header, MeasuredFunctionKind kind, Samples samples) {
  const bool quotient = kind == MeasuredFunctionKind::frequency_response || kind == MeasuredFunctionKind::coherence ||
                        kind == MeasuredFunctionKind::cross_spectrum;
  AxisUnit unit = unit_of_quotient(header.axes[1], header.response.direction, header.axes[2],
                                   header.reference.direction, reading.units);
  if (kind == MeasuredFunctionKind::coherence) unit = {};
  MeasuredFunction function{.kind = kind};
  set_names(header, quotient, function);
  function.unit = unit.unit;
  function.response = place_of(header.response);
  function.reference = place_of(header.reference);
  const double hertz = abscissa_factor(header.axes[0], "Hz");
  function.lines = header.even ? Eigen::VectorXd(Eigen::VectorXd::LinSpaced(static_cast<Index>(header.points), 0.0,
                                                                            static_cast<double>(header.points) - 1.0)
                                                         .array() *
                                                     header.step +
                                                 header.first)
                               : samples.abscissa;
  function.lines *= hertz;
  function.values.resize(samples.real.size());
  function.values.real() = unit.factor * samples.real;
  function.values.imag() = unit.factor * samples.imaginary;
  note_unit(reading, unit, function.name);
  reading.file.functions.push_back(std::move(function));
}

void add(UniversalReading& reading, const FunctionHeader& header, Samples samples) {
  if (header.points == 0) return skip(reading, header, "it has no points");
  if (header.even && header.points > 1 && header.step == 0.0 && !is_time_response(header))
    return skip(reading, header, "the step of its frequencies is 0");
  if (is_time_response(header)) return add_channel(reading, header, std::move(samples));
  const auto kind = kind_of(header.function);
  const int abscissa = header.axes[0].type;
  if (!kind) return skip(reading, header, "functions of type " + std::to_string(header.function) + " are not used");
  if (!(abscissa == 18 || abscissa == 0 || abscissa == 1))
    return skip(reading, header, "its abscissa is no frequency (data type " + std::to_string(abscissa) + ")");
  add_function(reading, header, *kind, std::move(samples));
}

}  // namespace

bool is_binary(const std::string& identifier) {
  const auto words = words_of(identifier);
  return !words.empty() && words.front().find_first_of("bB") != std::string_view::npos;
}

void read_function(UniversalReading& reading) {
  const FunctionHeader header = read_function_header(reading);
  if (!is_binary(reading.identifier)) return add(reading, header, apart(header, read_text_samples(reading, header)));
  const BinaryForm form = binary_form(reading.identifier);
  if (form.byte_order < 0 || form.byte_order > 2 || form.floating_point > 3)
    throw InvalidInput(Issue{{reading.source.place().file, reading.begin},
                             "the order of the bytes is " + std::to_string(form.byte_order) +
                                 " and the form of the numbers " + std::to_string(form.floating_point),
                             "1 (little endian) or 2 (big endian), and 1 to 3 are known",
                             "export the file again"});
  for (long line = 11; line < std::min(form.text_lines, 100L); ++line) reading.line("a further line of text");
  if (form.floating_point == 2) return add(reading, header, apart(header, read_binary_samples(reading, header, form)));
  if (form.bytes > reading.source.bytes_left()) refuse_bytes(reading, header, form);
  reading.source.take(form.bytes);
  skip(reading, header, "its numbers are in the form of DEC or IBM machines, not in that of IEEE 754");
}

}  // namespace kalfem
