// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/vector_loops.hpp"
#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// What a pointwise kernel reads: one row of LawPoints with P parameters and S states.
template <std::size_t P, std::size_t S = 0>
struct KernelInput {
  std::array<double, P> p;              ///< parameters
  double d = 0.0, v = 0.0, a = 0.0;     ///< d(h), d'(h), d''(h)
  double duration = 0.0;                ///< h [s]
  double begin_d = 0.0, begin_v = 0.0;  ///< d(0), d'(0)
  std::array<double, S> s;              ///< s(0)
};

/// What a pointwise kernel answers: one row of LawResponse.
template <std::size_t S = 0>
struct KernelOutput {
  double force = 0.0, stiffness = 0.0, damping = 0.0, inertance = 0.0;
  std::array<double, S> s;  ///< s(h)
};

/// Makes a ConnectorLaw of a kernel, a callable
/// @code
///     KernelOutput<S> operator()(const KernelInput<P, S>&) const
/// @endcode
/// with constants `parameter_count` = P and `state_count` = S, and where they are true
///     uses_acceleration   the force depends on d'' (left out: it does not, and the kernel does not read `a`),
///     has_branches        the kernel branches or calls library functions.
/// The loop over the points is inlined around the kernel; without branches it is vectorised over the points.
template <class Kernel>
class PointwiseLaw final : public ConnectorLaw {
public:
  static constexpr std::size_t P = Kernel::parameter_count, S = Kernel::state_count;

  PointwiseLaw(std::string name, std::vector<LawQuantity> parameters, std::vector<LawQuantity> states = {},
               Kernel kernel = {})
      : name_(std::move(name)),
        parameters_(std::move(parameters)),
        states_(std::move(states)),
        kernel_(std::move(kernel)) {
    assert(parameters_.size() == P && states_.size() == S);
  }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }

  [[nodiscard]] bool uses_acceleration() const override {
    if constexpr (requires { Kernel::uses_acceleration; })
      return Kernel::uses_acceleration;
    else
      return false;
  }
  [[nodiscard]] bool vectorised() const override {
    if constexpr (requires { Kernel::has_branches; })
      return !Kernel::has_branches;
    else
      return true;
  }

  void respond(const LawPoints& points, LawResponse response) const override {
    assert(points.parameters.cols() == static_cast<Eigen::Index>(P));
    in_widest_registers([&]() KALFEM_INLINE {
      evaluate(points, response, std::make_index_sequence<P>{}, std::make_index_sequence<S>{});
    });
  }

private:
  template <std::size_t... j, std::size_t... m>
  KALFEM_INLINE void evaluate(const LawPoints& in, LawResponse& out, std::index_sequence<j...>,
                              std::index_sequence<m...>) const {
    const double* p = in.parameters.data();
    const double* s = in.begin_states.data();
    double* s_end = out.states.data();
    const Eigen::Index p_stride = in.parameters.outerStride(), s_stride = in.begin_states.outerStride(),
                       s_end_stride = out.states.outerStride(), count = in.deformation.size();
    const double *begin_d = in.begin_deformation.data(), *begin_v = in.begin_rate.data(), *d = in.deformation.data(),
                 *v = in.rate.data(), *a = in.acceleration.data();
    double *force = out.force.data(), *stiffness = out.stiffness.data(), *damping = out.damping.data(),
           *inertance = out.inertance.data();
    const double duration = in.duration;
    const Kernel kernel = kernel_;  // a copy of its own cannot alias the outputs
    KALFEM_INDEPENDENT
    for (Eigen::Index i = 0; i < count; ++i) {
      const KernelOutput<S> answer =
          kernel(KernelInput<P, S>{.p = {p[i + static_cast<Eigen::Index>(j) * p_stride]...},
                                   .d = d[i],
                                   .v = v[i],
                                   .a = a[i],
                                   .duration = duration,
                                   .begin_d = begin_d[i],
                                   .begin_v = begin_v[i],
                                   .s = {s[i + static_cast<Eigen::Index>(m) * s_stride]...}});
      force[i] = answer.force;
      stiffness[i] = answer.stiffness;
      damping[i] = answer.damping;
      inertance[i] = answer.inertance;
      ((s_end[i + static_cast<Eigen::Index>(m) * s_end_stride] = answer.s[m]), ...);
    }
  }

  std::string name_;
  std::vector<LawQuantity> parameters_, states_;
  Kernel kernel_;
};

}  // namespace kalfem
