#include "kalfem/base/write_failure.hpp"

#include <sys/resource.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

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
    return "the disk takes no more files, though " + size_text(*left) + " are available";
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
      throw WriteFailure(what, full_disk(path, needed), "free some space, or write to another disk");
    case EDQUOT:
      throw WriteFailure(what, "the disk quota is used up" + (needed ? ": " + needs(needed) + "more than is left" : ""),
                         "free some space, or write to another disk");
    case EFBIG:
      throw WriteFailure(what, "the file would be too large: " + needs(needed) + "the limit is " + size_limit(),
                         "raise the limit, or write to another disk");
    case EIO:
      throw WriteFailure(what, "the device reports an error", "check the disk, or write to another one");
    case EISDIR:
      throw InvalidInput(what, "a folder of that name stands there", "rename the folder, or choose another place");
    case ENOTDIR:
      throw InvalidInput(what, "a part of its path is a file, not a folder", "choose another place");
    default:
      throw InvalidInput(what, std::generic_category().message(code), "choose another place or change the permissions");
  }
}

}  // namespace kalfem
