// SPDX-License-Identifier: Apache-2.0
#include <type_traits>

#include "kalfem/system/laws/expression_kernel_shapes.hpp"

namespace kalfem {
namespace {

using enum TapeOperation;

/// x as it is read in a form.
template <OperandForm form, class Points>
[[gnu::always_inline]] inline void read_as(Points& y, const Points& x) {
  const Points zero{}, one = zero + 1.0;
  if constexpr (form == OperandForm::plain) {
    y = x;
  } else if constexpr (form == OperandForm::square) {
    y = x * x;
  } else if constexpr (form == OperandForm::cube) {
    y = x * x * x;
  } else if constexpr (form == OperandForm::cube_slope) {
    y = 3.0 * (x * x);
  } else if constexpr (form == OperandForm::magnitude) {
    y = x > zero ? x : zero - x;
  } else {
    y = x > zero ? one : zero;
    y = x < zero ? -one : y;
  }
}

template <OperandForm form>
TapeKernel kernel_in_form(TapeOperation operation) {
  switch (operation) {
    case add:
      return binary([](auto& y, const auto& a, const auto& b) {
        read_as<form>(y, b);
        y = a + y;
      });
    case inverse_of_sum:
      return binary([](auto& y, const auto& a, const auto& b) {
        read_as<form>(y, b);
        y = 1.0 / (a + y);
      });
    case multiply:
      return binary([](auto& y, const auto& a, const auto& b) {
        read_as<form>(y, b);
        y = a * y;
      });
    case multiply_add:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) {
        read_as<form>(y, c);
        y = a + b * y;
      });
    case subtract_product:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) {
        read_as<form>(y, c);
        y = a - b * y;
      });
    case multiply_three:
      return ternary([](auto& y, const auto& a, const auto& b, const auto& c) {
        read_as<form>(y, c);
        y = a * b * y;
      });
    case multiply_three_add:
      return quaternary([](auto& y, const auto& a, const auto& b, const auto& c, const auto& d) {
        read_as<form>(y, d);
        y = a + b * c * y;
      });
    case subtract_three:
      return quaternary([](auto& y, const auto& a, const auto& b, const auto& c, const auto& d) {
        read_as<form>(y, d);
        y = a - b * c * y;
      });
    case sum_of_products:
      return quaternary([](auto& y, const auto& a, const auto& b, const auto& c, const auto& d) {
        read_as<form>(y, d);
        y = a * b + c * y;
      });
    default:
      return nullptr;
  }
}

}  // namespace

TapeKernel kernel_of(TapeOperation operation, OperandForm form) {
  switch (form) {
    case OperandForm::plain:
      return kernel_in_form<OperandForm::plain>(operation);
    case OperandForm::square:
      return kernel_in_form<OperandForm::square>(operation);
    case OperandForm::cube:
      return kernel_in_form<OperandForm::cube>(operation);
    case OperandForm::cube_slope:
      return kernel_in_form<OperandForm::cube_slope>(operation);
    case OperandForm::magnitude:
      return kernel_in_form<OperandForm::magnitude>(operation);
    default:
      return kernel_in_form<OperandForm::sign>(operation);
  }
}

}  // namespace kalfem
