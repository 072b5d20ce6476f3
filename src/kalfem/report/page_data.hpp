#pragma once

#include <string>

#include "kalfem/report/page.hpp"

namespace kalfem {

/// The charts of a page, in the order of their appearance, as a JSON array that may stand inside a script element:
/// thinned to about `report_points` rows, gaps as null, "<", ">" and "&" escaped.
std::string charts_as_json(const Page& page);

}  // namespace kalfem
