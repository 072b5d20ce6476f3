// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/gauges/gauge_description.hpp"
#include "kalfem/model/gauges/strain_gauge.hpp"

namespace kalfem {

/// The element under a gauge. A place takes the nearest element; where several meet, the first of the mesh. Throws
/// InvalidInput where the element or region does not exist, the place is farther from the elements than their size or
/// on a fold of shells, and where direction, surface or fibre do not suit the element.
StrainGauge place_gauge(const FiniteElementModel& model, const GaugeDescription& given);

}  // namespace kalfem
