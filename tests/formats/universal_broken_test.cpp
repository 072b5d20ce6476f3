// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "formats/universal_texts.hpp"

// Damaged universal files: a clear error or a listed skip, never a silent loss.
namespace kalfem {
namespace {

using universal_text::bytes_of;
using universal_text::dataset;
using universal_text::Function;

std::size_t things(const MeasuredFile& file) {
  return file.channels.size() + file.functions.size() + file.shapes.size() + file.nodes.size() + file.lines.size();
}

class BrokenUniversalFiles : public UniversalFiles {
protected:
  /// Datasets of every kind that is read.
  static std::vector<std::string> datasets() {
    const std::string frequency = Function{
        .type = 4,
        .reference = 3,
        .reference_direction = 1,
        .data = 5,
        .points = 3,
        .step = "1.00000E+00",
        .abscissa = {18, "f", "Hz"},
        .ordinate = {12, "A", "g"},
        .denominator = {13, "F",
                        "N"}}.with(" 1.00000E+00 2.00000E+00 3.00000E+00-4.00000E+00 5.00000E+00-6.00000E+00\n");
    return {
        dataset("164", "         1SI\n  1.0D+00  1.0D+00  1.0D+00\n"),
        dataset("15", "         7         0         1         8-2.40000E+00 1.00000E+00 0.00000E+00\n"),
        dataset("2411", "         8         1         1        11\n   2.0D+01   1.3D+01   3.9D+01\n"),
        dataset(
            "2412",
            "         1        44         1         1         7         4\n         1         2         3         4\n"),
        dataset("82", "         1         2         8\nWing\n         7         8\n"),
        dataset("55",
                "Bending\nNONE\nNONE\nNONE\nNONE\n         1         2         2         8         2         3\n"
                "         2         4         0         1\n 1.25000E+01 1.00000E+00 2.00000E-02 0.00000E+00\n"
                "         7\n 1.00000E+00-2.00000E+00 3.00000E+00\n"),
        Function{.points = 7}.with(
            " 1.00000E+00-2.00000E+00 3.00000E+00 4.00000E+00-5.00000E+00 6.00000E+00\n 7.00000E+00\n"),
        frequency,
        Function{.direction = 1, .points = 5}.with_bytes(bytes_of<float>({1, 2, 3, 4, 5}), true, "\n"),
        Function{.direction = 2, .data = 4, .points = 2, .even = 0}.with_bytes(bytes_of<double>({1, 2, 3, 4}))};
  }
};

TEST_F(BrokenUniversalFiles, AFileThatIsCutOffAnywhereLosesNothingSilently) {
  const auto parts = datasets();
  const std::string whole = parts[1];
  const std::size_t complete = 1;
  for (const auto& part : parts) {
    for (std::size_t cut = 20; cut <= part.size(); ++cut) {
      const std::string content = whole + part.substr(0, cut);
      const bool only_mark_missing = cut + 8 >= part.size();  // every sample is there
      try {
        const auto read_part = read(content);
        const bool units = part.find("   164") == 7;
        EXPECT_TRUE(only_mark_missing) << "cut at " << cut << " of\n" << part;
        EXPECT_EQ(things(read_part), complete + (units ? 0 : 1)) << content;
      } catch (const InvalidInput& error) {
        EXPECT_LT(cut + 1, part.size()) << error.what();
        EXPECT_GT(error.issues().front().location.line, 0);
      }
    }
  }
}

/// Damages of single bytes, runs of bytes, lines and numbers.
std::string damaged(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t limit) { return limit == 0 ? 0 : random() % limit; };
  for (std::size_t changes = 1 + below(3); changes > 0 && !text.empty(); --changes) {
    const std::size_t place = below(text.size()), line = text.find('\n', place), next = text.find('\n', line + 1);
    switch (below(6)) {
      case 0:
        text[place] = static_cast<char>(random());
        break;
      case 1:
        text.erase(place, 1 + below(30));
        break;
      case 2:
        text.insert(place, text.substr(below(text.size()), below(60)));
        break;
      case 3:
        if (next != std::string::npos) text.erase(line, next - line);
        break;
      case 4:
        text.replace(place, 1, "99999999999");
        break;
      default:
        text.resize(place);
    }
  }
  return text;
}

TEST_F(BrokenUniversalFiles, AThousandOfThemGiveAnErrorOrAListedSkip) {
  std::string whole;
  for (const auto& part : datasets()) whole += part;
  const std::size_t all = things(read(whole));
  std::mt19937 random(1);
  int refused = 0, listed = 0, sound = 0;
  for (int file = 0; file < 1000; ++file) {
    const std::string content = damaged(whole, random);
    try {
      const auto found = read(content);
      const bool fewer = things(found) < all;
      // whole datasets may be missing where a file was cut between two of them, or lines with their marks were lost
      if (!found.skipped.empty())
        ++listed;
      else if (!fewer)
        ++sound;
      else
        ADD_FAILURE() << "silent loss in file " << file << ":\n" << content;
      for (const auto& channel : found.channels) EXPECT_GT(channel.values.size(), 0);
    } catch (const InvalidInput& error) {
      ++refused;
      EXPECT_FALSE(error.issues().front().what.empty());
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(listed, 5);
  EXPECT_GT(sound, 50);
}

TEST_F(BrokenUniversalFiles, CountsThatNoFileCanHoldAreRefusedAtOnce) {
  for (const long points : {2000000000L, 999999999999L}) {
    EXPECT_FALSE(refusal(Function{.points = points}.with("1 2 3\n")).empty());
    EXPECT_FALSE(refusal(Function{.points = points}.with_bytes(bytes_of<float>({1, 2, 3}))).empty());
  }
  EXPECT_FALSE(refusal(dataset("2412", "1 44 0 0 0 2000000000\n1 2 3\n")).empty());
  EXPECT_FALSE(refusal(dataset("82", "1 999999999 0\nx\n1 2\n")).empty());
  std::string order = Function{.points = 1}.with_bytes(bytes_of<float>({1}));
  order.replace(order.find("58b") + 8, 1, "7");
  EXPECT_NE(refusal(order).find("test.unv:2:"), std::string::npos) << refusal(order);
}

}  // namespace
}  // namespace kalfem
