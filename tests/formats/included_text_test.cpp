// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/text_file.hpp"

#include <gtest/gtest.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"

namespace kalfem {
namespace {

TEST(IncludedText, MessagesQuoteNumbersAndNothingElse) {
  EXPECT_EQ(without_quotations("'root:x:0' is not a number"), "'...' is not a number");
  EXPECT_EQ(without_quotations("the set 'a' b' c' is missing"), "the set '...' is missing");
  EXPECT_EQ(without_quotations("the beam's axis is ('secret')"), "the beam's axis is ('...')");
  EXPECT_EQ(without_quotations("field 3 is '1.2.3'"), "field 3 is '1.2.3'");
  EXPECT_EQ(without_quotations("the beam's axis is missing"), "the beam's axis is missing");
}

/// Files of all kinds that are no decks: system files, keys, prose, a table.
const std::vector<std::string> strangers{
    "root:x:0:0:root:/root:/bin/bash\nsecret:x:1:1::/:/bin/sh\n",
    "secretsecret0123456789abcdef\n",
    "secret\n",
    "SECRET, 1, SECRET, SECRET\n",
    "Secret words of somebody, and more.\n",
    "    secret = 12\n",
    "+secret\n",
    "*SECRET 1 2 3\n",
    "PSECRET 12\n",
    "BEGIN SECRET\n",
    "key 'secret' and 'secret'\n",
    "INCLUDE 'secret'\n",
};

void expect_hidden(const std::string& text, const std::string& content) {
  EXPECT_EQ(text.find("secret"), std::string::npos) << text << "\nof " << content;
  EXPECT_EQ(text.find("SECRET"), std::string::npos) << text << "\nof " << content;
}

/// What is said of a deck: its refusal, or else its notes.
template <class Parse>
std::string said_of(const Parse& parse) {
  try {
    std::string notes;
    for (const auto& note : parse().notes) notes += note.what + ": " + note.consequence + "\n";
    return notes;
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

TEST(IncludedText, OfAFileThatIsNoDeckNastranMessagesShowPlacesOnly) {
  const std::string grid = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\n";
  for (const auto& content : strangers) {
    if (content.starts_with("INCLUDE")) continue;  // names the next file of the deck, which its message shows
    for (const std::string& deck :
         {"CEND\nBEGIN BULK\n" + grid + "INCLUDE 'other'\nENDDATA\n",
          "CEND\nINCLUDE 'other'\nBEGIN BULK\n" + grid + "ENDDATA\n",
          "CEND\nBEGIN BULK\n" + grid + "CORD2R,7,,0.,0.,0.,0.,0.\nINCLUDE 'other'\nENDDATA\n"}) {
      const auto text = said_of([&] {
        return parse_nastran(deck, "deck.bdf", [&](const std::filesystem::path& path) {
          if (path == "other") return content;
          throw InvalidInput("no such file", "", "");
        });
      });
      expect_hidden(text, content);
    }
  }
}

TEST(IncludedText, OfAFileThatIsNoDeckAbaqusMessagesShowPlacesOnly) {
  for (const auto& content : strangers) {
    if (content.starts_with("*")) continue;  // a keyword, which is named
    for (const std::string& deck :
         {std::string("*NODE, INPUT=other\n"), std::string("*INCLUDE, INPUT=other\n*NODE\n1, 0, 0, 0\n"),
          std::string("*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=MASS, ELSET=M\n*INCLUDE, INPUT=other\n"),
          std::string("*NODE\n1, 0, 0, 0\n*NSET, NSET=A\n*INCLUDE, INPUT=other\n"),
          std::string("*NODE\n1, 0, 0, 0\n*BOUNDARY\n*INCLUDE, INPUT=other\n"),
          std::string("*NODE\n1, 0, 0, 0\n*MATERIAL, NAME=A\n*ELASTIC\n*INCLUDE, INPUT=other\n"),
          std::string("*NODE\n1, 0, 0, 0\n*MATRIX ASSEMBLE, NAME=A, STIFFNESS FILE=other\n")}) {
      const auto text = said_of(
          [&] { return parse_abaqus(deck, "deck.inp", [&](const std::filesystem::path&) { return content; }); });
      expect_hidden(text, content);
    }
  }
}

TEST(IncludedText, OfTheDeckItselfMessagesShowWhatIsWrong) {
  const auto text = said_of([] { return parse_abaqus("*NODE\n1, 0, zero, 0\n", "deck.inp", {}); });
  EXPECT_NE(text.find("'zero'"), std::string::npos) << text;
  EXPECT_NE(text.find("deck.inp:2"), std::string::npos) << text;
}

}  // namespace
}  // namespace kalfem
