// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_kernels.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>

#include "kalfem/system/laws/expression_kernel_shapes.hpp"

namespace kalfem {
namespace {

using enum TapeOperation;
using Count = std::ptrdiff_t;

/// A function of the standard library, point by point.
template <class Function>
constexpr TapeKernel pointwise(Function) {
  return [](const Instruction* at, double* const* table, Count count) {
    double* out = column(table, at->out);
    const double* a = column(table, at->a);
    for (Count i = 0; i < count; ++i) out[i] = Function{}(a[i]);
    at[1].kernel(at + 1, table, count);
  };
}

/// A comparison, which chooses between `yes` = 1 and `no` = 0.
template <class Comparison>
TapeKernel truth(Comparison) {
  return binary([](auto& y, const auto& a, const auto& b) {
    const std::decay_t<decltype(y)> no{}, yes = no + 1.0;
    Comparison{}(y, a, b, yes, no);
  });
}

constexpr int largest_whole_exponent = 16;

/// The exponent, if all points have the same and it is a small whole number.
bool shares_whole_exponent(const double* exponents, Count count, int& exponent) {
  const double first = exponents[0];
  if (!(std::abs(first) <= largest_whole_exponent)) return false;
  exponent = static_cast<int>(first);
  const auto others = static_cast<std::size_t>(count - 1) * sizeof(double);
  return exponent == first && std::memcmp(exponents, exponents + 1, others) == 0;
}

/// factor a^exponent by multiplications.
template <class Points>
[[gnu::always_inline]] inline void raise(Points& y, const Points& a, int exponent, double factor) {
  const Points one = Points{} + 1.0;
  Points result = one, square_of_square = a;
  for (int left = std::abs(exponent); left != 0; left >>= 1) {
    if ((left & 1) != 0) result = result * square_of_square;
    square_of_square = square_of_square * square_of_square;
  }
  y = factor * (exponent < 0 ? one / result : result);
}

void whole_power(double* out, const double* a, int exponent, double factor, Count count) {
  const auto by = [&](auto compute) { in_widest_registers([&]() KALFEM_INLINE { for_all(compute, count, out, a); }); };
  switch (exponent) {
    case 0:
      return by([=](auto& y, const auto&) { y = std::decay_t<decltype(y)>{} + factor; });
    case 1:
      return by([=](auto& y, const auto& x) { y = factor * x; });
    case 2:
      return by([=](auto& y, const auto& x) { y = factor * (x * x); });
    case 3:
      return by([=](auto& y, const auto& x) { y = factor * (x * x * x); });
    default:
      return by([=](auto& y, const auto& x) { raise(y, x, exponent, factor); });
  }
}

/// a^b
void power_kernel(const Instruction* at, double* const* table, Count count) {
  double* out = column(table, at->out);
  const double *a = column(table, at->a), *b = column(table, at->b);
  if (int exponent = 0; shares_whole_exponent(b, count, exponent)) {
    whole_power(out, a, exponent, 1.0, count);
  } else {
    for (Count i = 0; i < count; ++i) out[i] = std::pow(a[i], b[i]);
  }
  at[1].kernel(at + 1, table, count);
}

/// b a^(b - 1), from y = a^b where that can be divided by a.
void power_slope_kernel(const Instruction* at, double* const* table, Count count) {
  double* out = column(table, at->out);
  const double *a = column(table, at->a), *b = column(table, at->b), *y = column(table, at->c);
  if (int exponent = 0; shares_whole_exponent(b, count, exponent)) {
    whole_power(out, a, exponent == 0 ? 0 : exponent - 1, exponent, count);
  } else {
    for (Count i = 0; i < count; ++i) {
      if (std::isnormal(y[i]) && std::isnormal(a[i]))
        out[i] = b[i] * (y[i] / a[i]);
      else
        out[i] = b[i] == 0.0 ? 0.0 : b[i] * std::pow(a[i], b[i] - 1.0);
    }
  }
  at[1].kernel(at + 1, table, count);
}

void arctangent_2_kernel(const Instruction* at, double* const* table, Count count) {
  double* out = column(table, at->out);
  const double *a = column(table, at->a), *b = column(table, at->b);
  for (Count i = 0; i < count; ++i) out[i] = std::atan2(a[i], b[i]);
  at[1].kernel(at + 1, table, count);
}

constexpr auto product_where_nonzero = [](auto& y, const auto& a, const auto& b) {
  const std::decay_t<decltype(y)> zero{};
  y = a == zero ? zero : a * b;
};

TapeKernel arithmetic(TapeOperation operation) {
  switch (operation) {
    case add:
      return binary([](auto& y, const auto& a, const auto& b) { y = a + b; });
    case subtract:
      return binary([](auto& y, const auto& a, const auto& b) { y = a - b; });
    case multiply:
      return binary([](auto& y, const auto& a, const auto& b) { y = a * b; });
    case divide:
      return binary([](auto& y, const auto& a, const auto& b) { y = a / b; });
    case multiply_subtract:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) { y = a * b - c; });
    case difference_of_products:
      return quaternary([](auto& y, const auto& a, const auto& b, const auto& c, const auto& d) { y = a * b - c * d; });
    case guarded_multiply:
      return binary(product_where_nonzero);
    case guarded_multiply_add:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) {
        product_where_nonzero(y, b, c);
        y = a + y;
      });
    case guarded_subtract_product:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) {
        product_where_nonzero(y, b, c);
        y = a - y;
      });
    case negate:
      return unary([](auto& y, const auto& a) { y = -a; });
    case square:
      return unary([](auto& y, const auto& a) { y = a * a; });
    case cube:
      return unary([](auto& y, const auto& a) { y = a * a * a; });
    case cube_slope:
      return unary([](auto& y, const auto& a) { y = 3.0 * (a * a); });
    case copy:
      return unary([](auto& y, const auto& a) { y = a; });
    default:
      return nullptr;
  }
}

