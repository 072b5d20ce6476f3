// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <optional>

#include "updating_case.hpp"

// Results are the same to the last bit whatever the environment says about BLAS threads.

namespace kalfem::test {
namespace {

/// The chain of the examples with 120 masses: the products of its modes are large enough for BLAS to share them.
std::string long_chain() {
  auto text = changed(changed(read(example("chain/chain.yaml")), "duration: 20 s", "duration: 0.6 s"),
                      "tolerance: 1e-4", "tolerance: 1e-2");
  text = changed(changed(text, "masses: 10", "masses: 120"), "body.10", "body.120");
  return changed(text, "settle: 2 s", "settle: 0.1 s");
}

/// OPENBLAS_NUM_THREADS for the commands run in its lifetime; "": not set.
class BlasThreads {
public:
  explicit BlasThreads(const std::string& count) {
    if (const char* given = std::getenv(name)) before_ = given;
    count.empty() ? unsetenv(name) : setenv(name, count.c_str(), 1);
  }
  ~BlasThreads() { before_ ? setenv(name, before_->c_str(), 1) : unsetenv(name); }
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;

private:
  static constexpr const char* name = "OPENBLAS_NUM_THREADS";
  std::optional<std::string> before_;
};

TEST(SameResults, WhateverTheNumberOfBlasThreads) {
  const ScratchFolder folder("blas-threads");
  const auto file = written(folder, long_chain());
  nlohmann::json summary;
  std::string results;
  for (const std::string count : {"1", "2", ""}) {
    const BlasThreads threads(count);
    const auto out = folder / ("out-" + count);
    const auto outcome = run_command("run " + file.string() + " --out " + out.string(), folder);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    auto found = read_summary(out);
    found.erase("timing");
    if (count == "1") {
      summary = found;
      results = read(out / "results.h5");
      ASSERT_FALSE(results.empty());
      continue;
    }
    EXPECT_EQ(found, summary) << "OPENBLAS_NUM_THREADS=" << count;
    EXPECT_TRUE(read(out / "results.h5") == results) << "OPENBLAS_NUM_THREADS=" << count;
  }
}

}  // namespace
}  // namespace kalfem::test
