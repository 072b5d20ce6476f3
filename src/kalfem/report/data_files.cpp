#include "kalfem/report/data_files.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <vector>

namespace kalfem {

namespace fs = std::filesystem;

std::string sha256_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  if (!stream || !digest || EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr) != 1) return "";
  std::vector<char> block(1 << 16);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0)
    EVP_DigestUpdate(digest.get(), block.data(), static_cast<std::size_t>(stream.gcount()));
  if (stream.bad()) return "";
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
