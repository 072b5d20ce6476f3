// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/data_files.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/mapped_file.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

namespace fs = std::filesystem;

std::string sha256_of(const fs::path& file) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  if (!digest || EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr) != 1) return "";
  try {
    const MappedFile mapped(file);
    constexpr std::size_t at_once = 16 << 20;
    for (auto rest = mapped.bytes(); !rest.empty(); rest.remove_prefix(std::min(at_once, rest.size()))) {
      mapped.release_before(rest.data());
      EVP_DigestUpdate(digest.get(), rest.data(), std::min(at_once, rest.size()));
    }
  } catch (const InvalidInput&) {
    return "";
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int count = 0;
  EVP_DigestFinal_ex(digest.get(), bytes.data(), &count);
  std::string text;
  for (unsigned int i = 0; i < count; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

std::vector<DataFile> data_files(const Study& study) {
  std::vector<DataFile> files;
  for (const auto& path : study.files) {
    if (std::ranges::find(files, path, &DataFile::path) != files.end()) continue;
    std::error_code error;
    const auto bytes = fs::file_size(path, error);
    files.push_back({path, error ? 0 : bytes, sha256_of(path)});
  }
  return files;
}

}  // namespace kalfem
