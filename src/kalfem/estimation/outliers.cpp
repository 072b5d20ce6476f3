// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/outliers.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

double outlier_weight(const OutlierOptions& options, double e) {
  switch (options.treatment) {
    case OutlierTreatment::keep:
      break;
    case OutlierTreatment::gate:
      return std::abs(e) > options.limit ? 0.0 : 1.0;
    case OutlierTreatment::robust: {
      const double nu = options.degrees_of_freedom;
      return std::min(1.0, (nu + 1.0) / (nu + e * e));
    }
  }
  return 1.0;
}

}  // namespace kalfem
