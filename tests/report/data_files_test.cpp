// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/data_files.hpp"
#include "kalfem/study/study.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "base/scratch_folder.hpp"

namespace kalfem {
namespace {

TEST(Sha256, IsThatOfTheStandard) {
  const ScratchFolder folder("data-files");
  const auto file = folder / "abc.txt";
  std::ofstream(file) << "abc";
  // FIPS 180-4's own example.
  EXPECT_EQ(sha256_of(file), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  std::ofstream(file).close();
  EXPECT_EQ(sha256_of(file), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, OfFilesLargerThanABlock) {
  const ScratchFolder folder("data-files");
  const auto file = folder / "a.txt";
  std::ofstream(file) << std::string(1000000, 'a');
  // FIPS 180-4's third example.
  EXPECT_EQ(sha256_of(file), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileThatIsNotThereIsEmpty) { EXPECT_EQ(sha256_of("no/such/file"), ""); }

TEST(DataFiles, ListsEachFileOnce) {
  const ScratchFolder folder("data-files");
  const auto file = folder / "abc.txt";
  std::ofstream(file) << "abc";
  Study study;
  study.files = {file, folder / "gone.csv", file};
  const auto files = data_files(study);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].bytes, 3u);
  EXPECT_EQ(files[0].sha256.size(), 64u);
  EXPECT_EQ(files[1].sha256, "");
}

}  // namespace
}  // namespace kalfem
