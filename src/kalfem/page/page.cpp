// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/page.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <span>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/page/embedded_assets.hpp"
#include "kalfem/page/typeset.hpp"

namespace kalfem {
namespace {

/// Checks one page; `where_` names the chart or table in hand.
class Checker {
public:
  void check(const Page& page) {
    for (const auto& section : page.sections) {
      for (const auto& item : section.items) std::visit([this](const auto& it) { check(it); }, item);
    }
    issues_.raise();
  }

private:
  void check(const Chart& chart) {
    where_ = "chart '" + (chart.id.empty() ? chart.title : chart.id) + "'";
    check_id(chart.id);
    require(!chart.series.empty(), "it has no series", "a chart needs a series");
    check_window(chart.x_window, "x_window");
    check_window(chart.y_window, "y_window");
    if (!chart.scatter) check_abscissa(chart.x);
    for (const auto& series : chart.series) check(series, chart);
  }

  void check_id(const std::string& id) {
    require(id.find_first_of(" \t\r\n\f") == std::string::npos, "its id holds a blank", "an id must be one word");
    // A chart without an id is known by its number.
    const std::string known_as = id.empty() ? std::to_string(ids_.size() + 1) : id;
    require(ids_.insert(known_as).second, "its id is taken", "every chart needs its own id");
  }

  void check_window(const std::optional<AxisRange>& window, const std::string& name) {
    if (!window) return;
    const auto [low, high] = *window;
    require(std::isfinite(low) && std::isfinite(high) && low < high,
            name + " is [" + std::to_string(low) + ", " + std::to_string(high) + "]", "low must be below high");
  }

  void check_abscissa(const std::vector<double>& x) {
    const auto finite = [](double value) { return std::isfinite(value); };
    require(std::all_of(x.begin(), x.end(), finite), "x holds a value that is not finite", "every x must be finite");
    const auto not_increasing = [](double a, double b) { return !(a < b); };
    require(std::adjacent_find(x.begin(), x.end(), not_increasing) == x.end(), "x does not increase",
            "use a scatter chart for paths");
  }

  void check(const Series& series, const Chart& chart) {
    const auto& x = chart.scatter ? series.x : chart.x;
    const std::string name = "series '" + series.label + "': ";
    require(series.y.size() == x.size(),
            name + std::to_string(series.y.size()) + " values over " + std::to_string(x.size()) + " abscissae",
            "every value needs one x");
    const bool no_band = series.lower.empty() && series.upper.empty();
    require(no_band || (series.lower.size() == series.y.size() && series.upper.size() == series.y.size()),
            name + "a band whose length differs from the curve's", "lower and upper need one value per y");
    require(!series.points || chart.scatter, name + "points over a common abscissa", "only a scatter chart has clouds");
  }

  void check(const Table& table) {
    where_ = "table '" + table.title + "'";
    require(!table.columns.empty(), "it has no columns", "a table needs at least one");
    require(
        table.alignment.empty() || table.alignment.size() == table.columns.size(),
        std::to_string(table.alignment.size()) + " alignments for " + std::to_string(table.columns.size()) + " columns",
        "give one for each column or none");
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      require(table.rows[row].size() == table.columns.size(),
              "row " + std::to_string(row + 1) + " has " + std::to_string(table.rows[row].size()) + " cells",
              "there are " + std::to_string(table.columns.size()) + " columns");
    }
    require(table.graphics.empty() || table.graphics.size() == table.rows.size(),
            std::to_string(table.graphics.size()) + " graphics for " + std::to_string(table.rows.size()) + " rows",
            "give one for each row or none");
    for (const auto& svg : table.graphics) check_svg(svg);
  }

  void check(const Picture& picture) {
    where_ = "picture '" + picture.title + "'";
    check_svg(picture.svg);
  }

  void check(const Listing& listing) {
    where_ = "listing '" + listing.title + "'";
    require(!listing.title.empty(), "it has no title", "it is folded away behind it");
  }

