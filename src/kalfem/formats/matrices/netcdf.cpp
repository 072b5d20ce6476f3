// SPDX-License-Identifier: Apache-2.0
// netCDF classic files (CDF-1, 64-bit offset CDF-2 and 64-bit data CDF-5) [NC3]: a header with the names of dimensions
// and variables, then the values, big-endian. Square and rectangular variables of numbers are the matrices; a
// superelement has beside them a map of its rows ("cbmap" of Sierra SD: node, direction 1 ... 6; 0, 0 for a
// fixed-interface mode).

#include <map>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"

namespace kalfem {
namespace {

struct Variable {
  std::string name;
  std::vector<std::size_t> dimensions;
  std::int32_t type = 0;
  std::size_t begin = 0;
  bool is_packed = false;  ///< its values mean scale_factor * value + add_offset
};

/// Bytes of a value: byte, char, short, int, float, double, and the unsigned and 64-bit types of CDF-5.
std::size_t width_of(std::int32_t type) {
  switch (type) {
    case 1:
    case 2:
    case 7:
      return 1;
    case 3:
    case 8:
      return 2;
    case 4:
    case 5:
    case 9:
      return 4;
    case 6:
    case 10:
    case 11:
      return 8;
    default:
      return 0;
  }
}

// Reads the header in the order of the format: magic and version, number of records, then the lists of dimensions,
// global attributes and variables. A list has a tag and a length, an empty one is two zeros. Names and attributes are
// padded to 4 bytes. Versions differ in widths only: CDF-2 has 8 bytes for the start of a variable, CDF-5 for counts
// too.
class NetcdfReader {
public:
  NetcdfReader(std::string_view bytes, const std::string& source) : file_(bytes, source, true) {
    file_.go_to(3);
    version_ = file_.read<std::int8_t>();
    if (version_ != 1 && version_ != 2 && version_ != 5)
      file_.refuse("the netCDF version " + std::to_string(version_) + " is not known", "it must be 1, 2 or 5");
    records_ = count();
    read_dimensions();
    pass_over_attributes();
    read_variables();
  }

  std::vector<ForeignMatrix> matrices() {
    std::vector<MatrixDof> map;
    std::string map_name;
    for (const auto& variable : variables_)
      if (is_map(variable)) {
        map = dofs_of_map(values(variable), file_.file());
        map_name = variable.name;
      }
    std::vector<ForeignMatrix> found;
    std::string others;
    const auto pass_over = [&](const std::string& name) { others += (others.empty() ? "" : ", ") + name; };
    bool map_fits = false;
    for (const auto& variable : variables_) {
      if (is_map(variable)) {
        if (variable.name != map_name) pass_over(variable.name);
        continue;
      }
      if (variable.dimensions.size() != 2 || variable.type == 2 || length(variable, 0) == 0 ||
          length(variable, 1) == 0) {
        pass_over(variable.name);
        continue;
      }
      if (variable.is_packed)
        file_.refuse("variable '" + variable.name + "' is packed (scale_factor, add_offset)",
                     "its numbers are not those of the matrix", "export it unpacked");
      found.push_back({variable.name, checked(variable).sparseView(), {}, false});
      if (static_cast<std::size_t>(found.back().matrix.rows()) != map.size()) continue;
      found.back().dofs = map;
      map_fits = true;
    }
    if (!map_name.empty() && !map_fits) pass_over(map_name);
    if (found.empty()) file_.refuse("the file has no matrix", "a variable of two dimensions is required");
    if (!others.empty()) found.front().notes.push_back("variables that are no matrices and are not used: " + others);
    return found;
  }

private:
  /// A count, of 4 bytes or 8 in CDF-5.
  std::size_t count() {
    const std::int64_t value = version_ == 5 ? file_.read<std::int64_t>() : file_.read<std::int32_t>();
    return value < 0 ? 0 : static_cast<std::size_t>(value);  // -1: the number of records is not known
  }

  /// Length of a list behind its tag; each of its elements takes some bytes.
  std::size_t list_length() {
    file_.read<std::int32_t>();
    const std::size_t length = count();
    if (length > file_.remaining()) file_.refuse("a list of " + std::to_string(length) + " names is announced");
    return length;
  }

  void pad(std::size_t bytes) { file_.take((4 - bytes % 4) % 4); }

