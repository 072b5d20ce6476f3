// SPDX-License-Identifier: Apache-2.0
#include "casefile/damping_of_unknowns.hpp"

// `damping.modal` as one parameter, where the case gives a ratio for each mode.

namespace kalfem::test {
namespace {

const std::string different = "damping: {modal: [0.2 %, 2 %, 2 %]}";
const std::string updated = R"(
update:
  parameters: {PARAMETER: {initial: 1 %}}
  compare: {free: {modes: body, frequencies: [8, 16]}}
)";

std::string with_ratios(const std::string& ratios, const std::string& unknown) {
  return with(chain_case("1 s", unknown), "damping: {modal: 1 %}", ratios);
}

std::string with_update(const std::string& ratios, const std::string& parameter) {
  std::string text = with_ratios(ratios, "");
  text.resize(text.find("estimate:"));
  return text + with(updated, "PARAMETER", parameter);
}

/// The messages of a case that is refused; "" where it is not.
std::string refusal_of(const std::string& text) {
  try {
    study_of(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

void expect_refusal(const std::string& text) {
  const std::string refusal = refusal_of(text);
  for (const char* piece :
       {"chain.yaml:", "is one value for all modal damping ratios", "[0.2 %, 2 %, 2 %]", "body.damping.modal.1"})
    EXPECT_NE(refusal.find(piece), std::string::npos) << piece << " in: " << refusal;
}

TEST(ModalRatioParameters, DifferentRatiosAreNotMadeOne) {
  expect_refusal(with_update(different, "body.damping.modal"));
  expect_refusal(with_ratios(different, "    body.damping.modal: {initial: 1 %}\n"));
  expect_refusal(with_ratios(different, "    common: {initial: 1 %, applies_to: [body.damping.modal]}\n"));
}

TEST(ModalRatioParameters, EqualRatiosAndSingleOnesAreParameters) {
  for (const std::string ratios : {"damping: {modal: 1 %}", "damping: {modal: [1 %, 1 %]}"}) {
    EXPECT_EQ(refusal_of(with_update(ratios, "body.damping.modal")), "");
    EXPECT_EQ(refusal_of(with_ratios(ratios, "    body.damping.modal: {initial: 1 %}\n")), "");
  }
  EXPECT_EQ(refusal_of(with_update(different, "body.damping.modal.2")), "");
  EXPECT_EQ(refusal_of(with_ratios(different,
                                   "    body.damping.modal.1: {initial: 0.3 %}\n"
                                   "    rest: {initial: 1 %, applies_to: [body.damping.modal.2, "
                                   "body.damping.modal.3]}\n")),
            "");
}

}  // namespace
}  // namespace kalfem::test