  void check_svg(const std::string& svg) {
    require(svg.starts_with("<svg") && svg.find("</svg>") != std::string::npos, "it is not an svg element",
            "it is inserted into the page unchanged");
  }

  void check(const Scene& scene) {
    where_ = "scene '" + scene.title + "'";
    for (const auto& mistake : mistakes_of(scene)) require(false, mistake, "it cannot be drawn");
  }

  void require(bool fulfilled, const std::string& what, const std::string& why) {
    if (!fulfilled) issues_.add({}, where_ + ": " + what, why);
  }

  IssueList issues_;
  std::set<std::string> ids_;
  std::string where_;
};

/// Throws InvalidInput with everything that keeps a page from being drawn; see `render_html`.
void check(const Page& page) { Checker().check(page); }

/// The document may use nothing but itself.
constexpr const char* content_policy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
    "form-action 'none'";

std::string element(const std::string& tag, const std::string& attributes, const std::string& content) {
  return "<" + tag + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + tag + ">\n";
}

/// A text as it is read.
std::string shown(const std::string& text) { return escaped(typeset(text)); }

/// An element of such text, nothing for no text.
std::string text_element(const std::string& tag, const std::string& attributes, const std::string& text) {
  return text.empty() ? "" : element(tag, attributes, shown(text));
}

/// Takes a text to the clipboard, an empty one that of the listing beside it; without scripts it is not there.
std::string copy_button(const std::string& words, const std::string& text) {
  return element("button", "type=\"button\" class=\"copy\" hidden data-copy=\"" + escaped(text) + "\"", words);
}

std::string paragraphs(const std::string& text) {
  std::string html;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find("\n\n", begin), text.size());
    html += text_element("p", "", text.substr(begin, end - begin));
    begin = end + 2;
  }
  return html;
}

/// "30.0 ± 0.1", "-2e3", "100 %" and a dash for "none" count as numbers.
bool reads_as_number(const std::string& cell) {
  if (cell.empty() || cell == "-" || cell == "\u2013" || cell == "\u2014") return true;
  std::string_view text = cell;
  for (const std::string_view sign : {"-", "+", "\u2212", "\u00b1"}) {
    if (text.starts_with(sign)) text.remove_prefix(sign.size());
  }
  return !text.empty() && std::isdigit(static_cast<unsigned char>(text.front()));
}

/// Longer texts in cells are sentences, which may fill several lines [characters].
constexpr std::size_t longest_plain_cell = 48;

Align alignment(const Table& table, std::size_t column) {
  if (!table.alignment.empty()) return table.alignment[column];
  const auto number = [column](const auto& row) { return reads_as_number(row[column]); };
  return !table.rows.empty() && std::all_of(table.rows.begin(), table.rows.end(), number) ? Align::right : Align::left;
}

std::string align_class(Align align) {
  if (align == Align::left) return "";
  return align == Align::right ? "class=\"right\"" : "class=\"center\"";
}

/// Writes the body; counts sections and charts as they come, the charts in the order of `charts_as_json`.
class Body {
public:
  std::string of(const Page& page) {
    std::string sections;
    for (const auto& section : page.sections) sections += html(section);
    return header(page) +
           element("div", "class=\"columns\"", contents(page) + element("main", "id=\"main\"", sections)) +
           element("footer", "", links(page) + "Written by kalfem " + std::string(version) + run_words(page));
  }

private:
  static std::string header(const Page& page) {
    const std::string status = page.status ? badge(*page.status) : "";
    return element(
        "header", "",
        text_element("h1", "", page.title) + text_element("p", "class=\"subtitle\"", page.subtitle) +
            element("div", "class=\"verdict\" role=\"status\"", status + text_element("p", "", page.summary)) +
            warnings(page));
  }

  static std::string badge(VerdictState status) {
    const std::string state = to_string(status);
    const std::string sign = status == VerdictState::consistent   ? "\u2713 "
                             : status == VerdictState::suspicious ? "! "
                                                                  : "\u2717 ";
    return element("span", "class=\"badge " + state + "\"", sign + "Results " + state);
  }

