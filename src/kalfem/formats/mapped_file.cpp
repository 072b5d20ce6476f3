#include "kalfem/formats/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

MappedFile::MappedFile(const std::filesystem::path& path) {
  const auto refuse = [&](const char* why) {
    throw InvalidInput(Issue{{path.string(), 0}, "the file cannot be read", why, "check the path"});
  };
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) refuse("it does not exist or is not readable");
  struct stat about {};
  if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
    close(file);
    refuse("it is no regular file");
  }
  size_ = static_cast<std::size_t>(about.st_size);
  if (size_ > 0) address_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
  close(file);
  if (address_ == MAP_FAILED) refuse("the system does not map it into memory");
  if (size_ > 0) madvise(address_, size_, MADV_SEQUENTIAL);
}

MappedFile::~MappedFile() {
  if (size_ > 0) munmap(address_, size_);
}

}  // namespace kalfem
