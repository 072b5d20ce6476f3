#include "kalfem/report/page_check.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/base/invalid_input.hpp"

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
    require(!chart.series.empty(), "it has no series", "there must be something to draw");
    check_window(chart.x_window, "x_window");
    check_window(chart.y_window, "y_window");
    if (!chart.scatter) check_abscissa(chart.x);
    for (const auto& series : chart.series) check(series, chart);
  }

  void check_id(const std::string& id) {
    require(id.find_first_of(" \t\r\n\f") == std::string::npos, "its id holds a blank", "an id is one word");
    // A chart without an id is known by its number.
    const std::string known_as = id.empty() ? std::to_string(ids_.size() + 1) : id;
    require(ids_.insert(known_as).second, "its id is taken", "each chart has an id of its own");
  }

  void check_window(const std::optional<AxisRange>& window, const std::string& name) {
    if (!window) return;
    const auto [low, high] = *window;
    require(std::isfinite(low) && std::isfinite(high) && low < high,
            name + " is [" + std::to_string(low) + ", " + std::to_string(high) + "]", "low must be below high");
  }

  void check_abscissa(const std::vector<double>& x) {
    const auto finite = [](double value) { return std::isfinite(value); };
    require(std::all_of(x.begin(), x.end(), finite), "x holds a value that is not finite", "each point needs a place");
    const auto not_increasing = [](double a, double b) { return !(a < b); };
    require(std::adjacent_find(x.begin(), x.end(), not_increasing) == x.end(), "x does not increase",
            "use a scatter chart for paths");
  }

  void check(const Series& series, const Chart& chart) {
    const auto& x = chart.scatter ? series.x : chart.x;
    const std::string name = "series '" + series.label + "': ";
    require(series.y.size() == x.size(),
            name + std::to_string(series.y.size()) + " values over " + std::to_string(x.size()) + " abscissae",
            "each value needs one");
    const bool no_band = series.lower.empty() && series.upper.empty();
    require(no_band || (series.lower.size() == series.y.size() && series.upper.size() == series.y.size()),
            name + "a band of other length than the curve", "lower and upper have one value for each of y");
    require(no_band || !chart.scatter, name + "a band on a scatter chart", "a path has none");
  }

  void check(const Table& table) {
    where_ = "table '" + table.title + "'";
    require(!table.columns.empty(), "it has no columns", "a table needs at least one");
    require(
        table.alignment.empty() || table.alignment.size() == table.columns.size(),
        std::to_string(table.alignment.size()) + " alignments for " + std::to_string(table.columns.size()) + " columns",
        "give one for each or none");
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      require(table.rows[row].size() == table.columns.size(),
              "row " + std::to_string(row + 1) + " has " + std::to_string(table.rows[row].size()) + " cells",
              "there are " + std::to_string(table.columns.size()) + " columns");
    }
  }

  void check(const Picture& picture) {
    where_ = "picture '" + picture.title + "'";
    require(picture.svg.starts_with("<svg") && picture.svg.find("</svg>") != std::string::npos, "it is no svg element",
            "it goes into the page as it is");
  }

  void require(bool fulfilled, const std::string& what, const std::string& why) {
    if (!fulfilled) issues_.add({}, where_ + ": " + what, why);
  }

  IssueList issues_;
  std::set<std::string> ids_;
  std::string where_;
};

}  // namespace

void check(const Page& page) { Checker().check(page); }

}  // namespace kalfem