  std::string name() {
    const std::size_t length = count();
    std::string text(file_.take(length));
    pad(length);
    return text;
  }

  void read_dimensions() {
    for (std::size_t i = list_length(); i-- > 0;) {
      name();
      lengths_.push_back(count());
    }
  }

  /// Whether one of the attributes scales the values.
  bool pass_over_attributes() {
    bool scales = false;
    for (std::size_t i = list_length(); i-- > 0;) {
      const std::string own = name();
      scales = scales || own == "scale_factor" || own == "add_offset";
      const std::size_t width = width_of(file_.read<std::int32_t>());
      const std::size_t number = count();
      if (width > 0 && number > file_.remaining() / width) file_.refuse("an attribute is longer than the file");
      file_.take(number * width);
      pad(number * width);
    }
    return scales;
  }

  void read_variables() {
    for (std::size_t i = list_length(); i-- > 0;) {
      Variable variable;
      variable.name = name();
      const std::size_t rank = count();
      for (std::size_t d = 0; d < rank; ++d) {
        variable.dimensions.push_back(count());
        if (variable.dimensions.back() >= lengths_.size())
          file_.refuse("a variable has a dimension that does not exist");
      }
      variable.is_packed = pass_over_attributes();
      variable.type = file_.read<std::int32_t>();
      count();
      const std::int64_t begin = version_ == 1 ? file_.read<std::int32_t>() : file_.read<std::int64_t>();
      if (begin < 0) file_.refuse("variable '" + variable.name + "' has a negative start");
      variable.begin = static_cast<std::size_t>(begin);
      variables_.push_back(std::move(variable));
    }
  }

  [[nodiscard]] bool is_map(const Variable& variable) const {
    return is_map_name(variable.name) && variable.dimensions.size() == 2 && length(variable, 1) == 2;
  }

  /// Length along one dimension; 0 where there is no such dimension, or it grows with the records.
  [[nodiscard]] std::size_t length(const Variable& variable, std::size_t dimension) const {
    return dimension < variable.dimensions.size() ? lengths_[variable.dimensions[dimension]] : 0;
  }

  // A variable of fixed size is one block in row-major order from its start. Its size is checked against the rest of
  // the file before memory is taken.
  Eigen::MatrixXd values(const Variable& variable) {
    const std::size_t rows = length(variable, 0), columns = length(variable, 1), width = width_of(variable.type);
    file_.go_to(variable.begin);
    if (width == 0) file_.refuse("variable '" + variable.name + "' has an unknown type");
    if (rows > 0 && columns > file_.remaining() / width / rows)
      file_.refuse("variable '" + variable.name + "' is longer than the file");
    Eigen::MatrixXd matrix(rows, columns);
    for (Eigen::Index row = 0; row < matrix.rows(); ++row)
      for (Eigen::Index column = 0; column < matrix.cols(); ++column) matrix(row, column) = value(variable.type);
    return matrix;
  }

  Eigen::MatrixXd checked(const Variable& variable) {
    Eigen::MatrixXd matrix = values(variable);
    if (!matrix.allFinite())
      file_.refuse("matrix '" + variable.name + "' has an entry that is not finite",
                   "every entry must be a finite number", "check why the other code wrote it");
    return matrix;
  }

  double value(std::int32_t type) {
    switch (type) {
      case 1:
        return file_.read<std::int8_t>();
      case 3:
        return file_.read<std::int16_t>();
      case 4:
        return file_.read<std::int32_t>();
      case 5:
        return static_cast<double>(file_.read<float>());
      case 6:
        return file_.read<double>();
      case 7:
        return file_.read<std::uint8_t>();
      case 8:
        return file_.read<std::uint16_t>();
      case 9:
        return file_.read<std::uint32_t>();
      case 10:
        return static_cast<double>(file_.read<std::int64_t>());
      default:
        return static_cast<double>(file_.read<std::uint64_t>());
    }
  }

  ByteReader file_;
  int version_ = 1;
  std::size_t records_ = 0;
  std::vector<std::size_t> lengths_;
  std::vector<Variable> variables_;
};

}  // namespace

std::vector<ForeignMatrix> parse_netcdf(std::string_view bytes, const std::string& source) {
  return NetcdfReader(bytes, source).matrices();
}

}  // namespace kalfem
