// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/page.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <nlohmann/json.hpp>

#include "kalfem/base/invalid_input.hpp"
#include "page/sample_page.hpp"
#include "pictures/sample_scene.hpp"

namespace kalfem {
namespace {

Page page_of(std::variant<Chart, Table, Picture, Listing, Scene> item) {
  return {.title = "t", .sections = {{.heading = "h", .items = {item}}}};
}

Chart short_chart() {
  return {.title = "c", .x_label = "x", .y_label = "y", .x = {0, 1, 2}, .series = {{.label = "a", .y = {1, 2, 3}}}};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string problems(const Page& page) {
  try {
    (void)render_html(page);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Decimation, ShortRecordsStayWhole) {
  const std::vector<double> y(100, 1.0);
  const std::span<const double> curve(y);
  EXPECT_EQ(rows_to_draw({&curve, 1}, 10, 20, 10), (std::vector<std::size_t>{10, 11, 12, 13, 14, 15, 16, 17, 18, 19}));
  EXPECT_TRUE(rows_to_draw({&curve, 1}, 5, 5, 10).empty());
}

TEST(Decimation, EveryPeakOfEveryCurveSurvives) {
  std::vector<double> a(100001, 0.0), b(100001, 0.0);
  a[41237] = 5.0;
  b[41238] = -7.0;
  b[99999] = 3.0;
  const std::array<std::span<const double>, 2> curves{a, b};
  const auto rows = rows_to_draw(curves, 0, a.size(), 400);
  EXPECT_LE(rows.size(), 400u);
  EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
  for (const std::size_t row : {0u, 41237u, 41238u, 99999u, 100000u}) {
    EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), row)) << row;
  }
}

TEST(Decimation, GapsOfABucketStayGaps) {
  std::vector<double> y(10000, 1.0);
  std::fill(y.begin() + 4000, y.begin() + 6000, std::nan(""));
  const std::span<const double> curve(y);
  const auto rows = rows_to_draw({&curve, 1}, 0, y.size(), 100);
  const auto gaps = std::count_if(rows.begin(), rows.end(), [&](std::size_t k) { return std::isnan(y[k]); });
  EXPECT_EQ(gaps, 10);  // ten of the fifty buckets of 200 lie in the gap
}

TEST(Report, DataIsThinnedRoundedAndKeepsGaps) {
  Chart chart = short_chart();
  chart.series[0].y = {1.0 / 3.0, std::numeric_limits<double>::infinity(), std::nan("")};
  EXPECT_TRUE(contains(charts_as_json(page_of(chart)), R"("y":[0.3333333,null,null])"));

  const auto json = nlohmann::json::parse(charts_as_json(sample_page()));
  ASSERT_EQ(json.size(), 6u);
  for (const auto& drawn : json) {
    for (const auto& series : drawn["series"]) {
      // Inside a first view and on either side of it the limit holds on its own.
      EXPECT_LE(series["y"].size(), 3 * report_points);
      EXPECT_EQ(series["y"].size(), (drawn["scatter"] ? series : drawn)["x"].size());
    }
  }
}

TEST(Report, TheFirstViewIsNotThinnedWithoutNeed) {
  Chart chart = short_chart();
  chart.x.resize(100000);
  for (std::size_t k = 0; k < chart.x.size(); ++k) chart.x[k] = static_cast<double>(k);
  chart.series[0].y.assign(chart.x.size(), 0.0);
  chart.x_window = AxisRange{50000.0, 52000.0};
  const auto json = nlohmann::json::parse(charts_as_json(page_of(chart)));
  const auto x = json[0]["x"].get<std::vector<double>>();
  EXPECT_EQ(std::count_if(x.begin(), x.end(), [](double at) { return at >= 50000.0 && at <= 52000.0; }), 2001);
}

TEST(Report, TextCannotLeaveItsPlace) {
  const std::string evil = "</script><script>alert('\"&')</script>\xff";
  Chart chart = short_chart();
  chart.title = chart.caption = chart.x_label = chart.series[0].label = evil;
  Page page = page_of(chart);
  page.title = page.subtitle = page.summary = page.sections[0].heading = page.sections[0].text = evil;
  page.sections[0].items.emplace_back(Table{evil, {evil}, {{evil}}});
  const std::string html = render_html(page);
  EXPECT_FALSE(contains(html, "</script><script>alert"));
  EXPECT_TRUE(contains(html, "&lt;/script&gt;&lt;script&gt;alert(&#39;&quot;&amp;&#39;)"));
  EXPECT_TRUE(contains(html, "\\u003c/script\\u003e"));
}

TEST(Report, StandsAlone) {
  Page page = sample_page();
  page.sections.push_back({"Structure", "", {sample_scene()}});
  const std::string html = render_html(page);
  for (const char* outside :
       {"src=", "<link", "@import", "url(h", "url(/", "url(\"", "url('", "href=\"http", "fetch(", "XMLHttpRequest"}) {
    EXPECT_FALSE(contains(html, outside)) << outside;
  }
  EXPECT_TRUE(contains(html, "default-src 'none'"));
  EXPECT_TRUE(contains(html, "Results consistent"));
  EXPECT_LT(html.size(), 3'000'000u);
}

TEST(Report, OnlyPagesWithAStructureHoldItsScript) {
  const std::string without = render_html(sample_page());
  EXPECT_FALSE(contains(without, "scene-data"));
  EXPECT_LT(without.size(), 1'500'000u);
  const std::string with = render_html(page_of(sample_scene()));
  EXPECT_TRUE(contains(with, "id=\"scene-data\""));
  EXPECT_TRUE(contains(with, "data-scene=\"0\""));
}

TEST(Report, ColumnsOfNumbersStandToTheRight) {
  const Table table{
      "", {"name", "value", "unit"}, {{"a", "30.0 \u00b1 0.1", "N"}, {"b", "\u22122", "m"}, {"c", "\u2013", "s"}}};
  const std::string html = render_html(page_of(table));
  EXPECT_TRUE(contains(html, "<th scope=\"col\" class=\"right\">value</th>"));
  EXPECT_TRUE(contains(html, "<td class=\"right\">30.0"));
  EXPECT_TRUE(contains(html, "<td>m</td>"));
}

TEST(Report, EveryMistakeIsNamed) {
  Page page = page_of(short_chart());
  auto& items = page.sections[0].items;
  EXPECT_EQ(problems(page), "");
  Chart bad = short_chart();
  bad.id = "1";  // the number of the first chart, which has no id
  bad.x = {0, std::nan(""), 0};
  bad.x_window = AxisRange{2, 1};
  bad.y_window = AxisRange{0, std::numeric_limits<double>::infinity()};
  bad.series[0].y = {1, 2};
  bad.series[0].lower = {1, 2};
  items.emplace_back(bad);
  Chart loop = short_chart();
  loop.id = "a b";
  loop.scatter = true;
  items.emplace_back(loop);
  items.emplace_back(Chart{.title = "none"});
  items.emplace_back(Table{"short row", {"a", "b"}, {{"1"}}, {Align::left}});
  const std::string text = problems(page);
  for (const char* part :
       {"its id is taken", "not finite", "x does not increase", "x_window is", "y_window is",
        "2 values over 3 abscissae", "band whose length differs", "id holds a blank", "3 values over 0 abscissae",
        "no series", "1 alignments for 2 columns", "row 1 has 1 cells"}) {
    EXPECT_TRUE(contains(text, part)) << part << "\nin\n" << text;
  }
}

}  // namespace
}  // namespace kalfem