  static std::string warnings(const Page& page) {
    constexpr std::size_t shown = 2;  // more would push the answer off the screen
    const auto list = [&](std::size_t from, std::size_t to) {
      std::string items;
      for (std::size_t i = from; i < to; ++i) items += text_element("li", "", page.warnings[i]);
      return element("ul", "", items);
    };
    const std::size_t count = page.warnings.size();
    if (count == 0) return "";
    std::string html = list(0, std::min(shown, count));
    if (count > shown)
      html +=
          element("details", "",
                  text_element("summary", "", std::to_string(count - shown) + " more warnings") + list(shown, count));
    return element("div", "class=\"warnings\" role=\"group\" aria-label=\"Warnings\"", html);
  }

  static std::string links(const Page& page) {
    std::string all;
    for (const auto& file : page.files)
      all +=
          (all.empty() ? "Beside this page: " : ", ") + element("a", "href=\"" + escaped(file) + "\"", escaped(file));
    return all.empty() ? all : element("p", "", all);
  }

  static std::string run_words(const Page& page) { return page.run.empty() ? "" : ", run " + escaped(page.run); }

  static std::string contents(const Page& page) {
    std::string entries;
    for (std::size_t s = 0; s < page.sections.size(); ++s) {
      const std::string link = "href=\"#section-" + std::to_string(s + 1) + "\"";
      entries += element("li", "", element("a", link, shown(page.sections[s].heading)));
    }
    return element("nav", "aria-label=\"Contents\"",
                   element("details", "", element("summary", "", "Contents") + element("ol", "", entries)));
  }

  std::string html(const Section& section) {
    const std::string id = "section-" + std::to_string(++sections_);
    return element(
        "section", "id=\"" + id + "\" aria-labelledby=\"" + id + "-heading\"",
        text_element("h2", "id=\"" + id + "-heading\"", section.heading) + paragraphs(section.text) + columns(section));
  }

  std::string columns(const Section& section) {
    const auto first = section.items.begin(), last = section.items.end();
    const auto middle = first + static_cast<std::ptrdiff_t>(std::min(section.aside, section.items.size()));
    if (middle == first || middle == last) return element("div", "class=\"items\"", items({first, last}));
    return element("div", "class=\"items abreast\"",
                   element("div", "class=\"stack\"", items({first, middle})) +
                       element("div", "class=\"stack\"", items({middle, last})));
  }

  /// The items in their order, with charts that fold together in an element that opens.
  std::string items(std::span<const decltype(Section::items)::value_type> shown_here) {
    std::string all, folded, fold;
    const auto close = [&] {
      if (!folded.empty())
        all += element("details", "class=\"full\"",
                       text_element("summary", "", fold) + element("div", "class=\"items\"", folded));
      folded.clear();
    };
    for (const auto& item : shown_here) {
      const auto* chart = std::get_if<Chart>(&item);
      const std::string own = chart ? chart->fold : "";
      if (own != fold) close();
      fold = own;
      (own.empty() ? all : folded) += std::visit([this](const auto& it) { return this->html(it); }, item);
    }
    close();
    return all;
  }

  std::string html(const Chart& chart) {
    const std::string number = std::to_string(charts_++);
    const std::string id = "chart-" + (chart.id.empty() ? std::to_string(charts_) : escaped(chart.id));
    const std::string size = chart.scatter ? "scatter half" : chart.half_width ? "half" : "full";
    return element("figure", "class=\"chart " + size + "\" id=\"" + id + "\" data-chart=\"" + number + "\"",
                   text_element("h3", "", chart.title) + "<div class=\"plot\"></div>\n" +
                       text_element("figcaption", "", chart.caption));
  }

  static std::string html(const Picture& picture) {
    return element(
        "figure", "class=\"chart picture " + std::string(picture.half_width ? "half" : "full") + "\"",
        text_element("h3", "", picture.title) + picture.svg + text_element("figcaption", "", picture.caption));
  }

