// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/output_folder.hpp"

#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>

#include "base/scratch_folder.hpp"
#include "kalfem/base/atomic_file.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const fs::path& folder, const Files& files) {
  for (const auto& [name, content] : files) {
    fs::create_directories((folder / name).parent_path());
    std::ofstream(folder / name) << content;
  }
}

/// What a user finds: every name that can be opened, with its content. The hidden folder aside.
Files seen(const fs::path& folder) {
  Files files;
  for (fs::recursive_directory_iterator it(folder), end; it != end; ++it) {
    if (it->path().filename() == ".kalfem") {
      it.disable_recursion_pending();
      continue;
    }
    std::error_code error;
    if (fs::is_regular_file(it->path(), error))
      files[it->path().lexically_relative(folder).string()] = read(it->path());
  }
  return files;
}

// One file that stays, one that goes and one that comes, in the folder and below it.
const Files former{{"page", "old"}, {"series", "old"}, {"frame/0", "old"}};
const Files fresh{{"page", "new"}, {"summary", "new"}, {"wing/0", "new"}};

std::vector<std::string> names(const Files& files) {
  std::vector<std::string> all;
  for (const auto& [name, content] : files) all.push_back(name);
  return all;
}

Files with_notes(Files files) {
  files["notes.txt"] = "mine";
  return files;
}

class ResultSwitch : public testing::Test {
protected:
  /// A folder with the former set and a file of the user.
  fs::path prepared() {
    fs::remove_all(folder / "out");
    write(folder / "out", with_notes(former));
    return folder / "out";
  }

  static void switch_to_fresh(const fs::path& path) {
    OutputFolder out(path);
    write(out.staging(), fresh);
    out.replace(names(former));
  }

  /// In memory where it can be: some hundred processes wait for the disk below.
  static std::string place() {
    if (fs::is_directory("/dev/shm")) setenv("TMPDIR", "/dev/shm", 1);
    return "switch";
  }

  ScratchFolder folder{place()};
};

TEST_F(ResultSwitch, ReplacesTheSetAndNothingElse) {
  const auto path = prepared();
  switch_to_fresh(path);
  EXPECT_EQ(seen(path), with_notes(fresh));
  EXPECT_FALSE(fs::exists(path / ".kalfem"));
  for (const auto& [name, content] : fresh) EXPECT_FALSE(fs::is_symlink(path / name)) << name;
}

TEST_F(ResultSwitch, WithoutLinksTheFilesAreReplacedOneByOne) {
  const auto path = prepared();
  {
    OutputFolder out(path, OutputFolder::Exchange::one_by_one);
    write(out.staging(), fresh);
    EXPECT_EQ(out.replace(names(former)), names(fresh));
  }
  EXPECT_EQ(seen(path), with_notes(fresh));
  EXPECT_FALSE(fs::exists(path / ".kalfem"));
}

TEST_F(ResultSwitch, FoldersThatAreLeftEmptyGo) {
  const auto path = prepared();
  {
    OutputFolder out(path);
    write(out.staging(), {{"summary", "new"}});
    EXPECT_EQ(out.replace(names(former)), std::vector<std::string>{"summary"});
  }
  EXPECT_FALSE(fs::exists(path / "frame"));
  EXPECT_EQ(seen(path), (Files{{"notes.txt", "mine"}, {"summary", "new"}}));
}

TEST_F(ResultSwitch, WhatIsNotPutInPlaceLeavesTheFormerSet) {
  const auto path = prepared();
  {
    OutputFolder out(path);
    write(out.staging(), fresh);
  }
  EXPECT_EQ(seen(path), with_notes(former));
  EXPECT_FALSE(fs::exists(path / ".kalfem"));
}

TEST_F(ResultSwitch, AFolderOfItsOwnIsRemovedWhenNothingWasWritten) {
  { const OutputFolder out(folder / "a" / "b"); }
  EXPECT_FALSE(fs::exists(folder / "a" / "b"));
  fs::create_directories(folder / "mine");
  { const OutputFolder out(folder / "mine"); }
  EXPECT_TRUE(fs::exists(folder / "mine"));
}

TEST_F(ResultSwitch, AFolderInAFilesPlaceIsNamedAndNothingIsReplaced) {
  const auto path = prepared();
  fs::create_directories(path / "summary");
  try {
    switch_to_fresh(path);
    FAIL() << "a folder was replaced by a file";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("summary"), std::string::npos) << error.what();
  }
  EXPECT_EQ(seen(path), with_notes(former));
}

