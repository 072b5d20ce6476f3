// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/atomic_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
protected:
  [[nodiscard]] auto files() const { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); }

  static std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  ScratchFolder folder{"atomic"};
};

TEST_F(AtomicFile, ReplacesTheWholeFileAndLeavesNothingElse) {
  const std::string bytes("a\0b\r\n", 5);
  write_file_atomically(folder / "x.json", "something longer that was there before");
  write_file_atomically(folder / "x.json", bytes);
  EXPECT_EQ(read(folder / "x.json"), bytes);
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFile, MakesTheFolder) {
  write_file_atomically(folder / "a" / "b" / "x.json", "{}");
  EXPECT_EQ(read(folder / "a" / "b" / "x.json"), "{}");
}

TEST_F(AtomicFile, AFailureIsInvalidInputAndLeavesNoTemporaryFile) {
  fs::create_directories(folder / "taken" / "inside");  // a folder stands where the file should be
  EXPECT_THROW(write_file_atomically(folder / "taken", "{}"), InvalidInput);
  EXPECT_EQ(files(), 1);
  std::ofstream(folder / "file") << "x";
  EXPECT_THROW(write_file_atomically(folder / "file" / "x.json", "{}"), InvalidInput);
}

TEST_F(AtomicFile, APlaceThatCannotBeWrittenIsKnownBeforehand) {
  std::ofstream(folder / "file") << "x";
  EXPECT_NO_THROW(require_writable(folder / "file"));
  EXPECT_NO_THROW(require_writable(folder / "new" / "below" / "x.json"));
  EXPECT_NO_THROW(require_writable("/dev/null"));
  EXPECT_THROW(require_writable(folder.path()), InvalidInput);
  EXPECT_THROW(require_writable(folder / "file" / "x.json"), InvalidInput);
  EXPECT_THROW(require_writable(folder / "file" / "below" / "x.json"), InvalidInput);
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFile, WhatIsNoFileIsWrittenToAndNotReplaced) {
  write_file_atomically("/dev/null", "x");
  EXPECT_FALSE(fs::is_regular_file("/dev/null"));
}

}  // namespace
}  // namespace kalfem
