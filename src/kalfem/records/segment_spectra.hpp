// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "kalfem/records/frequency_response.hpp"

// Spectra of the segments of records, as averages of them are made of [Wel67].

namespace kalfem {

/// Throws InvalidInput where a channel is missing or not finite, sampling rates differ, no record is as long as a
/// segment, or an option is out of its range.
void check_segments(std::span<const Record> records, const std::vector<std::string>& names, const H1Options& options);

Eigen::VectorXd window_of(const H1Options& options);
Eigen::Index hop_of(const H1Options& options);  ///< from a segment to the next [samples]
Eigen::Index segments_in(const Record& record, const H1Options& options);

/// Spectra of the windowed segment from sample `first` on, its mean taken off, at the lines below half the sampling
/// rate without line 0; one column a channel.
Eigen::MatrixXcd spectra_of(const Record& record, const std::vector<std::string>& names, Eigen::Index first,
                            const Eigen::VectorXd& window);

/// n_d, the independent segments to which the overlapping ones of all records are worth, see estimate_h1().
double effective_averages(std::span<const Record> records, const Eigen::VectorXd& window, const H1Options& options);

}  // namespace kalfem
