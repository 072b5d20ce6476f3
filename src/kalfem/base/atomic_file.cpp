#include "kalfem/base/atomic_file.hpp"

#include <atomic>
#include <fstream>
#include <random>
#include <string>
#include <system_error>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

/// A name that neither another thread nor another process uses.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> count{0};
  static const unsigned process = std::random_device{}();
  fs::path temporary = path;
  temporary += "." + std::to_string(process) + "-" + std::to_string(count++) + ".tmp";
  return temporary;
}

[[noreturn]] void fail(const fs::path& path, const std::string& why) {
  throw InvalidInput("cannot write '" + path.string() + "'", why, "choose another place or mend the permissions");
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) fail(path, error.message());

  const fs::path temporary = temporary_beside(path);
  std::ofstream file(temporary, std::ios::binary);
  if (!file) fail(path, "the folder is not writable");
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) error = std::make_error_code(std::errc::no_space_on_device);
  if (!error) fs::rename(temporary, path, error);
  if (!error) return;
  const std::string why = error.message();
  fs::remove(temporary, error);
  fail(path, why);
}

}  // namespace kalfem
