// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/likelihood_checkpoint.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <sstream>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/steps/updating/checkpoint.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

constexpr std::size_t digits = 16;  ///< of a double's bits

std::string bits(double value) { return fmt::format("{:016x}", std::bit_cast<std::uint64_t>(value)); }

std::optional<double> from_bits(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != digits || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return std::bit_cast<double>(value);
}

std::string line_of(const std::string& key, double value) { return key + " " + bits(value) + "\n"; }

}  // namespace

LikelihoodCheckpoint::LikelihoodCheckpoint(const std::filesystem::path& folder)
    : file_(folder.empty() ? folder : folder / likelihoods_name) {
  if (file_.empty()) return;
  read();
  std::string whole;
  for (const auto& [key, value] : earlier_) whole += line_of(key, value);
  write_file_atomically(file_, whole);
  stream_.open(file_, std::ios::app);
}

void LikelihoodCheckpoint::read() {
  std::istringstream stream(std::filesystem::exists(file_) ? read_bytes(file_) : "");
  for (std::string line; std::getline(stream, line) && !stream.eof();) {
    const auto space = line.find(' ');
    if (space == std::string::npos) continue;
    if (const auto value = from_bits(line.substr(space + 1))) earlier_.emplace(line.substr(0, space), *value);
  }
}

RememberLikelihood LikelihoodCheckpoint::of(const Study& study) {
  if (file_.empty()) return {};
  return [this, &study](const LogLikelihood& likelihood, const VectorXd& start) -> LogLikelihood {
    return [this, likelihood, of = fingerprint_of(study, likelihood(start)) + "-"](const VectorXd& theta) {
      std::string key = of;
      for (const double value : theta) key += bits(value);
      return value_of(key, theta, likelihood);
    };
  };
}

double LikelihoodCheckpoint::value_of(const std::string& key, const VectorXd& theta, const LogLikelihood& likelihood) {
  if (const auto found = earlier_.find(key); found != earlier_.end()) {
    const std::lock_guard lock(mutex_);
    ++from_earlier_;
    return found->second;
  }
  const double value = likelihood(theta);
  const std::lock_guard lock(mutex_);
  stream_ << line_of(key, value) << std::flush;
  return value;
}

}  // namespace kalfem
