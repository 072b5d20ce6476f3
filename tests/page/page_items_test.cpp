// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

const std::string picture = "<svg viewBox=\"0 0 1 1\"></svg>";

std::string html_of(Section section) { return render_html({.title = "t", .sections = {std::move(section)}}); }

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

Chart chart(const std::string& id, const std::string& fold) {
  return {.id = id, .x_label = "x", .y_label = "y", .x = {0, 1}, .series = {{.label = "a", .y = {1, 2}}}, .fold = fold};
}

TEST(PageItems, GraphicsStandInAColumnOfTheirOwn) {
  Table table{.title = "t", .columns = {"a"}, .rows = {{"1"}, {"2"}}};
  table.graphics = {picture, picture};
  table.graphics_title = "bar";
  table.caption = "what it <is>";
  const std::string html = html_of({.heading = "h", .items = {table}});
  EXPECT_EQ(count(html, "<td>" + picture), 2u);
  EXPECT_EQ(count(html, ">bar</th>"), 1u);
  EXPECT_EQ(count(html, "what it &lt;is&gt;"), 1u);
}

TEST(PageItems, GraphicsNeedOneForEachRow) {
  Table table{.title = "t", .columns = {"a"}, .rows = {{"1"}, {"2"}}};
  table.graphics = {picture};
  EXPECT_THROW(html_of({.heading = "h", .items = {table}}), InvalidInput);
  table.graphics = {picture, "<b>no svg</b>"};
  EXPECT_THROW(html_of({.heading = "h", .items = {table}}), InvalidInput);
}

TEST(PageItems, NeighboursOfOneFoldOpenTogether) {
  const std::string html =
      html_of({.heading = "h", .items = {chart("a", ""), chart("b", "more"), chart("c", "more"), chart("d", "other")}});
  EXPECT_EQ(count(html, "<details class=\"full\""), 2u);
  EXPECT_EQ(count(html, "<summary>more</summary>"), 1u);
  EXPECT_LT(html.find("chart-a"), html.find("<details class=\"full\""));
  EXPECT_LT(html.find("<summary>more"), html.find("id=\"chart-b\""));
  EXPECT_LT(html.find("id=\"chart-c\""), html.find("<summary>other"));
}

TEST(PageItems, ListingsAreFoldedAwayAsTheyStand) {
  const std::string html = html_of({.heading = "h", .items = {Listing{"the case", "a: 1\n  b: <2>\n"}}});
  EXPECT_EQ(count(html, "<summary>the case</summary>"), 1u);
  EXPECT_EQ(count(html, "a: 1\n  b: &lt;2&gt;\n"), 1u);
  EXPECT_THROW(html_of({.heading = "h", .items = {Listing{"", "a"}}}), InvalidInput);
}

TEST(PageItems, FilesAreLinked) {
  const Page page{.title = "t", .files = {"results.h5", "a&b.vtu"}};
  const std::string html = render_html(page);
  EXPECT_EQ(count(html, "<a href=\"results.h5\">results.h5</a>"), 1u);
  EXPECT_EQ(count(html, "<a href=\"a&amp;b.vtu\">"), 1u);
}

TEST(Words, NamesKeepTheirSmallLetters) {
  EXPECT_EQ(capitalised("converged: the next step"), "Converged: the next step");
  EXPECT_EQ(capitalised("plane.9.bending_z and plane.1.bending_z"), "plane.9.bending_z and plane.1.bending_z");
  EXPECT_EQ(capitalised("mu_k1 is known"), "mu_k1 is known");
  EXPECT_EQ(capitalised("done."), "Done.");
  EXPECT_EQ(capitalised(""), "");
}

TEST(Words, ChangesHaveNoSignWhereTheirDigitsShowNone) {
  EXPECT_EQ(signed_per_cent(0.0137), "+1.37 %");
  EXPECT_EQ(signed_per_cent(-0.2288), "-22.88 %");
  EXPECT_EQ(signed_per_cent(-1e-6), "0.00 %");
  EXPECT_EQ(signed_per_cent(1e-6), "0.00 %");
  EXPECT_EQ(signed_per_cent(std::nan("")), "-");
}

}  // namespace
}  // namespace kalfem