  static std::string html(const Listing& listing) {
    const std::string text = copy_button("Copy", "") + element("pre", "tabindex=\"0\"", escaped(listing.text));
    if (listing.folded)
      return element("details", "class=\"full listing\"", text_element("summary", "", listing.title) + text);
    return element("figure", "class=\"chart half listing\"",
                   text_element("h3", "", listing.title) + text + text_element("figcaption", "", listing.caption));
  }

  static std::string html(const Table& table) {
    std::string head;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const std::string side = align_class(alignment(table, c));
      head += element("th", "scope=\"col\" " + side, shown(table.columns[c]));
    }
    if (!table.graphics.empty()) head += element("th", "scope=\"col\"", shown(table.graphics_title));
    std::string rows;
    for (std::size_t r = 0; r < table.rows.size(); ++r) rows += element("tr", "", cells(table, r));
    const std::string size = std::string(table.half_width ? "table half" : "table") +
                             (table.half_width && !table.graphics.empty() ? " stacks" : "");
    return element("div",
                   "class=\"" + size + "\" tabindex=\"0\" role=\"group\" aria-label=\"" + escaped(table.title) + "\"",
                   element("table", "",
                           text_element("caption", "", table.title) + element("thead", "", element("tr", "", head)) +
                               element("tbody", "", rows)) +
                       (table.copied.empty() ? "" : copy_button("Copy numbers", table.copied)) +
                       text_element("p", "class=\"note-below\"", table.caption));
  }

  static std::string cells(const Table& table, std::size_t r) {
    const auto& row = table.rows[r];
    std::string html;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool prose = row[c].size() > longest_plain_cell;
      const std::string side = prose ? "class=\"prose\"" : align_class(alignment(table, c));
      const std::string label = c > 1 && table.half_width ? " data-label=\"" + shown(table.columns[c]) + "\"" : "";
      html +=
          c == 0 ? element("th", "scope=\"row\" " + side, shown(row[c])) : element("td", side + label, shown(row[c]));
    }
    if (!table.graphics.empty()) html += element("td", "", table.graphics[r]);
    return html;
  }

  /// The script builds the view; without WebGL it says so in its place.
  std::string html(const Scene& scene) {
    return element("figure", "class=\"chart full scene\" data-scene=\"" + std::to_string(scenes_++) + "\"",
                   text_element("h3", "", scene.title) + "<div class=\"structure\"></div>\n" +
                       text_element("figcaption", "", scene.caption));
  }

  std::size_t sections_ = 0;
  std::size_t charts_ = 0;
  std::size_t scenes_ = 0;
};

/// The data and the script of scenes, of a page that has any.
std::string scene_scripts(const Page& page) {
  const auto is_scene = [](const auto& item) { return std::holds_alternative<Scene>(item); };
  const auto has_scene = [&](const Section& section) { return std::ranges::any_of(section.items, is_scene); };
  if (std::ranges::none_of(page.sections, has_scene)) return "";
  return element("script", "type=\"application/json\" id=\"scene-data\"", scenes_as_json(page)) +
         element("script", "", std::string(assets::scene_script()));
}

}  // namespace

std::string render_html(const Page& page) {
  check(page);
  const auto style = [](std::string_view text) { return element("style", "", std::string(text)); };
  const auto script = [](std::string_view text) { return element("script", "", std::string(text)); };
  const std::string identity =
      page.run.empty() ? "" : "<meta name=\"kalfem-run\" content=\"" + escaped(page.run) + "\">\n";
  const std::string head =
      "<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"" +
      std::string(content_policy) + "\">\n" + element("title", "", escaped(page.title)) + identity +
      style(assets::page_style());
  const std::string body =
      "<a class=\"skip\" href=\"#main\">Skip to the results</a>\n" + Body().of(page) +
      "<noscript><p class=\"note\">The charts need JavaScript; the tables do not.</p></noscript>\n" +
      element("script", "type=\"application/json\" id=\"chart-data\"", charts_as_json(page)) +
      script(assets::page_script()) + scene_scripts(page);
  return "<!DOCTYPE html>\n" + element("html", "lang=\"en\"", element("head", "", head) + element("body", "", body));
}

}  // namespace kalfem
