#include "kalfem/report/page.hpp"

#include <algorithm>
#include <cctype>

#include "kalfem/base/text.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/report/embedded_assets.hpp"
#include "kalfem/report/page_check.hpp"
#include "kalfem/report/page_data.hpp"

namespace kalfem {
namespace {

/// The document may use nothing but itself.
constexpr const char* content_policy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
    "form-action 'none'";

std::string element(const std::string& tag, const std::string& attributes, const std::string& content) {
  return "<" + tag + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + tag + ">\n";
}

/// An element of escaped text, nothing for no text.
std::string text_element(const std::string& tag, const std::string& attributes, const std::string& text) {
  return text.empty() ? "" : element(tag, attributes, escaped(text));
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
           element("footer", "", "Written by kalfem " + std::string(version) + run_words(page));
  }

private:
  static std::string header(const Page& page) {
    const bool ok = page.status == PageStatus::ok;
    const std::string badge = element("span", ok ? "class=\"badge ok\"" : "class=\"badge unusable\"",
                                      ok ? "\u2713 Results usable" : "\u2717 Results not usable");
    return element(
        "header", "",
        text_element("h1", "", page.title) + text_element("p", "class=\"subtitle\"", page.subtitle) +
            element("div", "class=\"verdict\" role=\"status\"", badge + text_element("p", "", page.summary)));
  }

  static std::string run_words(const Page& page) { return page.run.empty() ? "" : ", run " + escaped(page.run); }

  static std::string contents(const Page& page) {
    std::string entries;
    for (std::size_t s = 0; s < page.sections.size(); ++s) {
      const std::string link = "href=\"#section-" + std::to_string(s + 1) + "\"";
      entries += element("li", "", element("a", link, escaped(page.sections[s].heading)));
    }
    return element("nav", "aria-label=\"Contents\"", element("h2", "", "Contents") + element("ol", "", entries));
  }

  std::string html(const Section& section) {
    const std::string id = "section-" + std::to_string(++sections_);
    std::string items;
    for (const auto& item : section.items) items += std::visit([this](const auto& it) { return this->html(it); }, item);
    return element("section", "id=\"" + id + "\" aria-labelledby=\"" + id + "-heading\"",
                   text_element("h2", "id=\"" + id + "-heading\"", section.heading) + paragraphs(section.text) +
                       element("div", "class=\"items\"", items));
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
        "figure", "class=\"chart full picture\"",
        text_element("h3", "", picture.title) + picture.svg + text_element("figcaption", "", picture.caption));
  }

  static std::string html(const Table& table) {
    std::string head;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const std::string side = align_class(alignment(table, c));
      head += element("th", "scope=\"col\" " + side, escaped(table.columns[c]));
    }
    std::string rows;
    for (const auto& row : table.rows) rows += element("tr", "", cells(table, row));
    return element("div", "class=\"table\" tabindex=\"0\" role=\"group\" aria-label=\"" + escaped(table.title) + "\"",
                   element("table", "",
                           text_element("caption", "", table.title) + element("thead", "", element("tr", "", head)) +
                               element("tbody", "", rows)));
  }

  static std::string cells(const Table& table, const std::vector<std::string>& row) {
    std::string html;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool prose = row[c].size() > longest_plain_cell;
      const std::string side = prose ? "class=\"prose\"" : align_class(alignment(table, c));
      html += c == 0 ? element("th", "scope=\"row\" " + side, escaped(row[c])) : element("td", side, escaped(row[c]));
    }
    return html;
  }

  std::size_t sections_ = 0;
  std::size_t charts_ = 0;
};

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
      style(assets::uplot_style()) + style(assets::report_style());
  const std::string body =
      "<a class=\"skip\" href=\"#main\">Skip to the results</a>\n" + Body().of(page) +
      "<noscript><p class=\"note\">The charts need JavaScript; the tables do not.</p></noscript>\n" +
      element("script", "type=\"application/json\" id=\"chart-data\"", charts_as_json(page)) +
      script(assets::uplot_script()) + script(assets::report_script());
  return "<!DOCTYPE html>\n" + element("html", "lang=\"en\"", element("head", "", head) + element("body", "", body));
}

}  // namespace kalfem
