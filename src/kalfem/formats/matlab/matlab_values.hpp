// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of MATLAB files only.

#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/formats/unpacked_size.hpp"

namespace kalfem {

struct MatlabField;

/// A variable or a field.
struct MatlabValue {
  enum class Kind { numbers, text, structure, cells, other };
  Kind kind = Kind::other;
  Eigen::MatrixXd real, imaginary;         ///< numbers; the imaginary part is empty where there is none
  std::vector<Eigen::Index> lengths = {};  ///< of a complex array of more than two dimensions, which stands in `real`
                                           ///< as the first x all others; otherwise empty
  std::string text;
  std::string what;                                ///< of other kinds: "a sparse matrix"
  std::vector<std::vector<MatlabField>> elements;  ///< fields of each element; of cells one nameless field each
};

/// Lengths without those of 1 as long as there are more than two: 1 x 1 x 1601 is 1 x 1601. At least two.
std::vector<Eigen::Index> matlab_lengths(const std::vector<std::size_t>& lengths);

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

/// Throws InvalidInput where the file cannot be opened as a MATLAB file. Variables that go over the budget are skipped.
MatlabContents read_matlab_values(const std::filesystem::path& path, UnpackedBudget& budget);

/// The same of a file of version 7.3, which is an HDF5 file.
MatlabContents read_matlab_hdf5(const std::filesystem::path& path, UnpackedBudget& budget);

/// What stands at the top of a file of version 5 to 7.2, without its numbers.
struct MatlabElements {
  std::size_t arrays = 0;                                         ///< sound ones in a row
  std::vector<std::uintmax_t> unpacked = {};                      ///< bytes that each of them takes in memory
  bool cut_off = false;                                           ///< the file ends behind them, within another one
  std::size_t damaged_at = 0;                                     ///< byte of the first that is not sound; 0: none
  std::uintmax_t too_large = 0;                                   ///< bytes of the structure that they end at; 0: none
  std::vector<std::pair<std::string, std::string>> objects = {};  ///< name and class of `string`, `table`, ...
};

/// Structures and cells that unpack to more than the budget leaves end the list, as their parts cannot be counted.
MatlabElements scan_matlab_elements(const std::filesystem::path& path, const UnpackedBudget& budget);

/// Whether the whole file is sound matrices of version 4.
bool is_matlab_4(const std::filesystem::path& path);

}  // namespace kalfem
