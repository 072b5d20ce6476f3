// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/mapped_file.hpp"

#include <sys/mman.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"

namespace kalfem {

MappedFile::MappedFile(const std::filesystem::path& path) {
  const RegularFile file(path);
  if (file.size() == 0) return;
  void* const address = mmap(nullptr, file.size(), PROT_READ, MAP_PRIVATE, file.descriptor(), 0);
  if (address == MAP_FAILED)
    throw InvalidInput(Issue{{path.string(), 0},
                             "the file cannot be read",
                             "the system does not map its " + std::to_string(file.size()) + " bytes into memory",
                             "allow more memory (ulimit -v), or use a smaller file"});
  address_ = address;
  size_ = file.size();
  madvise(address_, size_, MADV_SEQUENTIAL);
}

void MappedFile::release_before(const char* place) const {
  constexpr std::ptrdiff_t page = 1 << 16;  // a multiple of every system's page
  const std::ptrdiff_t read = place - static_cast<const char*>(address_);
  if (read >= page && read <= static_cast<std::ptrdiff_t>(size_))
    madvise(address_, static_cast<std::size_t>(read / page * page), MADV_DONTNEED);
}

MappedFile::~MappedFile() {
  if (size_ > 0) munmap(address_, size_);
}

}  // namespace kalfem
