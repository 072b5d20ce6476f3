// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kalfem {

/// Exclusive use of a folder among processes: a lock on the file `lock` in its hidden folder `.kalfem`. The system
/// drops the lock when the process ends, however it ends. Where the file system has no locks (some network disks),
/// nobody is kept out.
class FolderLock {
public:
  /// Makes the folder if it is missing. Throws InvalidInput, with the number of the other process, where it is in use,
  /// or where it cannot be made or written; WriteFailure where the disk is full.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  /// Removes what the lock needed, `.kalfem` too unless something else is in it.
  ~FolderLock();

  /// The hidden folder, for files of the holder.
  [[nodiscard]] const std::filesystem::path& hidden() const { return hidden_; }

private:
  std::filesystem::path hidden_;
  int descriptor_ = -1;
};

/// A folder whose files belong together and are replaced as one set: a reader sees all files of the former set or all
/// of the new one, also when the process is killed at any moment.
///
/// New files are written into `staging()`, beside the former ones. `replace()` then
///   1. keeps the former files a second time (as hard links) in a hidden folder,
///   2. puts a symbolic link through `.kalfem/current`, which leads to them, in the place of each file, old or new:
///      what a reader sees does not change,
///   3. turns `current` to the new files, by one rename: this is the switch,
///   4. puts the new files in the places of the links: what a reader sees does not change.
/// Afterwards there are plain files only. What a killed process left of this is completed or taken back when the folder
/// is opened next. On file systems without links the files are renamed one by one; then only the identity that they
/// carry tells a set from a mixture.
class OutputFolder {
public:
  /// How files are replaced; `one_by_one` is what file systems without links get in any case.
  enum class Exchange { at_once, one_by_one };

  /// Takes the folder for this process (see FolderLock), makes it if it is missing, and clears what a killed process
  /// left. Throws like FolderLock.
  explicit OutputFolder(std::filesystem::path folder, Exchange exchange = Exchange::at_once);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  /// Drops files that were not put in place; removes the folder if it was made here and is empty.
  ~OutputFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
  /// The folder for the files of the new set.
  [[nodiscard]] std::filesystem::path staging() const { return lock_.hidden() / "new"; }

  /// Replaces the files `former` (relative to the folder; missing ones are allowed) by those in `staging()`. Other
  /// files are left alone. Returns the relative names of the new set, sorted; a further set may follow. Throws, and
  /// leaves the former set in its place, where a folder stands in a file's place or the disk takes no more.
  std::vector<std::string> replace(const std::vector<std::string>& former);

private:
  using Names = std::vector<std::string>;

  [[nodiscard]] std::filesystem::path current() const { return lock_.hidden() / "current"; }
  [[nodiscard]] std::filesystem::path kept() const { return lock_.hidden() / "old"; }
  void require_places(const Names& names) const;
  [[nodiscard]] bool switch_to_staging(const Names& names) const;
  void keep(const Names& names) const;
  void link_places(const Names& names) const;
  void turn_current_to(const char* target) const;
  void settle() const;
  void settle_place(const std::string& name) const;
  void move_one_by_one(const Names& names, const Names& gone) const;
  void remove(const std::string& name) const;
  void clear_hidden() const;
  void clear_temporaries() const;

  std::filesystem::path folder_;
  Exchange exchange_;
  bool made_here_;
  FolderLock lock_;
};

}  // namespace kalfem
