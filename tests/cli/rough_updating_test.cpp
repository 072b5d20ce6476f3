#include <gtest/gtest.h>

#include "updating_case.hpp"

// Updatings by a simulation that is not smooth in its parameters.

namespace kalfem::test {
namespace {

/// A mass that rattles between stops: a change of stiffness in the tenth digit moves the impacts.
const std::string rattle = R"(kalfem: 1
substructures:
  body: {masses: {x: 1 kg}, springs: [{name: k, from: ground, to: x, stiffness: 10 N/m, damping: 0.05}]}
connectors:
  stop: {from: body.ground, to: body.x, law: gap, parameters: {k_stop: 1e5, c_stop: 2, gap_upper: 1 mm, gap_lower: 1 mm}}
excitation:
  f: {force: body.x, sine: {amplitude: 1 N, frequency: 1.7}}
sensors:
  a: {displacement: body.x, noise: 1 %}
simulate: {duration: 5 s, sample_rate: 100 Hz, integrator: newmark, substeps: 16}
update:
  parameters: {body.k.stiffness: {initial: 12 N/m}}
  compare: {record: {simulation: all}}
  check_sensitivities: true
)";

TEST(RoughUpdating, SaysThatTheResidualIsNotSmooth) {
  const ScratchFolder folder("update-rough");
  const auto outcome =
      run_command("update " + written(folder, rattle).string() + " --out " + folder.path().string(), folder);
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  const std::string reason = "finite differences by 'body.k.stiffness' scatter: the residual is not smooth";
  EXPECT_NE(outcome.output.find(reason), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.errors.find(reason), std::string::npos) << outcome.errors;
  const auto updating = read_summary(folder)["updating"];
  EXPECT_FALSE(updating["converged"].get<bool>());
  EXPECT_NE(updating["termination"].get<std::string>().find(reason), std::string::npos);
  // The check at the start says the same.
  EXPECT_EQ(updating["sensitivities"]["body.k.stiffness"]["verdict"], "undecided: the differences scatter");
  EXPECT_EQ(updating["comparisons"]["record"]["substeps"], 4);
}

}  // namespace
}  // namespace kalfem::test
