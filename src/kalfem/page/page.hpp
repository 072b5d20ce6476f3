// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/pictures/scene.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// What a curve stands for; decides its colour and stroke, the same on every chart of the page.
enum class Role {
  truth,      ///< reference values: thin, dark, dashed
  estimate,   ///< filtered or smoothed values: blue, solid
  measured,   ///< a sensor's record: grey
  predicted,  ///< response of the driven substructure: vermilion
  initial,    ///< a first guess or the model before updating: purple, dotted
  limit,      ///< a bound or a confidence limit: green, dashed
  other,      ///< the next free colour
};

/// One curve.
struct Series {
  std::string label = {};
  std::vector<double> y = {};
  std::vector<double> lower = {};  ///< band around y, empty for none
  std::vector<double> upper = {};
  Role role = Role::other;
  std::vector<double> x = {};  ///< only on a scatter chart: the abscissae of this curve
  bool points = false;         ///< only on a scatter chart: a cloud of points in the place of a path
};

/// A range on an axis, low < high.
using AxisRange = std::array<double, 2>;

/// Curves over one abscissa (time, frequency), or with `scatter` paths in a plane (connector force over deformation).
/// Values that are not finite are gaps.
struct Chart {
  std::string id = {};  ///< for links, "#chart-<id>"; no blanks, used once on the page; empty: numbered
  std::string title = {};
  std::string caption = {};
  std::string x_label = {};  ///< with the unit, "time [s]"
  std::string y_label = {};
  std::vector<double> x = {};  ///< strictly increasing; empty on a scatter chart
  std::vector<Series> series = {};
  bool scatter = false;
  std::optional<AxisRange> x_window = {};  ///< part of x that is shown first
  std::optional<AxisRange> y_window = {};  ///< part of y that is shown first; else what the curves need
  bool half_width = false;                 ///< two in a row on a wide screen; scatter charts always are
  std::string fold = {};                   ///< charts in a row with the same words here stand folded away behind them
};

enum class Align { left, right, center };

struct Table {
  std::string title = {};
  std::vector<std::string> columns = {};
  std::vector<std::vector<std::string>> rows = {};  ///< as many cells as columns
  std::vector<Align> alignment = {};       ///< per column; empty: columns of numbers to the right, text to the left
  std::vector<std::string> graphics = {};  ///< one svg element a row, as a last column of their own; empty: none
  std::string graphics_title = {};         ///< heading of that column
  std::string caption = {};
  bool half_width = false;
  std::string copied = {};  ///< what a button takes to the clipboard: the numbers for a spreadsheet; empty: no button
};

/// A drawing of our own; it goes into the page as it is.
struct Picture {
  std::string title = {};
  std::string caption = {};
  std::string svg = {};  ///< one svg element
  bool half_width = false;
};

/// A text as it stands, with a button that copies it.
struct Listing {
  std::string title = {};
  std::string text = {};
  bool folded = true;        ///< away behind its title
  std::string caption = {};  ///< of one that is not folded
};

struct Section {
  std::string heading = {};
  std::string text = {};  ///< plain text; an empty line starts a paragraph
  std::vector<std::variant<Chart, Table, Picture, Listing, Scene>> items = {};
  std::size_t aside = 0;  ///< from this item on they stand in a second column on a wide screen; 0: none does
};

struct Page {
  std::string title = {};
  std::string subtitle = {};
  std::optional<VerdictState> status = {};  ///< empty: nothing was compared, so there is no badge
  std::string summary = {};                 ///< the answer in a sentence or two, beside the status
  std::vector<std::string> warnings = {};   ///< below it
  std::vector<Section> sections = {};
  std::vector<std::string> files = {};  ///< beside the page, to be linked
  std::string run = {};                 ///< identity of the run, see run_identity(); empty: not shown
};

/// Rows of a chart, and points of a path, that are kept; longer records are thinned so that every peak stays.
inline constexpr std::size_t report_points = 4000;

/// The page as one self-contained HTML document: data, style and scripts inside, no reference to any other resource.
/// All texts are taken as plain text. Throws InvalidInput with every mistake of the page: unequal lengths, abscissae
/// that do not increase, empty ranges, ids that appear twice, rows of the wrong length.
std::string render_html(const Page& page);

/// Rows of [begin, end) to draw so that no curve loses a peak, ascending, at most `limit` of them
/// (more only when even the whole range's extremes are more).
///
/// The range is cut into buckets of equal length; of each bucket the rows stay at which some curve has its minimum or
/// its maximum, so what is drawn are true samples at their true places. A bucket in which a curve has no finite value
/// keeps its first row, so that the gap is seen. The first and the last row stay; nothing is dropped when
/// end - begin <= limit. All curves have at least `end` values.
std::vector<std::size_t> rows_to_draw(std::span<const std::span<const double>> curves, std::size_t begin,
                                      std::size_t end, std::size_t limit);

/// The charts of a page, in the order of their appearance, as a JSON array that may stand inside a script element:
/// thinned to about `report_points` rows, gaps as null, "<", ">" and "&" escaped.
std::string charts_as_json(const Page& page);

/// The scenes of a page likewise.
std::string scenes_as_json(const Page& page);

}  // namespace kalfem
