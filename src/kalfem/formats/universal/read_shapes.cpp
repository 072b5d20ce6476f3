// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/universal/dataset_readers.hpp"
#include "kalfem/formats/universal/fields.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr std::array narrow_columns = {13};
constexpr std::size_t integer_columns = 10;

/// What datasets 55 and 2414 say before their numbers.
struct ShapeHeader {
  std::array<std::string, 5> texts;
  std::string name;
  long analysis = 0;        ///< 1 static, 2 normal mode, 3 and 7 complex eigenvalue
  long characteristic = 0;  ///< 2 translations, 3 translations and rotations
  long type = 0;            ///< specific data type
  bool complex = false;
  long values = 0;  ///< a node
  long mode = 0;
  double frequency = 0.0, damping = 0.0;
};

std::vector<long> integers(UniversalReading& reading, const std::string& wanted, std::size_t least) {
  const std::string line = reading.line(wanted);
  auto values = integers_of(line, integer_columns);
  if (!values)
    throw reading.source.problem(wanted + ": '" + line.substr(0, 40) + "' holds no whole numbers",
                                 "the format asks for columns of 10", "export the file again");
  if (values->size() < least) values->resize(least, 0);
  return *values;
}

/// At least so many numbers, over as many lines as they take.
std::vector<double> numbers(UniversalReading& reading, const std::string& wanted, std::size_t least) {
  std::vector<double> values;
  do {
    const std::string odd = append_numbers(reading.line(wanted), narrow_columns, values);
    if (!odd.empty()) throw reading.source.problem(wanted + ": '" + odd + "' is not a number");
  } while (values.size() < least);
  return values;
}

/// Frequency and damping ratio of an eigenvalue s = -zeta omega + i omega sqrt(1 - zeta^2) [rad/s].
void set_eigenvalue(ShapeHeader& header, double real, double imaginary) {
  const double omega = std::hypot(real, imaginary);
  header.frequency = omega / (2.0 * std::numbers::pi);
  header.damping = omega > 0.0 ? -real / omega : 0.0;
}

// Real numbers of record 8: of a normal mode frequency, modal mass, viscous and hysteretic damping ratio; of a complex
// mode the eigenvalue first.
ShapeHeader read_header_55(UniversalReading& reading) {
  ShapeHeader header;
  for (auto& text : header.texts) text = to_utf8(columns(reading.line("the five lines of text"), 0, 80));
  const auto kind = integers(reading, "the data definition", 6);
  header.analysis = kind[1];
  header.characteristic = kind[2];
  header.type = kind[3];
  header.complex = kind[4] == 5 || kind[4] == 6;
  header.values = kind[5];
  const auto whole = integers(reading, "the whole numbers of the analysis", 4);
  header.mode = whole[3];
  const auto real =
      numbers(reading, "the real numbers of the analysis", static_cast<std::size_t>(std::clamp(whole[1], 1L, 12L)));
  if (header.analysis == 2) {
    header.frequency = real[0];
    if (real.size() > 2) header.damping = real[2];
    if (real.size() > 3 && header.damping == 0.0) header.damping = 0.5 * real[3];
  } else if ((header.analysis == 3 || header.analysis == 7) && real.size() > 1) {
    set_eigenvalue(header, real[0], real[1]);
  }
  return header;
}

ShapeHeader read_header_2414(UniversalReading& reading, long& location) {
  ShapeHeader header;
  reading.line("the label of the dataset");
  header.name = to_utf8(columns(reading.line("the name of the dataset"), 0, 80));
  location = integers(reading, "the location of the data", 1)[0];
  for (auto& text : header.texts) text = to_utf8(columns(reading.line("the five lines of text"), 0, 80));
  const auto kind = integers(reading, "the data definition", 6);
  header.analysis = kind[1];
  header.characteristic = kind[2];
  header.type = kind[3];
  header.complex = kind[4] == 5 || kind[4] == 6;
  header.values = kind[5];
  header.mode = integers(reading, "the whole numbers of the analysis", 8)[5];
  integers(reading, "the whole numbers of the analysis", 0);
  const auto real = numbers(reading, "the real numbers of the analysis", 6);
  const auto second = numbers(reading, "the real numbers of the analysis", 6);
  header.frequency = real[1];
  header.damping = real[4] != 0.0 ? real[4] : 0.5 * real[5];
  if ((header.analysis == 3 || header.analysis == 7) && (second[0] != 0.0 || second[1] != 0.0))
    set_eigenvalue(header, second[0], second[1]);
  return header;
}

