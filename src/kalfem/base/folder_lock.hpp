#pragma once

#include <filesystem>

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

}  // namespace kalfem
