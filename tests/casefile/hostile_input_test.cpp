// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/processor_time.hpp"
#include "casefile/sample_case.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem::sample {
namespace {

/// Whatever the text, a study or InvalidInput with a message; anything else fails the test.
void survive(const std::string& text) {
  try {
    read(text);
  } catch (const InvalidInput& error) {
    EXPECT_FALSE(error.issues().empty());
    for (const auto& issue : error.issues()) {
      EXPECT_FALSE(issue.what.empty());
      EXPECT_EQ(issue.location.file, "case.yaml");
    }
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what() << "\nfrom\n" << text.substr(0, 2000);
  }
}

std::size_t below(RandomStream& random, std::size_t count) {
  return static_cast<std::size_t>(random.uniform() * static_cast<double>(count));
}

TEST(HostileInput, EveryPrefix) {
  for (std::size_t length = 0; length <= valid_text.size(); ++length) survive(valid_text.substr(0, length));
}

TEST(HostileInput, RandomMutations) {
  RandomStream random(1, "mutations");
  const std::string spice = "{}[]:,&*!|>'\"%@`#-?\n \t~<.$0e9\\\x80\xC3";
  for (int trial = 0; trial < 2000; ++trial) {
    std::string text = valid_text;
    for (std::size_t change = 1 + below(random, 4); change > 0; --change) {
      const std::size_t at = below(random, text.size());
      const char byte = trial % 2 == 0 ? spice[below(random, spice.size())] : static_cast<char>(below(random, 256));
      switch (below(random, 4)) {
        case 0:
          text[at] = byte;
          break;
        case 1:
          text.insert(at, 1, byte);
          break;
        case 2:
          text.erase(at, 1 + below(random, 20));
          break;
        default:
          text.insert(at, text.substr(below(random, text.size()), 1 + below(random, 30)));
      }
    }
    survive(text);
  }
}

std::string repeated(const std::string& part, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += part;
  return text;
}

TEST(HostileInput, DeepNesting) {
  for (const char* part : {"[", "{a: ", "- ", "? ", "- - ", "[{", "!!x ", "&a ", "a: {<<: ", "> "})
    for (const std::size_t depth : {150U, 20000U}) survive(repeated(part, depth));
  std::string block;
  for (std::size_t depth = 0; depth < 600; ++depth) block += std::string(depth, ' ') + "a:\n";
  survive(block);
  survive("title: \"" + repeated("${A:-", 100000) + "\"");
  survive("substructures: {a: {masses: {m: 1 " + repeated("(", 100000) + "}}}");
}

TEST(HostileInput, AliasesThatMultiply) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string last = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    text += name + ": &" + name + " [" + last + repeated(", " + last, 9) + "]\n";
  }
  EXPECT_NE(problems(text).find("too many values"), std::string::npos);
}

TEST(HostileInput, ManyKeysAreReadInReasonableTime) {
  std::string masses;
  for (int i = 0; i < 100000; ++i) masses += "    m" + std::to_string(i) + ": 1\n";
  const double begin = processor_seconds();
  EXPECT_EQ(read("substructures:\n  a:\n   masses:\n" + masses).substructures[0].second.masses.size(), 100000U);
  EXPECT_LT(processor_seconds() - begin, 20.0);  // a quadratic look-up takes minutes
}

}  // namespace
}  // namespace kalfem::sample
