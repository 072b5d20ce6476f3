#pragma once

// What text and binary OUTPUT4 files have in common; inside of their readers only.

#include <string>

#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem {

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

}  // namespace kalfem
