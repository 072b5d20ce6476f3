#pragma once

#include "kalfem/report/page.hpp"

namespace kalfem {

/// Throws InvalidInput with everything that keeps a page from being drawn; see `render_html`.
void check(const Page& page);

}  // namespace kalfem
