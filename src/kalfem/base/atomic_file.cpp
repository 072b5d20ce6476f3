// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/atomic_file.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <random>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace kalfem {
namespace {

namespace fs = std::filesystem;

std::string size_text(std::uintmax_t bytes) {
  constexpr std::array units{"bytes", "kB", "MB", "GB", "TB"};
  auto size = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; size >= 1000.0 && unit + 1 < units.size(); ++unit) size /= 1000.0;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), unit == 0 ? "%.0f %s" : "%.1f %s", size, units[unit]);
  return text.data();
}

std::string needs(const std::optional<NeededSpace>& needed) {
  if (!needed || needed->bytes == 0) return "";
  return std::string(needed->at_least ? "it needs more than " : "it needs ") + size_text(needed->bytes) + ", ";
}

/// Free bytes of the file system that `path` lies or would lie on, where it tells.
std::optional<std::uintmax_t> available(const fs::path& path) {
  std::error_code error;
  for (fs::path folder = fs::absolute(path, error); !folder.empty(); folder = folder.parent_path()) {
    const fs::space_info space = fs::space(folder, error);
    if (!error) return space.available;
    if (folder == folder.parent_path()) break;
  }
  return std::nullopt;
}

/// A disk may be full of files, with bytes left.
std::string full_disk(const fs::path& path, const std::optional<NeededSpace>& needed) {
  const auto left = available(path);
  if (!left) return "the disk is full";
  constexpr std::uintmax_t of_a_folder = 100'000;
  if (*left > (needed ? needed->bytes : 0) + of_a_folder && !(needed && needed->at_least))
    return "the disk cannot hold more files, although " + size_text(*left) + " are available";
  return "the disk is full: " + needs(needed) + size_text(*left) + " are available";
}

std::string size_limit() {
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "that of the file system" : size_text(limit.rlim_cur) + " (ulimit -f)";
}

}  // namespace

void fail_to_write(const fs::path& path, int code, std::optional<NeededSpace> needed) {
  const std::string what = "cannot write '" + path.string() + "'";
  switch (code) {
    case ENOSPC:
      throw WriteFailure(what, full_disk(path, needed), "free some space or write to another disk");
    case EDQUOT:
      throw WriteFailure(what, "the disk quota is used up" + (needed ? ": " + needs(needed) + "more than is left" : ""),
                         "free some space or write to another disk");
    case EFBIG:
      throw WriteFailure(what, "the file would be too large: " + needs(needed) + "the limit is " + size_limit(),
                         "raise the limit or write to another disk");
    case EIO:
      throw WriteFailure(what, "the device reports an error", "check the disk or write to another one");
    case EISDIR:
      throw InvalidInput(what, "a folder of that name is in the way", "rename the folder or choose another place");
    case ENOTDIR:
      throw InvalidInput(what, "a part of its path is a file, not a folder", "choose another place");
    default:
      throw InvalidInput(what, std::generic_category().message(code), "choose another place or change the permissions");
  }
}

namespace {

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

// The bytes go to a new file beside the old one, and to the disk, before a rename puts it in its place: a reader, or a
// run that is killed, sees the old file or the new one and nothing between. Devices and pipes cannot be replaced and
// are written in place.
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
