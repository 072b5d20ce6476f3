// SPDX-License-Identifier: Apache-2.0
#include "casefile/damping_of_unknowns.hpp"

// An unknown of the filter in the substructure that an updating compares with the record.

namespace kalfem::test {
namespace {

std::string updating_case(const std::string& unknown, const std::string& parameter) {
  return chain_case("3 s", unknown) + "\nupdate:\n  parameters: {" + parameter +
         "}\n  compare: {record: {time_history: body}}\n";
}

const std::string unknown = "    body.3-4.stiffness: {initial: 33 kN/m, std: 3 %}\n";

TEST(DrivenUnknowns, AreRefused) {
  try {
    study_of(updating_case(unknown, "body.7-8.stiffness: {}"));
    FAIL() << "it was accepted";
  } catch (const InvalidInput& error) {
    for (const char* piece :
         {"chain.yaml:", "'body.3-4.stiffness' is an unknown of the filter", "list it under update.parameters instead"})
      EXPECT_NE(std::string(error.what()).find(piece), std::string::npos) << piece << " in: " << error.what();
  }
  study_of(updating_case("    wheel.k_w.stiffness: {initial: 22 kN/m, std: 3 %}\n", "body.7-8.stiffness: {}"));
}

}  // namespace
}  // namespace kalfem::test
