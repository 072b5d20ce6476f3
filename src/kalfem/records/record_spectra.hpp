// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Discrete Fourier transforms X_k = sum_n x_n exp(-i 2 pi k n / N) of a whole record, without a window. The last
/// samples, less than a tenth, may be left out so that N has factors 2, 3 and 5 alone.
struct RecordSpectra {
  double sample_rate = 1.0;  ///< [Hz]
  Eigen::Index samples = 0;  ///< N
  Eigen::VectorXd lines;     ///< k sample_rate / N below half the sampling rate, without line 0 [Hz]
  Eigen::VectorXcd input;    ///< U, one a line
  Eigen::MatrixXcd outputs;  ///< Y, lines x outputs
  /// How far the outputs are from rest at the two ends: sqrt(2) times the root of the sum of the mean squares of the
  /// first and of the last fiftieth of the samples, about the mean of all, noise included [unit of the output].
  Eigen::VectorXd edges;
  std::vector<Channel> channels;  ///< of the outputs
};

/// Throws InvalidInput where a channel is missing, holds values that are not finite, or has fewer than 128 samples.
RecordSpectra record_spectra(const Record& record, const std::string& input, const std::vector<std::string>& outputs);

/// Adds an issue for each name that the record has no channel of, and for each channel with a value that is not finite.
void check_spectral_channels(const Record& record, const std::vector<std::string>& names, IssueList& issues);

}  // namespace kalfem
