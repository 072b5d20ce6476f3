// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices.hpp"

namespace kalfem {

/// The same matrix in each of the formats.
inline const Eigen::Matrix3d common_matrix{{4.5, -1.0, 0.0}, {-1.0, 3.0, -0.25}, {0.0, -0.25, 2.0}};

/// What is said about a file of matrices that cannot be read; "" where it can.
inline std::string refusal(const std::string& bytes, const std::string& source,
                           MatrixFormat format = MatrixFormat::automatic) {
  try {
    parse_matrices(bytes, source, {.format = format});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

inline Eigen::MatrixXd dense(const ForeignMatrix& matrix) { return Eigen::MatrixXd(matrix.matrix); }

inline std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// Reads every beginning of the bytes, and the bytes with one of them changed: each must be read or refused, never
/// more.
inline void expect_no_crash(const std::string& bytes, const std::string& source) {
  const std::size_t step = 1 + bytes.size() / 400;
  for (std::size_t size = 0; size < bytes.size(); size += step) refusal(bytes.substr(0, size), source);
  std::string changed = bytes;
  for (std::size_t i = 0; i < bytes.size(); i += step)
    for (const char value : {'\0', '\x7f', '\xff', '9', '-', ' '}) {
      changed[i] = value;
      refusal(changed, source);
      changed[i] = bytes[i];
    }
}

}  // namespace kalfem
