// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of WAV files only.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// What the block `fmt ` says of the samples.
struct WavFormat {
  int kind = 0;  ///< 1: whole numbers, 3: floats, others: compressed; of the extensible kind as its sub-format says
  int channels = 0;
  double rate = 0.0;  ///< [Hz]
  int frame = 0;      ///< bytes of the samples of all channels at one time
  int bits = 0;
};

/// The blocks of a file of the kinds RIFF, RIFX, RF64 and BW64.
struct WavBlocks {
  bool big_endian = false;
  bool has_format = false, has_samples = false;
  WavFormat format;
  std::string_view samples;
  std::string title;                      ///< of the list INFO
  std::vector<std::string> notes = {};    ///< where the sizes contradict the file
  std::vector<std::string> skipped = {};  ///< further blocks of samples
};

/// Finds the blocks. A size of zero, as of a recording that was never finished, and one beyond the file's end are
/// replaced by what is there, which `notes` says.
WavBlocks find_wav_blocks(std::string_view bytes);

}  // namespace kalfem
