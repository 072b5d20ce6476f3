// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/mode_file.hpp"

#include <array>
#include <complex>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/formats/matlab/matlab_modes.hpp"
#include "kalfem/formats/measured_file_reader.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Json = nlohmann::json;

constexpr std::array<const char*, 6> directions = {"X", "Y", "Z", "RX", "RY", "RZ"};
constexpr std::complex<double> not_measured = {ModeSet::unknown, ModeSet::unknown};

/// null stands for what is not a number.
double number_of(const Json& value) { return value.is_number() ? value.get<double>() : ModeSet::unknown; }

/// A member that may be absent.
double number_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? ModeSet::unknown : number_of(*found);
}

Eigen::MatrixXd matrix_of(const Json& rows, Index size) {
  Eigen::MatrixXd matrix(size, size);
  for (Index i = 0; i < size; ++i)
    for (Index j = 0; j < size; ++j)
      matrix(i, j) = number_of(rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)));
  return matrix;
}

ModeSet::Mode mode_of(const Json& given, const std::vector<std::string>& points) {
  ModeSet::Mode mode{.frequency = number_of(given.at("frequency_hz")),
                     .frequency_std = number_at(given, "frequency_std_hz"),
                     .damping = number_at(given, "damping"),
                     .damping_std = number_at(given, "damping_std")};
  mode.degrees_of_freedom = number_at(given, "degrees_of_freedom");
  const auto count = static_cast<Index>(points.size());
  mode.shape = Eigen::VectorXcd::Constant(count, not_measured);
  for (Index i = 0; i < count; ++i) {
    const auto entry = given.at("shape").find(points[static_cast<std::size_t>(i)]);
    if (entry != given.at("shape").end())
      mode.shape[i] = {number_of(entry->at("real")), number_of(entry->at("imaginary"))};
  }
  if (const auto covariance = given.find("shape_covariance"); covariance != given.end() && covariance->is_array())
    mode.shape_covariance = matrix_of(*covariance, 2 * count);
  return mode;
}

ModeSet modes_of_json(const std::filesystem::path& file) {
  try {
    const Json given = Json::parse(read_bytes(file));
    ModeSet set{.points = given.at("channels").get<std::vector<std::string>>()};
    for (const auto& mode : given.at("modes")) set.modes.push_back(mode_of(mode, set.points));
    return set;
  } catch (const Json::exception& error) {
    const std::string words = error.what();  // "[json.exception.parse_error.101] parse error at line 2, column 1: ..."
    throw InvalidInput(file.string() + " is not modes.json of `kalfem modal`", words.substr(words.find("] ") + 2),
                       "write it with kalfem modal RECORD --out FOLDER, or give a universal or MATLAB file");
  }
}

using Entry = std::pair<long, int>;  ///< node and direction, 0 to 5

/// Entries of all shapes that are not zero everywhere.
std::set<Entry> moving_entries(const std::vector<MeasuredShape>& shapes) {
  std::set<Entry> moving;
  for (const auto& shape : shapes)
    for (Index row = 0; row < shape.values.rows(); ++row)
      for (Index column = 0; column < shape.values.cols(); ++column)
        if (shape.values(row, column) != 0.0)
          moving.emplace(shape.nodes[static_cast<std::size_t>(row)], static_cast<int>(column));
  return moving;
}

ModeSet modes_of_shapes(const MeasuredFile& file, const std::string& source) {
  std::vector<MeasuredShape> shapes;
  for (const auto& shape : file.shapes)
    if (shape.frequency > 0.0) shapes.push_back(shape);
  if (shapes.empty())
    throw InvalidInput(source + " holds no modes", "datasets 55 and 2414 of normal or complex modes are read",
                       "see what it holds with `kalfem inspect`");
  ModeSet set{.points = {}, .nodes = file.nodes};
  std::map<Entry, Index> row_of;
  for (const auto& [node, direction] : moving_entries(shapes)) {
    row_of.emplace(Entry{node, direction}, std::ssize(set.points));
    set.points.push_back(std::to_string(node) + ":+" + directions[static_cast<std::size_t>(direction)]);
    set.places.push_back({.node = node, .direction = direction + 1});
  }
  for (const auto& shape : shapes) {
    ModeSet::Mode mode{.frequency = shape.frequency,
                       .damping = shape.damping > 0.0 ? shape.damping : ModeSet::unknown,
                       .shape = Eigen::VectorXcd::Constant(std::ssize(set.points), not_measured)};
    for (Index row = 0; row < shape.values.rows(); ++row)
      for (Index column = 0; column < shape.values.cols(); ++column)
        if (const auto at = row_of.find({shape.nodes[static_cast<std::size_t>(row)], static_cast<int>(column)});
            at != row_of.end())
          mode.shape[at->second] = shape.values(row, column);
    set.modes.push_back(std::move(mode));
  }
  return set;
}

}  // namespace

ModeSet read_modes(const std::filesystem::path& file) {
  ModeSet set = file.extension() == ".json"  ? modes_of_json(file)
                : file.extension() == ".mat" ? read_matlab_modes(file)
                                             : modes_of_shapes(read_measured_file(file), file.string());
  if (set.modes.empty()) throw InvalidInput(file.string() + " holds no modes", "there is nothing to compare with", "");
  return set;
}

}  // namespace kalfem
