// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/frequency_response_file.hpp"

namespace kalfem {
namespace {

MeasuredFunction function(MeasuredPlace response, MeasuredPlace reference, double value) {
  MeasuredFunction made{.name = "H", .unit = "(m/s^2)/N", .kind = MeasuredFunctionKind::frequency_response};
  made.response = response;
  made.reference = reference;
  made.lines = Eigen::VectorXd::LinSpaced(5, 1.0, 5.0);
  made.values = Eigen::VectorXcd::Constant(5, {value, 1.0});
  return made;
}

MeasuredFile file_of(std::vector<MeasuredFunction> functions) {
  MeasuredFile file{.format = "universal file"};
  file.functions = std::move(functions);
  return file;
}

std::string refusal(const MeasuredFile& file) {
  try {
    frf_matrix_of(file, "test.unv");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(FrfMatrixFile, SortsFunctionsByOutputAndInput) {
  auto coherence = function({9, 1}, {1, 3}, 7.0);
  coherence.kind = MeasuredFunctionKind::coherence;
  const auto [frfs, places, remarks] =
      frf_matrix_of(file_of({function({2, -3}, {1, 3}, 21.0), function({1, 3}, {5, 1}, 15.0), coherence,
                             function({1, 3}, {1, 3}, 11.0), function({2, -3}, {5, 1}, 25.0),
                             function({3, 1}, {1, 3}, 31.0), function({3, 1}, {5, 1}, 35.0)}),
                    "test.unv");
  EXPECT_EQ(frfs.inputs, (std::vector<std::string>{"1:+Z", "5:+X"}));
  ASSERT_EQ(frfs.outputs.size(), 3u);
  EXPECT_EQ(frfs.outputs[1].name, "2:+Z");
  EXPECT_EQ(frfs.outputs[1].unit, "(m/s^2)/N");
  EXPECT_EQ(places[2].node, 3);
  EXPECT_EQ(places[2].direction, 1);
  EXPECT_EQ(frfs.values[0](0, 0), std::complex<double>(11.0, 1.0));
  EXPECT_EQ(frfs.values[0](0, 1), std::complex<double>(-21.0, -1.0));  // it looks against the direction
  EXPECT_EQ(frfs.values[1](4, 2), std::complex<double>(35.0, 1.0));
  EXPECT_TRUE(remarks.empty());
}

TEST(FrfMatrixFile, AHammerThatMovedIsTakenByReciprocity) {
  const auto [frfs, places, remarks] = frf_matrix_of(
      file_of({function({1, 3}, {1, 3}, 11.0), function({1, 3}, {2, 3}, 12.0), function({1, 3}, {3, -3}, 13.0)}),
      "t.unv");
  EXPECT_EQ(frfs.inputs, (std::vector<std::string>{"1:+Z"}));
  ASSERT_EQ(frfs.outputs.size(), 3u);
  EXPECT_EQ(frfs.values[0](0, 2), std::complex<double>(-13.0, -1.0));
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("reciprocity"), std::string::npos);
}

TEST(FrfMatrixFile, MistakesAreNamed) {
  const auto one = function({1, 3}, {1, 3}, 1.0), two = function({2, 3}, {1, 3}, 2.0);
  EXPECT_NE(refusal(file_of({})).find("test.unv: the file has no frequency response"), std::string::npos);
  EXPECT_NE(refusal(file_of({one, two, two})).find("the response at 2:+Z to 1:+Z is there twice"), std::string::npos);
  EXPECT_NE(
      refusal(file_of({one, two, function({1, 3}, {2, 3}, 3.0)})).find("there is no response between 2:+Z and 2:+Z"),
      std::string::npos);
  auto other = two;
  other.lines *= 2.0;
  EXPECT_NE(refusal(file_of({one, other})).find("has other frequencies"), std::string::npos);
  other = two;
  other.values.imag().setZero();
  EXPECT_NE(refusal(file_of({one, other})).find("has no imaginary part"), std::string::npos);
  other = two;
  other.values[2] = std::nan("");
  EXPECT_NE(refusal(file_of({one, other})).find("holds values that are no numbers"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
