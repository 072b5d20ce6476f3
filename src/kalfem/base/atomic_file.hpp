#pragma once

#include <filesystem>
#include <string_view>

namespace kalfem {

/// Replaces the file so that a reader sees the old bytes or all of the new ones, never a part: writes a temporary file
/// in the same folder (made if it is missing) and renames it. Removes the temporary file on failure. Throws
/// InvalidInput when the folder or the file cannot be written.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace kalfem
