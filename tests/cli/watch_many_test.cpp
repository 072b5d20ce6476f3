// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "background.hpp"
#include "command.hpp"
#include "watch/live_case.hpp"

namespace kalfem::test {
namespace {

using namespace live_case;
using Json = nlohmann::json;

/// The body of an answer to GET, and its status in front of it.
std::string get(int port, const std::string& path) {
  const int client = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    const std::string request = "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
    static_cast<void>(write(client, request.data(), request.size()));
    char buffer[4096];
    for (ssize_t count = 0; (count = ::read(client, buffer, sizeof buffer)) > 0;) answer.append(buffer, size_t(count));
  }
  close(client);
  return answer;
}

void send_lines(int port, const std::string& lines) {
  const int sender = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(connect(sender, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(write(sender, lines.data(), lines.size()), std::ssize(lines));
  close(sender);
}

TEST(WatchMany, ServesAFolderWithAFailingCaseAndTellsItsHealth) {
  const ScratchFolder folder("watch_many");
  const std::string drive = written(folder / "drive.yaml", simulated(4.0));
  const auto lines = run_command("play " + drive + " --speed 0", folder).output;
  std::filesystem::create_directories(folder / "cases");
  const int first = free_port(), second = free_port(), metrics = free_port();
  written(folder / "cases" / "first.yaml", live("port: " + std::to_string(first)));
  written(folder / "cases" / "second.yaml", live("port: " + std::to_string(second)));
  written(folder / "cases" / "broken.yaml", "kalfem: 1\nnonsense: 1\n");
  Background watching(command_file() + " watch " + (folder / "cases").string() + " --state " +
                      (folder / "kept").string() + " --metrics " + std::to_string(metrics) + " >" +
                      (folder / "out.jsonl").string() + " 2>" + (folder / "err.txt").string());
  ASSERT_TRUE(comes_true([&] { return get(metrics, "/health").find("second") != std::string::npos; }))
      << read(folder / "err.txt");
  ASSERT_TRUE(comes_true([&] {
    const std::string told = read(folder / "err.txt");
    return told.find("first: reads lines") != std::string::npos &&
           told.find("second: reads lines") != std::string::npos;
  }));
  send_lines(first, lines);
  send_lines(second, lines);
  ASSERT_TRUE(comes_true([&] {
    const std::string told = get(metrics, "/metrics");
    return told.find("kalfem_samples_total{case=\"first\"}") != std::string::npos &&
           told.find("kalfem_samples_total{case=\"second\"}") != std::string::npos;
  })) << get(metrics, "/metrics");
  EXPECT_NE(get(metrics, "/metrics").find("kalfem_up{case=\"broken\"} 0"), std::string::npos);
  EXPECT_NE(get(metrics, "/health").find("503 Service Unavailable"), std::string::npos);
  EXPECT_NE(get(metrics, "/other").find("404 Not Found"), std::string::npos);
  EXPECT_EQ(watching.end(SIGTERM), 2);  // one case is to be mended
  EXPECT_NE(read(folder / "err.txt").find("broken: "), std::string::npos);
  // Each is ended wherever it stands: they are compared where both told an estimate.
  std::map<double, std::map<std::string, Json>> told_at;
  std::istringstream out(read(folder / "out.jsonl"));
  for (std::string line; std::getline(out, line);) {
    const Json told = Json::parse(line);
    if (told.contains("parameters")) told_at[told["t"]][told["case"]] = told["parameters"];
  }
  std::erase_if(told_at, [](const auto& of) { return of.second.size() < 2; });
  ASSERT_FALSE(told_at.empty()) << read(folder / "out.jsonl");
  for (const auto& [t, of] : told_at) EXPECT_EQ(of.at("first"), of.at("second")) << "at " << t;
  EXPECT_TRUE(std::filesystem::exists(folder / "kept" / "first" / "state"));
}

TEST(WatchMany, RefusesAFolderWithoutCases) {
  const ScratchFolder folder("watch_none");
  const auto outcome = run_command("watch " + folder.path().string(), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("holds no case"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
