// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>

namespace kalfem {

/// Second derivatives M of the cubic not-a-knot spline through equidistant samples y, the interval taken as 1:
///     M_{i-1} + 4 M_i + M_{i+1} = 6 (y_{i-1} - 2 y_i + y_{i+1}),     M_0 = 2 M_1 - M_2,   M_{N-1} = 2 M_{N-2} -
///     M_{N-3}.
/// The end conditions turn the first and last equation into M_1 = y_0 - 2 y_1 + y_2 and its mirror image, so what is
/// left is a tridiagonal system between known values. Fewer than four samples: the parabola or line through them.
/// Source: de Boor, A Practical Guide to Splines (1978), chapter IV.
Eigen::VectorXd not_a_knot_curvature(const Eigen::Ref<const Eigen::VectorXd>& y);

/// The same where M_0 is known, as that of a spline which comes from earlier samples: size of y, two or more.
Eigen::VectorXd continued_curvature(const Eigen::Ref<const Eigen::VectorXd>& y, double first);

/// Value, slope and curvature of the cubic between two samples (values y, second derivatives M) at x in [0, 1].
std::array<double, 3> spline_segment(double y0, double y1, double M0, double M1, double x);

/// Integral of its value from 0 to x.
double spline_integral(double y0, double y1, double M0, double M1, double x);

/// Value, slope and curvature at x of the polynomial of the fifth degree with these at x = 0 and at x = 1.
std::array<double, 3> hermite_segment(const std::array<double, 3>& begin, const std::array<double, 3>& end, double x);

}  // namespace kalfem
