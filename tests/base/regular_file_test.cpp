// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/regular_file.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

std::string refusal(const fs::path& path) {
  try {
    require_regular_file(path);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

class RegularFiles : public testing::Test {
protected:
  ScratchFolder folder_{"regular_file"};
};

TEST_F(RegularFiles, AreReadWholeOrInPart) {
  std::ofstream(folder_ / "a.txt") << "one\ntwo\n";
  EXPECT_EQ(read_bytes(folder_ / "a.txt"), "one\ntwo\n");
  EXPECT_EQ(read_bytes(folder_ / "a.txt", 3), "one");
  fs::create_symlink("a.txt", folder_ / "link");
  EXPECT_EQ(read_bytes(folder_ / "link"), "one\ntwo\n");
  EXPECT_EQ(RegularFile(folder_ / "a.txt").size(), 8u);
  std::ofstream(folder_ / "empty");
  EXPECT_EQ(read_bytes(folder_ / "empty"), "");
}

// A pipe without a writer would keep us waiting for ever, /dev/zero has no end: the test itself would hang.
TEST_F(RegularFiles, WhatElseStandsThereIsNamedAndNotWaitedFor) {
  const fs::path pipe = folder_ / "pipe", socket_name = folder_ / "socket";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(refusal(pipe).find("it is a pipe, not a regular file"), std::string::npos) << refusal(pipe);
  EXPECT_NE(refusal("/dev/zero").find("it is a device"), std::string::npos);
  EXPECT_NE(refusal("/dev/full").find("it is a device"), std::string::npos);
  EXPECT_NE(refusal(folder_.path()).find("it is a folder"), std::string::npos);
  EXPECT_NE(refusal(folder_ / "absent").find("there is no such file"), std::string::npos);
  EXPECT_NE(refusal(folder_ / "absent" / "too").find("there is no such file"), std::string::npos);
  fs::create_symlink(pipe, folder_ / "link");
  EXPECT_NE(refusal(folder_ / "link").find("it is a pipe"), std::string::npos);
  fs::create_symlink("circle", folder_ / "circle");
  EXPECT_NE(refusal(folder_ / "circle").find("the file cannot be read"), std::string::npos);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_name.string().size() < sizeof address.sun_path) {
    socket_name.string().copy(address.sun_path, sizeof address.sun_path - 1);
    const int end = socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(bind(end, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_NE(refusal(socket_name).find("it is a socket"), std::string::npos);
    close(end);
  }
  EXPECT_EQ(bytes_if_readable(pipe), "");
}

TEST_F(RegularFiles, PermissionsAreNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "the superuser may read everything";
  std::ofstream(folder_ / "secret") << "x";
  fs::permissions(folder_ / "secret", fs::perms::none);
  EXPECT_NE(refusal(folder_ / "secret").find("Permission denied; change its permissions"), std::string::npos);
  fs::permissions(folder_ / "secret", fs::perms::owner_all);
}

}  // namespace
}  // namespace kalfem
