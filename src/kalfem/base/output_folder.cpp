// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/output_folder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/regular_file.hpp"

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
  std::string holder = bytes_if_readable(lock);
  holder.resize(std::min(holder.find('\n'), holder.size()));
  throw InvalidInput(
      "another run is writing into '" + folder.string() + "'" + (holder.empty() ? "" : " (process " + holder + ")"),
      "two runs would mix their results", "wait until it has ended, or choose another folder with --out");
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
    throw InvalidInput("the folder '" + folder.string() + "' cannot be created",
                       error ? error.message() : "a file of that name is in the way", "choose another one with --out");
}

bool has_no_locks(int code) { return code == ENOLCK || code == ENOSYS || code == EOPNOTSUPP; }

// The lock is an flock on a file in the folder, which the system releases when the process ends, however it ends. Its
// holder removes the file: whoever opened it before that holds a lock on a file that is gone, sees this by the inode,
// and tries again.
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

namespace {

using Names = std::vector<std::string>;

/// Regular files and links below a folder by their relative names, sorted; none where there is no such folder.
Names files_below(const fs::path& folder) {
  Names names;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (!fs::is_directory(it->symlink_status(error))) names.push_back(it->path().lexically_relative(folder).string());
  std::ranges::sort(names);
  return names;
}

Names folders_below(const fs::path& folder) {
  Names names{""};
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (fs::is_directory(it->symlink_status(error))) names.push_back(it->path().lexically_relative(folder).string());
  std::ranges::sort(names);
  return names;
}

/// From the place of a file to the same file by way of `.kalfem/current`.
fs::path link_target(const std::string& name) {
  const fs::path place(name);
  fs::path up;
  for (auto depth = std::distance(place.begin(), place.end()); depth > 1; --depth) up /= "..";
  return up / ".kalfem" / "current" / place;
}

bool is_our_link(const fs::path& place, const std::string& name) {
  std::error_code error;
  return fs::is_symlink(fs::symlink_status(place, error)) && fs::read_symlink(place, error) == link_target(name);
}

bool stands(const fs::path& place) {
  std::error_code error;
  return fs::exists(fs::symlink_status(place, error));
}

/// What file systems without links answer.
bool has_no_links(const std::error_code& code) {
  return code == std::errc::operation_not_supported || code == std::errc::operation_not_permitted ||
         code == std::errc::function_not_supported || code == std::errc::not_supported ||
         code == std::errc::too_many_links || code == std::errc::permission_denied;
}

Names united(const Names& one, const Names& two) {
  Names all;
  std::ranges::set_union(one, two, std::back_inserter(all));
  return all;
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder, Exchange exchange)
    : folder_(std::move(folder)), exchange_(exchange), made_here_(!stands(folder_)), lock_(folder_) {
  settle();
  clear_hidden();
  clear_temporaries();
  std::error_code error;
  fs::create_directories(staging(), error);
  if (error) fail_to_write(folder_, error.value());
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!stands(current()))
    clear_hidden();  // otherwise the places of the files lead into it, and the next run settles it
  { const FolderLock ending = std::move(lock_); }
  if (made_here_) fs::remove(folder_, ignored);  // fails, as it should, where it is not empty
}

std::vector<std::string> OutputFolder::replace(const Names& former) {
  Names fresh = files_below(staging());
  require_places(fresh);
  for (const auto& name : united(fresh, folders_below(staging()))) bring_to_disk(staging() / name);
  Names gone;
  for (const auto& name : former)
    if (!std::ranges::binary_search(fresh, name) && stands(folder_ / name) && !fs::is_directory(folder_ / name))
      gone.push_back(name);
  std::ranges::sort(gone);
  if (exchange_ == Exchange::one_by_one || !switch_to_staging(united(fresh, gone))) move_one_by_one(fresh, gone);
  bring_to_disk(folder_);
  clear_hidden();
  std::error_code error;
  fs::create_directories(staging(), error);
  return fresh;
}

/// Steps 1 to 4; false, with the former files in their places, where the file system has no links.
bool OutputFolder::switch_to_staging(const Names& names) const {
  try {
    keep(names);
    turn_current_to("old");
    link_places(names);
    bring_to_disk(lock_.hidden());
    turn_current_to("new");
    bring_to_disk(lock_.hidden());
    settle();
    return true;
  } catch (const fs::filesystem_error& error) {
    settle();  // `current` leads to the former files or to nothing
    if (!has_no_links(error.code())) fail_to_write(folder_, error.code().value());
    return false;
  }
}

/// Finds what cannot be replaced before anything is.
void OutputFolder::require_places(const Names& names) const {
  for (const auto& name : names) {
    std::error_code error;
    if (fs::is_directory(folder_ / name, error)) fail_to_write(folder_ / name, EISDIR);
    const fs::path parent = (folder_ / name).parent_path();
    if (stands(parent) && !fs::is_directory(parent, error)) fail_to_write(folder_ / name, ENOTDIR);
  }
}

void OutputFolder::keep(const Names& names) const {
  fs::create_directories(kept());
  for (const auto& name : names) {
    if (!stands(folder_ / name)) continue;
    fs::create_directories((kept() / name).parent_path());
    fs::create_hard_link(folder_ / name, kept() / name);
  }
}

void OutputFolder::link_places(const Names& names) const {
  const fs::path link = lock_.hidden() / "link";
  for (const auto& name : names) {
    fs::create_directories((folder_ / name).parent_path());
    fs::create_symlink(link_target(name), link);
    fs::rename(link, folder_ / name);
  }
}

void OutputFolder::turn_current_to(const char* target) const {
  const fs::path link = lock_.hidden() / "link";
  fs::create_symlink(target, link);
  fs::rename(link, current());
}

/// Puts the files that `current` leads to in the places of the links to them; links that lead nowhere go.
void OutputFolder::settle() const {
  if (!stands(current())) return;
  for (const auto& name : united(files_below(staging()), files_below(kept()))) settle_place(name);
  std::error_code ignored;
  fs::remove(current(), ignored);
}

void OutputFolder::settle_place(const std::string& name) const {
  const fs::path place = folder_ / name;
  if (!is_our_link(place, name)) return;
  if (!stands(current() / name)) return remove(name);
  std::error_code error;
  fs::rename(current() / name, place, error);
  if (error) fail_to_write(place, error.value());
}

void OutputFolder::move_one_by_one(const Names& names, const Names& gone) const {
  for (const auto& name : gone) remove(name);
  for (const auto& name : names) {
    std::error_code error;
    fs::create_directories((folder_ / name).parent_path(), error);
    fs::rename(staging() / name, folder_ / name, error);
    if (error) fail_to_write(folder_ / name, error.value());
  }
}

/// Removes a file, and the folders that it leaves empty.
void OutputFolder::remove(const std::string& name) const {
  std::error_code error;
  fs::remove(folder_ / name, error);
  for (fs::path part = fs::path(name).parent_path(); !part.empty() && !error; part = part.parent_path())
    fs::remove(folder_ / part, error);
}

/// Temporary files of `write_file_atomically` whose process was killed.
void OutputFolder::clear_temporaries() const {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder_, ignored))
    if (entry.path().filename().string().ends_with(temporary_ending)) fs::remove(entry.path(), ignored);
}

void OutputFolder::clear_hidden() const {
  std::error_code ignored;
  for (const auto& left : {staging(), kept(), current(), lock_.hidden() / "link"}) fs::remove_all(left, ignored);
}

}  // namespace kalfem
