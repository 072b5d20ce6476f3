// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "command.hpp"
#include "watch/live_case.hpp"

namespace kalfem::test {
namespace {

using namespace live_case;
using Json = nlohmann::json;

std::vector<std::string> lines_in(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) lines.push_back(line);
  return lines;
}

Json last_line(const std::string& text) { return Json::parse(lines_in(text).back()); }

struct Watch : testing::Test {
  Watch() : folder("watch"), drive(written(folder / "drive.yaml", simulated(12.0))), watch(live_file()) {}

  [[nodiscard]] std::string live_file(const std::string& more = "") const {
    return written(folder / "watch.yaml", live(more));
  }
  /// A pipe from `play` to `watch`.
  [[nodiscard]] Outcome piped(const std::string& play, const std::string& more = "") const {
    return run_command(
        "play " + drive + " --speed 0 " + play + " 2>/dev/null | " + command_file() + " watch " + watch + " " + more,
        folder);
  }
  /// `watch` with its standard input from a pipe whose other end is returned.
  [[nodiscard]] std::pair<pid_t, int> started(const std::string& more) const {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    const pid_t child = fork();
    if (child == 0) {
      dup2(ends[0], STDIN_FILENO);
      close(ends[1]);
      const std::string line = "exec " + command_file() + " watch " + watch + " " + more + " >>" +
                               (folder / "out.jsonl").string() + " 2>>" + (folder / "err.txt").string();
      execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      _exit(127);
    }
    close(ends[0]);
    return {child, ends[1]};
  }

  ScratchFolder folder;
  std::string drive, watch;
};

TEST_F(Watch, FindsTheStiffnessThroughAPipeAsARunDoes) {
  const auto outcome = piped("", "--log " + (folder / "stream.log").string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto found = last_line(outcome.output)["parameters"]["strut.k3"];
  const double estimate = found["estimate"], deviation = found["std"];
  EXPECT_LT(std::abs(estimate - 3e6), 4.0 * deviation);
  // The log as the record of a run.
  std::ofstream table(folder / "drive.csv");
  table.precision(17);
  table << "t [s],wheel,body,road";
  for (const auto& line : lines_in(read(folder / "stream.log"))) {
    const Json block = Json::parse(line);
    for (std::size_t i = 0; i < block["wheel"].size(); ++i)
      table << "\n"
            << block["t"].get<double>() + double(i) / 500.0 << "," << block["wheel"][i].get<double>() << ","
            << block["body"][i].get<double>() << "," << block["road"][i].get<double>();
  }
  table.close();
  const auto run = written(folder / "run.yaml", recorded("drive.csv"));
  ASSERT_EQ(run_command("estimate " + run + " --set estimate.substeps=4 --set estimate.diagnose=false --out " +
                            (folder / "out").string(),
                        folder)
                .code,
            0);
  const auto summary = read_summary(folder / "out");
  const auto& of_run = summary["parameters"]["strut.k3"];
  // It has the last eight samples too, which the live filter still waits with, and the whole record's spline.
  EXPECT_NEAR(estimate, of_run["estimate"].get<double>(), 0.3 * deviation);
  EXPECT_NEAR(deviation, of_run["std"].get<double>(), 0.02 * deviation);
}

TEST_F(Watch, NamesAFaultAndReplaysWithTheSameBits) {
  const auto log = (folder / "stream.log").string();
  const auto outcome = piped("--fault dead:body:5:8", "--log " + log);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("\"kind\":\"stuck\""), std::string::npos);
  EXPECT_NE(outcome.output.find("\"kind\":\"back\""), std::string::npos);
  const auto replayed = run_command("watch " + watch + " --replay " + log, folder);
  EXPECT_EQ(replayed.output, outcome.output);
  EXPECT_EQ(replayed.code, 0);
}

TEST_F(Watch, GoesOnAfterBeingStoppedAndKilled) {
  const auto log = (folder / "stream.log").string();
  const auto played = run_command("play " + drive + " --speed 0", folder);
  const auto lines = lines_in(played.output);
  const std::size_t third = lines.size() / 3;
  for (int part = 0; part < 3; ++part) {
    const auto [child, input] = started("--log " + log);
    const std::size_t end = part == 2 ? lines.size() : (part + 1) * third;
    for (std::size_t i = part * third; i < end; ++i) {
      const std::string line = lines[i] + "\n";
      ASSERT_EQ(write(input, line.data(), line.size()), std::ssize(line));
    }
    // The log holds every line that was read; the state comes later.
    std::size_t logged = 0;
    for (int wait = 0; wait < 600 && logged < end; ++wait) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      logged = lines_in(read(folder / "stream.log")).size();
    }
    ASSERT_EQ(logged, end);
    if (part < 2) kill(child, part == 0 ? SIGTERM : SIGKILL);
    close(input);
    int status = 0;
    waitpid(child, &status, 0);
    if (part != 1) EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  const auto replayed = run_command("watch " + watch + " --replay " + log, folder);
  EXPECT_EQ(lines_in(read(folder / "out.jsonl")).back(), lines_in(replayed.output).back());
  EXPECT_NE(read(folder / "err.txt").find("goes on from"), std::string::npos);
}

TEST_F(Watch, TellsBadLinesAndGoesOn) {
  written(folder / "bad.txt",
          "nonsense\n{\"t\": 0, \"whel\": 1}\n{\"t\": 0, \"wheel\": 1, \"body\": 0.1, \"road\": 0}\n");
  const auto outcome = run_command("watch " + watch + " <" + (folder / "bad.txt").string(), folder);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.errors.find("line 1: the line 'nonsense' is neither JSON nor CSV"), std::string::npos);
  EXPECT_NE(outcome.errors.find("line 2: the case has no channel 'whel' (did you mean 'wheel'?)"), std::string::npos);
  EXPECT_EQ(last_line(outcome.output)["samples"], 1);
}

TEST_F(Watch, ReadsAPortOfThisComputer) {
  const auto lines = run_command("play " + drive + " --speed 0 --set simulate.duration=1s", folder).output;
  int port = 0;
  {  // one that is free
    const int probe = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(bind(probe, reinterpret_cast<sockaddr*>(&address), size), 0);
    getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    close(probe);
  }
  const auto [child, input] = started("--port " + std::to_string(port));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int sender = socket(AF_INET, SOCK_STREAM, 0);
  bool connected = false;
  for (int wait = 0; wait < 300 && !connected; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    connected = connect(sender, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ASSERT_TRUE(connected);
  ASSERT_EQ(write(sender, lines.data(), lines.size()), std::ssize(lines));
  close(sender);
  for (int wait = 0; wait < 300 && read(folder / "out.jsonl").empty(); ++wait)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  kill(child, SIGTERM);
  int status = 0;
  waitpid(child, &status, 0);
  close(input);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_GT(last_line(read(folder / "out.jsonl"))["samples"].get<int>(), 250);
}

TEST_F(Watch, RefusesOtherCases) {
  const auto other = run_command("watch " + drive, folder);
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.errors.find("the case has no `live`"), std::string::npos);
  const auto run = run_command("run " + watch, folder);
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.errors.find("kalfem watch"), std::string::npos);
  const auto play = run_command("play " + watch, folder);
  EXPECT_EQ(play.code, 2);
  EXPECT_NE(play.errors.find("neither `record` nor `simulate`"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
