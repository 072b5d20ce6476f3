// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace kalfem {

/// Cuts bytes that come in pieces into lines. A line longer than `longest` is handed over cut, and its rest is dropped.
class LineCutter {
public:
  void add(std::string_view bytes, std::size_t longest, const std::function<void(std::string_view)>& on_line);
  /// What came without a line break at the end; none is left then.
  std::string take_rest();

private:
  std::string line_;
  bool too_long_ = false;
};

/// Where lines come from: bytes that were there after a wait of `milliseconds` at most. Throws InvalidInput where the
/// source fails.
class StreamSource {
public:
  enum class State { waits, gave, ended };
  virtual ~StreamSource() = default;
  virtual State read(int milliseconds, std::string& bytes) = 0;
};

/// Standard input, or any descriptor that is open.
class DescriptorSource final : public StreamSource {
public:
  explicit DescriptorSource(int descriptor) : descriptor_(descriptor) {}
  State read(int milliseconds, std::string& bytes) override;

private:
  int descriptor_;
};

/// A socket that listens at a TCP port of the loopback. Throws InvalidInput where the port is taken.
int open_loopback_port(int port);

/// One sender at a time at a TCP port of the loopback, one after the other: never ends.
class PortSource final : public StreamSource {
public:
  /// Throws InvalidInput where the port is taken.
  explicit PortSource(int port);
  ~PortSource() override;
  PortSource(const PortSource&) = delete;
  PortSource& operator=(const PortSource&) = delete;
  State read(int milliseconds, std::string& bytes) override;

private:
  int listener_ = -1, sender_ = -1;
};

/// A log of what came in: appended to as lines come, cut to whole lines when it is opened.
class StreamLog {
public:
  explicit StreamLog(const std::filesystem::path& file);
  ~StreamLog();
  StreamLog(const StreamLog&) = delete;
  StreamLog& operator=(const StreamLog&) = delete;

  [[nodiscard]] std::int64_t size() const { return size_; }  ///< bytes
  /// Throws WriteFailure where the disk takes no more.
  void add(std::string_view line);

private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace kalfem
