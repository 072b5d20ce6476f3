// Inside of the reader of MATLAB files only.

#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace kalfem {

struct MatlabField;

/// A variable or a field.
struct MatlabValue {
  enum class Kind { numbers, text, structure, cells, other };
  Kind kind = Kind::other;
  Eigen::MatrixXd real, imaginary;  ///< numbers; the imaginary part is empty where there is none
  std::string text;
  std::string what;                                ///< of other kinds: "a sparse matrix"
  std::vector<std::vector<MatlabField>> elements;  ///< fields of each element; of cells one nameless field each
};

/// A value with its name.
struct MatlabField {
  std::string name;
  MatlabValue value;
};

using MatlabFields = std::vector<MatlabField>;

/// The variables in their order, and what could not be read of the file.
struct MatlabContents {
  MatlabFields variables = {};
  std::vector<std::string> skipped = {};
};

/// Throws InvalidInput where the file cannot be opened as a MATLAB file.
MatlabContents read_matlab_values(const std::filesystem::path& path);

/// The same of a file of version 7.3, which is an HDF5 file.
MatlabContents read_matlab_hdf5(const std::filesystem::path& path);

/// What stands at the top of a file of version 5 to 7.2, without its numbers.
struct MatlabElements {
  std::size_t arrays = 0;                                         ///< sound ones in a row
  bool cut_off = false;                                           ///< the file ends behind them, within another one
  std::size_t damaged_at = 0;                                     ///< byte of the first that is not sound; 0: none
  std::vector<std::pair<std::string, std::string>> objects = {};  ///< name and class of `string`, `table`, ...
};

MatlabElements scan_matlab_elements(const std::filesystem::path& path);

/// Whether the whole file is sound matrices of version 4.
bool is_matlab_4(const std::filesystem::path& path);

}  // namespace kalfem
