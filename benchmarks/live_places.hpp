// SPDX-License-Identifier: Apache-2.0
// What the live benchmarks start and write.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace kalfem::benchmarks {

/// A folder that is removed at the end.
class Scratch {
public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "kalfem_live_XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no folder for temporary files");
    folder_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

private:
  std::filesystem::path folder_;
};

/// A line of the shell that runs beside the benchmark, ended with it.
class Started {
public:
  explicit Started(const std::string& line) : child_(fork()) {
    if (child_ != 0) return;
    execl("/bin/sh", "sh", "-c", ("exec " + line).c_str(), nullptr);
    _exit(127);
  }
  ~Started() {
    kill(child_, SIGTERM);
    waitpid(child_, nullptr, 0);
  }
  Started(const Started&) = delete;
  Started& operator=(const Started&) = delete;
  /// User and system time so far [s].
  [[nodiscard]] double processor_seconds() const {
    std::ifstream stat("/proc/" + std::to_string(child_) + "/stat");
    std::string word;
    double ticks = 0.0;
    for (int field = 1; field <= 15 && stat >> word; ++field)
      if (field >= 14) ticks += std::stod(word);
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }

private:
  pid_t child_;
};

inline int free_port() {
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const bool bound = bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0;
  getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  close(probe);
  if (!bound) throw std::runtime_error("no free port");
  return ntohs(address.sin_port);
}

/// Connected to a port of this computer.
inline int connected_to(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return client;
  close(client);
  return -1;
}

inline void wait_for(const std::function<bool()>& question, const std::string& what) {
  for (int tenths = 0; tenths < 1200; ++tenths) {
    if (question()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  throw std::runtime_error(what + " has not come in two minutes");
}

inline void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

/// Runs a line of the shell to its end; its standard output, in lines.
inline std::vector<std::string> lines_of(const std::string& command, const Scratch& folder) {
  const auto file = folder / "lines.txt";
  if (std::system((command + " >" + file.string()).c_str()) != 0) throw std::runtime_error("failed: " + command);
  std::vector<std::string> lines;
  std::ifstream text(file);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

/// The chain of the paper with so many masses in its body and noise that is known: of a simulation, or of a stream with
/// more keys of `live`.
inline std::string chain(int masses, double rate, const std::string& simulate, const std::string& live) {
  const std::string last = std::to_string(masses), middle = std::to_string(masses / 2);
  const std::string sampling = std::to_string(rate) + " Hz";
  return R"(kalfem: 1
substructures:
  wheel:
    masses: {w: 1.5 kg}
    springs: [{name: k_w, from: ground, to: w, stiffness: 20 kN/m}]
  body:
    chain: {masses: )" +
         last + R"(, mass: 1.0 kg, stiffness: 30 kN/m}
    damping: {modal: 1 %}
connectors:
  suspension:
    from: wheel.w
    to: body.1
    law: saturating
    parameters: {k: 5 kN/m, mu_k1: 20 N, mu_k2: 2 mm, c: 10 N s/m, mu_c1: 10 N, mu_c2: 0.05 m/s}
sensors:
  a3: {acceleration: body.2, noise: 0.5 m/s^2}
  a5: {acceleration: body.4, noise: 0.5 m/s^2}
  a7: {acceleration: body.)" +
         middle + R"(, noise: 0.5 m/s^2}
  a11: {acceleration: body.)" +
         last + R"(, noise: 0.5 m/s^2}
excitation:
  road: {base_displacement: wheel.ground, )" +
         (live.empty() ? "random: {rms: 3 mm, band: [0.5, 30 Hz], seed: 7}}\nsimulate: {sample_rate: " + sampling +
                             ", " + simulate + "}\n"
                       : "file: live, channel: road}\nlive: {sample_rate: " + sampling + ", " + live + R"(}
estimate:
  unknown:
    suspension.mu_k1: {initial: 10 N, std: 50 %, random_walk: 0.1 N}
    suspension.mu_c1: {initial: 16 N, std: 50 %, random_walk: 0.1 N}
)");
}

}  // namespace kalfem::benchmarks
