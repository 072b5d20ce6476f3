#pragma once

// The readers of the single formats; inside of matrices.cpp only. Each gives all matrices of a file in its order and
// throws InvalidInput where it cannot.

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

}  // namespace kalfem
