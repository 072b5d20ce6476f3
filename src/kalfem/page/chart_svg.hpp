// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/page/page.hpp"

namespace kalfem {

/// Size of a figure for print.
struct FigureSize {
  double width = 8.5;   ///< one column of a journal [cm]; 17 spans two
  double height = 5.5;  ///< [cm]
};

/// A chart as one SVG document, drawn for print on white paper: axes with round ticks and labels with units, a legend,
/// colours of `report.css` that are told apart with every common kind of colour blindness, dashes that repeat the
/// difference. Bands are filled; values that are not finite leave gaps; a chart with more samples than can be told
/// apart is thinned so that every peak stays (rows_to_draw()). Of a chart with `x_window` or `y_window` that part is
/// drawn. The title is not drawn (it belongs into the caption) but stands in the document for readers of the screen.
std::string chart_svg(const Chart& chart, const FigureSize& size = {});

/// Values of an axis at 1, 2 or 5 times a power of ten, at most `most` of them inside of [low, high].
std::vector<double> axis_ticks(double low, double high, int most);

}  // namespace kalfem
