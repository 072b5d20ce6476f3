#include "kalfem/base/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <random>
#include <string>
#include <system_error>

#include "kalfem/base/write_failure.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

/// A name that neither another thread nor another process uses.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> count{0};
  static const unsigned process = std::random_device{}();  // the same number may run on another computer
  const std::string number = std::to_string(process) + "-" + std::to_string(count++);
  return path.parent_path() / ("." + path.filename().string() + "." + number + std::string(temporary_ending));
}

/// A file that is open for writing. Functions return the system's error code, 0 for success.
class OpenFile {
public:
  OpenFile(const fs::path& path, int flags) : descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~OpenFile() { close(); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }

  [[nodiscard]] int write(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
  }

  /// File systems that keep nothing on a disk answer EINVAL.
  [[nodiscard]] int bring_to_disk() const { return fsync(descriptor_) == 0 || errno == EINVAL ? 0 : errno; }

  int close() {
    const int closed = descriptor_ < 0 ? 0 : ::close(descriptor_);
    descriptor_ = -1;
    return closed == 0 ? 0 : errno;
  }

private:
  int descriptor_;
};

int write_new_file(const fs::path& path, std::string_view bytes) {
  OpenFile file(path, O_WRONLY | O_CREAT | O_EXCL);
  if (!file.is_open()) return errno;
  if (const int code = file.write(bytes)) return code;
  if (const int code = file.bring_to_disk()) return code;
  return file.close();
}

int write_in_place(const fs::path& path, std::string_view bytes) {
  const OpenFile file(path, O_WRONLY);
  return file.is_open() ? file.write(bytes) : errno;
}

int replace(const fs::path& path, std::string_view bytes) {
  const fs::path temporary = temporary_beside(path);
  int code = write_new_file(temporary, bytes);
  if (code == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) code = errno;
  if (code != 0) unlink(temporary.c_str());
  return code;
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) fail_to_write(path, error.value());
  const fs::file_status there = fs::status(path, error);
  if (fs::is_directory(there)) fail_to_write(path, EISDIR);
  const bool replaceable = !fs::exists(there) || fs::is_regular_file(there);
  if (const int code = replaceable ? replace(path, bytes) : write_in_place(path, bytes))
    fail_to_write(path, code, NeededSpace{bytes.size()});
}

void require_writable(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) fail_to_write(path, EISDIR);
  fs::path folder = fs::absolute(path, error).parent_path();
  while (!fs::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  if (!fs::is_directory(folder, error)) fail_to_write(path, ENOTDIR);
  const bool device = fs::exists(path, error) && !fs::is_regular_file(path, error);
  if (!device && access(folder.c_str(), W_OK) != 0) fail_to_write(path, errno);
}

void bring_to_disk(const fs::path& path) {
  std::error_code error;
  const bool folder = fs::is_directory(path, error);
  const OpenFile file(path, O_RDONLY);
  const int code = file.is_open() ? file.bring_to_disk() : errno;
  if (code == 0 || (folder && code != EIO)) return;
  const auto size = fs::file_size(path, error);
  fail_to_write(path, code, error ? std::nullopt : std::optional(NeededSpace{size}));
}

}  // namespace kalfem