std::string name_of(const ShapeHeader& header) {
  if (!header.name.empty() && header.name != "NONE") return header.name;
  for (const auto& text : header.texts)
    if (!text.empty() && text != "NONE") return text;
  return header.analysis == 1 ? "static shape" : "mode " + std::to_string(header.mode);
}

/// Why the shape is not read; empty where it is.
std::string reason_to_skip(const ShapeHeader& header, long location) {
  constexpr std::array read = {0L, 1L, 2L, 3L, 7L};
  if (location != 1) return "its data are not at nodes (location " + std::to_string(location) + ")";
  if (std::ranges::find(read, header.analysis) == read.end())
    return "it is neither a static shape nor a mode (analysis type " + std::to_string(header.analysis) + ")";
  if (header.values != 3 && header.values != 6)
    return "it has " + std::to_string(header.values) + " values a node; 3 and 6 are read";
  if (header.characteristic != 0 && header.characteristic != 2 && header.characteristic != 3)
    return "its values are no translations and rotations (data characteristic " +
           std::to_string(header.characteristic) + ")";
  if (header.type > 1 && header.type != 8 && header.type != 11 && header.type != 12)
    return "its values are no motions (specific data type " + std::to_string(header.type) + ")";
  return {};
}

void read_values(UniversalReading& reading, const ShapeHeader& header, const std::string& dataset) {
  MeasuredShape shape{.name = name_of(header), .frequency = header.frequency, .damping = header.damping};
  const auto count = static_cast<std::size_t>(header.values) * (header.complex ? 2 : 1);
  std::vector<double> values;
  while (const std::string* line = reading.next_line()) {
    if (words_of(*line).empty()) continue;
    const auto node = integers_of(*line, integer_columns);
    if (!node || node->empty())
      throw reading.source.problem("dataset " + dataset + ": '" + line->substr(0, 40) +
                                   "' is not the number of a node");
    const std::string wanted = "the values at node " + std::to_string(node->front());
    const auto row = numbers(reading, wanted, count);
    if (row.size() != count)
      throw reading.source.problem(wanted + ": there are " + std::to_string(row.size()) + " numbers",
                                   "the header declares " + std::to_string(count), "export the file again");
    shape.nodes.push_back(node->front());
    values.insert(values.end(), row.begin(), row.end());
  }
  const Index rows = static_cast<Index>(shape.nodes.size()), columns = header.values;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using RowMajorComplex = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (header.complex)
    shape.values =
        Eigen::Map<const RowMajorComplex>(reinterpret_cast<const std::complex<double>*>(values.data()), rows, columns);
  else
    shape.values = Eigen::Map<const RowMajor>(values.data(), rows, columns).cast<std::complex<double>>();
  shape.values.leftCols(3) /= reading.units.length;
  reading.file.shapes.push_back(std::move(shape));
}

void read_shape(UniversalReading& reading, const ShapeHeader& header, long location, const std::string& dataset) {
  const std::string reason = reason_to_skip(header, location);
  if (reason.empty()) return read_values(reading, header, dataset);
  reading.file.skipped.push_back("line " + std::to_string(reading.begin) + ": dataset " + dataset + " '" +
                                 name_of(header) + "' is not read: " + reason);
  while (reading.next_line() != nullptr) continue;
}

}  // namespace

void read_data_at_nodes(UniversalReading& reading) { read_shape(reading, read_header_55(reading), 1, "55"); }

void read_analysis_data(UniversalReading& reading) {
  long location = 0;
  const ShapeHeader header = read_header_2414(reading, location);
  read_shape(reading, header, location, "2414");
}

}  // namespace kalfem
