// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Whether a file that begins with these bytes is a WAV file, of the large kinds (RF64, BW64, W64) too.
bool begins_wav(std::string_view head);

/// Reads a WAV file: whole numbers of 8 to 32 bit, floats, compressed ones as far as libsndfile knows them. Channels
/// are channel_1, channel_2, ..., without unit: the full scale of whole numbers is 1, floats are as they are stored.
/// `notes` says where the file is shorter than it states, and where it states no samples because the recording was
/// never finished: what is there is taken. Throws InvalidInput where it is no WAV file or damaged.
MeasuredFile read_wav(const std::filesystem::path& path);

}  // namespace kalfem
