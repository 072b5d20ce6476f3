// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/frequency_response.hpp"

namespace kalfem {

/// What the columns of a table hold whose names do not say it, or that have no names.
enum class FrfColumnContent { complex, magnitude, decibel };

/// How a text table of FRFs is read; what is left out is found by looking at the file. Lines, comments and separators
/// as in CsvOptions.
struct FrfTableOptions {
  std::optional<char> separator = {};                    ///< one of  ; tab , space
  std::optional<char> decimal = {};                      ///< '.' or ','
  std::string frequency_column = {};                     ///< name; empty: the first column
  std::vector<std::string> outputs = {};                 ///< the FRFs to read, by name, in this order; empty: all
  FrfColumnContent content = FrfColumnContent::complex;  ///< of columns without an ending
};

/// Reads the FRFs of one input. Each FRF "H1" of the table stands
/// - in one column H1 of complex numbers, 1.2+3.4j or (1.2+3.4i) (a part may be missing), of magnitudes or of decibel,
///   as `content` says, or
/// - in the columns H1_re and H1_im, or
/// - in H1_magnitude (or H1_mag, H1_abs) or H1_db (decibel), with or without H1_phase [deg] (or [rad]); without it for
///   all FRFs the response holds magnitudes only,
/// and may have its standard deviation in H1_deviation (or H1_std). Case does not matter in these endings, a unit may
/// follow as channel_of() reads it, "H1_re [m/s2/N]" or "H1_mag (dB)"; values are left in it. Without a header the
/// columns are frequency, H1, H2, ... of what `content` says. Frequencies are in Hz, or as their unit says in kHz or
/// rad/s, and may be written with a zero imaginary part.
///
/// Throws InvalidInput with file, line and column for every cell that is no finite number, every line of another
/// length, frequencies that are negative or not ascending, and names that make no FRF.
FrequencyResponse read_frf_table(const std::filesystem::path& path, const FrfTableOptions& options = {});

}  // namespace kalfem
