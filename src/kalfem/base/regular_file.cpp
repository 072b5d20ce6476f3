// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, std::string why, std::string fix) {
  throw InvalidInput(Issue{{path.string(), 0}, "the file cannot be read", std::move(why), std::move(fix)});
}

[[noreturn]] void refuse_code(const fs::path& path, int code) {
  if (code == ENOENT || code == ENOTDIR) refuse(path, "there is no such file", "check the path");
  refuse(path, std::generic_category().message(code), code == EACCES ? "change its permissions" : "check the path");
}

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

void require_regular(const fs::path& path, const struct stat& about) {
  if (S_ISREG(about.st_mode)) return;
  refuse(path, std::string("it is ") + kind_of(about.st_mode) + ", not a regular file",
         S_ISDIR(about.st_mode) ? "name a file in it" : "write its content to a file, and name that file");
}

}  // namespace

// Opening a device can already do something, so its kind is looked at before; and once more behind, as the name may
// stand for something else by then. O_NONBLOCK keeps the opening of a pipe from waiting and means nothing for files.
RegularFile::RegularFile(const fs::path& path) {
  struct stat about {};
  if (path.native().find('\0') != std::string::npos) refuse_code(path, ENOENT);
  if (stat(path.c_str(), &about) != 0) refuse_code(path, errno);
  require_regular(path, about);
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor_ < 0) refuse_code(path, errno);
  const int failed = fstat(descriptor_, &about) != 0 ? errno : 0;
  if (failed != 0 || !S_ISREG(about.st_mode)) {
    close(descriptor_);
    failed != 0 ? refuse_code(path, failed) : require_regular(path, about);
  }
  size_ = static_cast<std::uintmax_t>(about.st_size);
}

RegularFile::~RegularFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void require_regular_file(const fs::path& path) { const RegularFile file(path); }

std::string read_bytes(const fs::path& path, std::uintmax_t most) {
  const RegularFile file(path);
  std::string bytes(static_cast<std::size_t>(std::min(file.size(), most)), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = read(file.descriptor(), bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse_code(path, errno);
    if (count == 0) break;  // it was shortened meanwhile
    done += static_cast<std::size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

std::string bytes_if_readable(const fs::path& path) try { return read_bytes(path); } catch (const InvalidInput&) {
  return {};
}

}  // namespace kalfem
