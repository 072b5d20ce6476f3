// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// Runs one of the programs that begin with the command's check of the processor.
Outcome run_program(const std::string& program) {
  const ScratchFolder folder("processor-check");
  const auto out = folder / "stdout.txt", err = folder / "stderr.txt";
  const int status = std::system((program + " >" + out.string() + " 2>" + err.string()).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(out), read(err)};
}

TEST(ProcessorCheck, LetsAProgramRunThatWasCompiledForThisProcessor) {
  const auto outcome = run_program(KALFEM_FOR_THIS_PROCESSOR);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.output, "initialised\nmain\n");
  EXPECT_EQ(outcome.errors, "");
}

TEST(ProcessorCheck, StopsAProgramForAnotherProcessorBeforeItIsInitialised) {
  const auto outcome = run_program(KALFEM_FOR_ANOTHER_PROCESSOR);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.output, "");
  EXPECT_NE(outcome.errors.find("this program was compiled for a processor with "), std::string::npos);
  EXPECT_NE(outcome.errors.find("KALFEM_NATIVE=OFF"), std::string::npos);
  EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
}

}  // namespace
}  // namespace kalfem::test