TapeKernel choice(TapeOperation operation) {
  switch (operation) {
    case minimum:
      return binary([](auto& y, const auto& a, const auto& b) { y = b < a ? b : a; });
    case maximum:
      return binary([](auto& y, const auto& a, const auto& b) { y = a < b ? b : a; });
    case less:
      return truth(
          [](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) { y = a < b ? yes : no; });
    case less_equal:
      return truth(
          [](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) { y = a <= b ? yes : no; });
    case greater:
      return truth(
          [](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) { y = a > b ? yes : no; });
    case greater_equal:
      return truth(
          [](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) { y = a >= b ? yes : no; });
    case equal:
      return truth(
          [](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) { y = a == b ? yes : no; });
    case not_equal:
      return truth(
          [](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) { y = a != b ? yes : no; });
    case both:
      return truth([](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) {
        y = ((a != no) & (b != no)) ? yes : no;
      });
    case either:
      return truth([](auto& y, const auto& a, const auto& b, const auto& yes, const auto& no) {
        y = ((a != no) | (b != no)) ? yes : no;
      });
    case select:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) {
        const std::decay_t<decltype(y)> zero{};
        y = a != zero ? b : c;
      });
    case absolute:
      return unary([](auto& y, const auto& a) {
        const std::decay_t<decltype(y)> zero{};
        y = a > zero ? a : zero - a;  // not -a, which would make 0 of the other sign
      });
    case sign:
      return unary([](auto& y, const auto& a) {
        const std::decay_t<decltype(y)> zero{}, one = zero + 1.0;
        y = a > zero ? one : zero;
        y = a < zero ? -one : y;
      });
    case power:
      return power_kernel;
    case power_slope:
      return power_slope_kernel;
    default:
      return nullptr;
  }
}

TapeKernel function(TapeOperation operation) {
  switch (operation) {
    case round:
      return pointwise([](double x) { return std::floor(x + 0.5); });
    case square_root:
      return pointwise([](double x) { return std::sqrt(x); });
    case exponential:
      return pointwise([](double x) { return std::exp(x); });
    case logarithm:
      return pointwise([](double x) { return std::log(x); });
    case logarithm_2:
      return pointwise([](double x) { return std::log2(x); });
    case logarithm_10:
      return pointwise([](double x) { return std::log10(x); });
    case sine:
      return pointwise([](double x) { return std::sin(x); });
    case cosine:
      return pointwise([](double x) { return std::cos(x); });
    case tangent:
      return pointwise([](double x) { return std::tan(x); });
    case arcsine:
      return pointwise([](double x) { return std::asin(x); });
    case arccosine:
      return pointwise([](double x) { return std::acos(x); });
    case arctangent:
      return pointwise([](double x) { return std::atan(x); });
    case hyperbolic_sine:
      return pointwise([](double x) { return std::sinh(x); });
    case hyperbolic_cosine:
      return pointwise([](double x) { return std::cosh(x); });
    case hyperbolic_tangent:
      return pointwise([](double x) { return std::tanh(x); });
    case area_sine:
      return pointwise([](double x) { return std::asinh(x); });
    case area_cosine:
      return pointwise([](double x) { return std::acosh(x); });
    case area_tangent:
      return pointwise([](double x) { return std::atanh(x); });
    case arctangent_2:
      return arctangent_2_kernel;
    default:
      return [](const Instruction*, double* const*, Count) {};
  }
}

}  // namespace

TapeKernel kernel_of(TapeOperation operation) {
  if (const auto kernel = arithmetic(operation)) return kernel;
  if (const auto kernel = choice(operation)) return kernel;
  if (const auto kernel = kernel_of(operation, OperandForm::plain)) return kernel;
  return function(operation);
}

double compute(TapeOperation operation, double a, double b, double c) {
  double result = 0.0;
  double* const table[] = {&result, &a, &b, &c};
  const Instruction steps[] = {{kernel_of(operation), {0, 0}, {1, 0}, {2, 0}, {3, 0}, {}},
                               {kernel_of(finish), {}, {}, {}, {}, {}}};
  steps[0].kernel(steps, table, 1);
  return result;
}

}  // namespace kalfem