TEST_F(ResultSwitch, TwoAtOnceAreRefusedWithTheNumberOfTheOther) {
  const OutputFolder out(folder / "out");
  try {
    const OutputFolder second(folder / "out");
    FAIL() << "two hold the folder";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("process " + std::to_string(getpid())), std::string::npos) << error.what();
  }
}

TEST_F(ResultSwitch, TheLockVanishesWithItsProcess) {
  const pid_t child = fork();
  if (child == 0) {
    const OutputFolder out(folder / "out");
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(fs::exists(folder / "out" / ".kalfem" / "lock"));
  { const OutputFolder out(folder / "out"); }
  EXPECT_FALSE(fs::exists(folder / "out" / ".kalfem"));
}

TEST_F(ResultSwitch, TemporaryFilesOfAKilledProcessGo) {
  const auto path = prepared();
  std::ofstream(path / (".x.json.1-2" + std::string(temporary_ending))) << "half";
  { const OutputFolder out(path); }
  EXPECT_EQ(seen(path), with_notes(former));
}

/// Runs `work` in a process that is killed at its system call number `call`. False where it ends before.
template <class Work>
bool killed_at_call(int call, const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(9);
    raise(SIGSTOP);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  for (int i = 0; i < call && WIFSTOPPED(status); ++i) {
    ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    waitpid(child, &status, 0);
  }
  const bool killed = WIFSTOPPED(status);
  if (killed) {
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
  } else if (WIFEXITED(status) && WEXITSTATUS(status) == 9) {
    ADD_FAILURE() << "processes cannot be traced here";
  }
  return killed;
}

TEST_F(ResultSwitch, KilledAtAnySystemCallAReaderSeesOneSet) {
  bool switched = false;
  int call = 0;
  for (;; ++call) {
    const auto path = prepared();
    if (!killed_at_call(call, [&] { switch_to_fresh(path); })) break;
    const Files found = seen(path);
    ASSERT_TRUE(found == with_notes(former) || found == with_notes(fresh)) << "at system call " << call;
    ASSERT_TRUE(!switched || found == with_notes(fresh)) << "back to the former set at system call " << call;
    switched = found == with_notes(fresh);
    { const OutputFolder next(path); }  // the next run completes it, or takes it back
    ASSERT_EQ(seen(path), found) << "at system call " << call;
    for (const auto& [name, content] : found) ASSERT_FALSE(fs::is_symlink(path / name)) << name;
    ASSERT_FALSE(fs::exists(path / ".kalfem"));
  }
  EXPECT_TRUE(switched);
  EXPECT_GT(call, 100);  // of some 300
}

TEST_F(ResultSwitch, KilledWhileClearingUpAfterAKilledProcess) {
  // Just before its end the switch is made and links stand in the places of the files.
  int moment = 400;
  for (auto path = prepared(); !killed_at_call(moment, [&] { switch_to_fresh(path); }); path = prepared()) moment -= 10;
  int call = 0;
  for (;; ++call) {
    const auto path = prepared();
    ASSERT_TRUE(killed_at_call(moment, [&] { switch_to_fresh(path); }));
    const Files found = seen(path);
    if (!killed_at_call(4 * call, [&] { const OutputFolder next(path); })) break;
    ASSERT_EQ(seen(path), found) << "at system call " << call;
    { const OutputFolder next(path); }
    ASSERT_EQ(seen(path), found) << "at system call " << call;
    ASSERT_FALSE(fs::exists(path / ".kalfem"));
  }
  EXPECT_GT(call, 5);
}

/// Runs `work` in a process whose files may not grow beyond so many bytes; its exit code.
template <class Work>
int limited(rlim_t bytes, const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    _exit(work());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(ResultSwitch, AFileThatTheDiskDoesNotTakeIsAWriteFailureWithTheSpaceNeeded) {
  const auto path = folder / "x.json";
  write_file_atomically(path, "old");
  const int code = limited(1000, [&] {
    try {
      write_file_atomically(path, std::string(5000, 'x'));
    } catch (const WriteFailure& error) {
      const std::string text = error.what();
      return text.find(path.string()) != std::string::npos && text.find("needs 5.0 kB") != std::string::npos &&
                     text.find("1.0 kB (ulimit -f)") != std::string::npos
                 ? 0
                 : 1;
    }
    return 2;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(seen(folder), (Files{{"x.json", "old"}}));
  if (fs::exists("/dev/full")) EXPECT_THROW(write_file_atomically("/dev/full", "x"), WriteFailure);
}

}  // namespace
}  // namespace kalfem
