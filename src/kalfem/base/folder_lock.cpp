#include "kalfem/base/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <string>
#include <utility>

#include "kalfem/base/write_failure.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

/// Another process may remove the file between its opening and its locking; then the attempt is repeated.
constexpr int most_attempts = 1000;

std::string this_process() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return std::to_string(getpid()) + " on " + host.data();
}

[[noreturn]] void refuse(const fs::path& folder, const fs::path& lock) {
  std::string holder;
  std::ifstream stream(lock);
  std::getline(stream, holder);
  throw InvalidInput(
      "another run writes into '" + folder.string() + "'" + (holder.empty() ? "" : " (process " + holder + ")"),
      "the results of two runs would be mixed", "wait until it has ended, or give another folder with --out");
}

/// Whether the open file is still the one of that name.
bool is_in_place(int descriptor, const fs::path& file) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const int code = error.value();
  if (code == ENOSPC || code == EDQUOT || code == EIO) fail_to_write(folder, code);
  if (error || !fs::is_directory(folder, error))
    throw InvalidInput("the folder '" + folder.string() + "' cannot be made",
                       error ? error.message() : "a file of that name stands there", "give another one with --out");
}

bool has_no_locks(int code) { return code == ENOLCK || code == ENOSYS || code == EOPNOTSUPP; }

/// The descriptor of the locked file, -1 where the attempt is to be repeated.
int attempt(const fs::path& folder, const fs::path& lock) {
  make_folder(folder);
  if (mkdir(lock.parent_path().c_str(), 0777) != 0 && errno != EEXIST) {
    if (errno == ENOENT) return -1;
    fail_to_write(folder, errno);
  }
  const int descriptor = open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0 && errno == ENOENT) return -1;
  if (descriptor < 0) fail_to_write(lock, errno);
  const int code = flock(descriptor, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
  if ((code == 0 || has_no_locks(code)) && is_in_place(descriptor, lock)) return descriptor;
  close(descriptor);
  if (code == EWOULDBLOCK) refuse(folder, lock);
  if (code != 0 && !has_no_locks(code)) fail_to_write(lock, code);
  return -1;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : hidden_(folder / ".kalfem") {
  const fs::path lock = hidden_ / "lock";
  for (int i = 0; i < most_attempts && descriptor_ < 0; ++i) descriptor_ = attempt(folder, lock);
  if (descriptor_ < 0) refuse(folder, lock);
  const std::string holder = this_process() + "\n";
  const bool named = ftruncate(descriptor_, 0) == 0 &&
                     write(descriptor_, holder.data(), holder.size()) == static_cast<ssize_t>(holder.size());
  if (named) return;
  const int code = errno;
  unlink(lock.c_str());
  close(std::exchange(descriptor_, -1));
  rmdir(hidden_.c_str());
  fail_to_write(lock, code);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : hidden_(std::move(other.hidden_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  unlink((hidden_ / "lock").c_str());  // while it is locked, so that nobody has locked it anew
  close(descriptor_);
  rmdir(hidden_.c_str());
}

}  // namespace kalfem
