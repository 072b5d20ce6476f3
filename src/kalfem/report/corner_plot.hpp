// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/pipeline/inference_outcome.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Parameters that are drawn: all of up to `most`, otherwise those with the strongest correlations, in their order.
std::vector<Eigen::Index> drawn_parameters(const InferenceOutcome& outcome, std::size_t most);

/// Values of an axis at 1, 2 or 5 times a power of ten, at most `most` of them inside of [low, high].
std::vector<double> axis_ticks(double low, double high, int most);

/// A posterior pair by pair: marginal densities with the prior, the mean and the truth on the diagonal, draws with
/// contours of 50 and 95 % below it, correlations above it. Of more than eight parameters the eight with the strongest
/// correlations. One SVG element in the colours of the page, light and dark. Nothing without finite samples.
std::optional<Picture> corner_plot(const InferenceOutcome& outcome);

}  // namespace kalfem
