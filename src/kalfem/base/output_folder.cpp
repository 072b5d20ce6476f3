#include "kalfem/base/output_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <system_error>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/write_failure.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
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
  const Names fresh = files_below(staging());
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
