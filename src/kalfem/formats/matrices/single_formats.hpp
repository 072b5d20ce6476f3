// SPDX-License-Identifier: Apache-2.0
#pragma once

// The readers of the single formats; inside of matrices.cpp only. Each gives all matrices of a file in its order and
// throws InvalidInput where it cannot.

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/formats/matrices.hpp"
#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem {

std::vector<ForeignMatrix> parse_matrix_market(std::string_view text, const std::string& source);
std::vector<ForeignMatrix> parse_triplets(std::string_view text, const std::string& source);
std::vector<ForeignMatrix> parse_nodal(std::string_view text, const std::string& source);
std::vector<ForeignMatrix> parse_user_element(std::string_view text, const std::string& source);
std::vector<ForeignMatrix> parse_dmig(std::string_view text, const std::string& source);
std::vector<ForeignMatrix> parse_op4_text(std::string_view text, const std::string& source);
std::vector<ForeignMatrix> parse_op4_binary(std::string_view bytes, const std::string& source);
std::vector<ForeignMatrix> parse_op2(std::string_view bytes, const std::string& source);
std::vector<ForeignMatrix> parse_hdf5(std::string_view bytes, const std::string& source);
std::vector<ForeignMatrix> parse_netcdf(std::string_view bytes, const std::string& source);
std::vector<ForeignMatrix> parse_matlab(std::string_view bytes, const std::string& source);

/// The first parameter of a keyword line, in lower case without blanks, that is not among `known`.
std::optional<std::string> unknown_parameter(std::string_view line, std::initializer_list<std::string_view> known);

/// Name for the matrix of a file that holds one without a name: that of the file without its folder and ends.
std::string name_from(const std::string& source);

/// Whether binary bytes begin as the format does.
bool looks_like_op4_binary(std::string_view bytes);
bool looks_like_op2(std::string_view bytes);
bool looks_like_hdf5(std::string_view bytes);
bool looks_like_op4_text(std::string_view text);

/// Rows of a map "number, direction 1 ... 6 (0: generalised)"; generalised coordinates without a number are counted.
/// Throws where a direction is none or a degree of freedom stands twice.
std::vector<MatrixDof> dofs_of_map(const Eigen::Ref<const Eigen::MatrixXd>& map, const std::string& source);

/// Whether an array of two columns under this name says what the rows of the matrices beside it are.
inline bool is_map_name(const std::string& name) {
  const std::string lower = lower_case(name.substr(name.find_last_of('/') + 1));
  return lower == "cbmap" || lower == "dof_map" || lower == "dofmap" || lower == "map" || lower == "dofs" ||
         lower == "dof";
}

// What text and binary OUTPUT4 files have in common; inside of their readers only.

/// The first record of a matrix in an OUTPUT4 file.
struct Op4Header {
  std::int64_t columns = 0, rows = 0;  ///< rows are negative where strings have long headers ("bigmat")
  std::int64_t form = 0;               ///< 1 square, 2 rectangular, 3 diagonal, 6 symmetric, 8 identity
  std::int64_t type = 0;               ///< 1 single, 2 double precision, 3 and 4 complex
  std::string name;
};

/// Throws where the matrix is complex or of a form that is not known.
void check_op4(const Op4Header& header, const std::string& source, int line);

/// Room for the entries of the matrix.
MatrixEntries op4_entries(const Op4Header& header, const std::string& source, std::size_t bytes, int line);

/// The finished matrix; a diagonal one, that is stored as a column, on its diagonal.
ForeignMatrix op4_matrix(const Op4Header& header, const MatrixEntries& entries);

/// First row (from 0) and number of words of a string of non-zeros, from its short header of one number.
struct Op4String {
  std::int64_t row = 0, words = 0;
};
inline Op4String op4_short_string(std::int64_t header) { return {(header & 0xffff) - 1, (header >> 16) - 1}; }

// The writers of the single formats; inside of write.cpp only. Each gives the bytes of the whole file.

std::string matrix_market_text(const ForeignMatrix& matrix);
std::string dmig_text(const std::vector<ForeignMatrix>& matrices);
std::string op4_text(const std::vector<ForeignMatrix>& matrices);
std::string op4_bytes(const std::vector<ForeignMatrix>& matrices, bool big_endian);
std::string hdf5_bytes(const std::vector<ForeignMatrix>& matrices, const Eigen::MatrixXd& basis,
                       const std::vector<std::string>& names);

/// Whether A and A^T are equal to the last bit.
bool is_symmetric(const SparseMatrix& matrix);

}  // namespace kalfem
