// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {

/// Adds slider i, a spring behind friction (Jenkins element), to the force of a law whose states are the slips of its
/// sliders. It slips where the stretch of its spring would exceed `limit` [m], by its exact return map.
template <std::size_t parameter_count, std::size_t state_count>
void add_slider(const KernelInput<parameter_count, state_count>& in, std::size_t i, double stiffness, double limit,
                KernelOutput<state_count>& out) {
  const double stretch = in.d - in.s[i], slipping = std::abs(stretch) > limit ? 1.0 : 0.0;
  const double held = slipping > 0.0 ? std::copysign(limit, stretch) : stretch;
  out.force += stiffness * held;
  out.stiffness += (1.0 - slipping) * stiffness;
  out.s[i] = in.duration > 0.0 ? in.d - held : in.s[i];
}

/// The states "slip_1", "slip_2", ... of so many sliders.
inline std::vector<LawQuantity> slips_of(std::size_t sliders) {
  std::vector<LawQuantity> states;
  for (std::size_t i = 0; i < sliders; ++i)
    states.push_back({fmt::format("slip_{}", i + 1), "m", "displacement of a slider"});
  return states;
}

}  // namespace kalfem
