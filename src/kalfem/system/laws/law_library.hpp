// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/connector_law.hpp"
#include "kalfem/system/laws/expression_law.hpp"

namespace kalfem {

/// Spring and dashpot, f = k d + c v. Parameters k [N/m], c [N s/m].
ConnectorLawPtr linear_law();

/// Inerter, f = b a: a force in proportion to the relative acceleration. Parameter b [kg].
ConnectorLawPtr inerter_law();

/// Constant force, f = f0: gravity or a static preload in a strut, which may be unknown. Parameter f0 [N].
ConnectorLawPtr preload_law();

/// Values that the linear part of the system already holds at the connector's place.
struct LinearNominal {
  double stiffness = 0.0;  ///< k_nominal [N/m]
  double damping = 0.0;    ///< c_nominal [N s/m]
  double inertance = 0.0;  ///< b_nominal [kg]
};

/// Departure of a spring, dashpot or mass of the linear part from its nominal value,
///     f = (k - k_nominal) d + (c - c_nominal) v + (b - b_nominal) a,
/// so that it can be an unknown of an otherwise linear part. Parameters k [N/m], c [N s/m], b [kg]; each defaults to
/// its nominal value, which is no force. Throws InvalidInput where a nominal value is negative or not finite.
ConnectorLawPtr linear_change_law(const LinearNominal& nominal);

/// Hardening or softening spring and damper, f = k d + k3 d^3 + c v + c3 v^3.
/// Parameters k [N/m], k3 [N/m^3], c [N s/m], c3 [N s^3/m^3]; k3 and c3 may be negative.
ConnectorLawPtr cubic_law();

/// Polynomial spring and damper of any degree,
///     f = sum_{i=1..N} k_i d^i + sum_{i=1..M} c_i v^i,     N = stiffness_degree, M = damping_degree.
/// Parameters k1 .. kN [N/m^i], c1 .. cM [N (s/m)^i], all 0 unless given. Even terms make the force differ between
/// tension and compression. Throws InvalidInput unless both degrees lie in [0, 30] and one of them is positive.
ConnectorLawPtr polynomial_law(int stiffness_degree, int damping_degree);

/// Suspension whose spring and damper saturate, [TGDC17] eq. (4):
///     f = k d + mu_k1 d / (mu_k2 + |d|) + c v + mu_c1 v / (mu_c2 + |v|).
/// Parameters k [N/m], mu_k1 [N], mu_k2 [m], c [N s/m], mu_c1 [N], mu_c2 [m/s]. Well below mu_k2 only the slope
/// k + mu_k1 / mu_k2 shows; well above it the second term is a constant mu_k1, like friction.
ConnectorLawPtr saturating_law();

/// Regularised Coulomb friction with a spring and dashpot alongside,
///     f = k d + c v + f_c tanh(v / v_ref).
/// The hyperbolic tangent is smooth everywhere and reaches sliding friction to 1e-4 at 5 v_ref; the algebraic form
/// v / (v_ref + |v|), which nears it only as 1/v, is the saturating law's. Below v_ref it creeps instead of sticking:
/// where sticking matters use jenkins. Parameters f_c [N], v_ref [m/s], k [N/m], c [N s/m].
ConnectorLawPtr coulomb_law();

/// Friction that falls from static to sliding with the rate (Stribeck), regularised as in coulomb_law,
///     f = k d + c v + (f_c + (f_s - f_c) exp(-(v / v_s)^2)) tanh(v / v_ref).
/// The static force shows where v_ref is well below v_s. Parameters f_c [N], f_s [N], v_s [m/s], v_ref [m/s], k [N/m],
/// c [N s/m].
ConnectorLawPtr stribeck_law();

/// Spring and dashpot with a bump stop on one side or both,
///     f = k d + c v + r(d - gap_upper, v) - r(-d - gap_lower, -v),
///     r(o, w) = max(0, k_stop o + c_stop w) where the overlap o > 0, else 0:
/// the stop pushes and never pulls. At the first touch the force jumps by c_stop w; where a step ends there, the force
/// takes the value within the jump that holds the motion at the gap. What has no such jump is hunt_crossley_law.
/// Parameters k_stop [N/m], c_stop [N s/m], gap_upper [m], gap_lower [m], k [N/m],
/// c [N s/m]. An infinite gap (the default) is a side without a stop.
ConnectorLawPtr gap_law();

/// Spring and dashpot with a stop on one side or both whose damping grows with the overlap [HC75],
///     f = k d + c v + r(d - gap_upper, v) - r(-d - gap_lower, -v),
///     r(o, w) = k_stop o max(0, 1 + 3/2 a_stop w) where the overlap o > 0, else 0:
/// the force begins and ends at zero. For slow impacts 1 - a_stop v_i is the coefficient of restitution at the speed
/// v_i. Parameters k_stop [N/m], a_stop [s/m], gap_upper [m], gap_lower [m], k [N/m], c [N s/m]; the gaps
/// as in gap_law.
ConnectorLawPtr hunt_crossley_law();

/// Shock absorber that is another one in rebound (extension, v > 0) than in compression, and whose damping falls with
/// the rate (digressive) [Dix07],
///     f = k d + c_rebound v / (1 + v / v_rebound) for v > 0, k d + c_compression v / (1 - v / v_compression) else.
/// Parameters c_rebound, c_compression [N s/m], v_rebound, v_compression [m/s] (infinite, the default: linear),
/// k [N/m].
ConnectorLawPtr damper_law();

/// Jenkins element: a spring in series with a dry-friction slider, with a spring and dashpot alongside,
///     f = k d + c v + q,     q = k_stick (d - slip),     |q| <= f_slip,     slip' = 0 while |q| < f_slip.
/// The state is the slip [m], advanced by the exact return map (the path within a step is taken as monotone); no rate
/// is needed, so it truly sticks. Parameters k_stick [N/m], f_slip [N], k [N/m], c [N s/m].
ConnectorLawPtr jenkins_law();

/// Elastoplastic spring with linear kinematic hardening,
///     f = alpha k d + q + c v,     q = (1 - alpha) k (d - slip),     |q| <= (1 - alpha) f_y:
/// stiffness k up to the force f_y, alpha k beyond it; the elastic range stays 2 f_y wide. State and integration as in
/// jenkins_law. Parameters k [N/m], f_y [N], alpha [-], c [N s/m].
ConnectorLawPtr bilinear_law();

/// Smooth hysteresis of Bouc and Wen [Wen76],
///     f = alpha k d + (1 - alpha) k z + c v,     z' = A v - beta |v| |z|^(n-1) z - gamma v |z|^n,
/// with the hysteretic deformation z [m] as its state; it saturates at z_u = (A / (beta + gamma))^(1/n).
/// Parameters k [N/m], alpha [-], A [-], beta [1/m^n], gamma [1/m^n], n >= 1 [-], c [N s/m].
///
/// z' is proportional to the rate, so z follows the deformation: dz/dd = A - |z|^n (beta sgn(z dd) + gamma). Over an
/// interval this is integrated along d(h) - d(0) by the two-stage, second-order, L-stable diagonally implicit
/// Runge-Kutta method [Ale77]: any increment is safe and a large one lands on z_u. A reversal inside the interval costs
/// an error of second order. Where beta + gamma < 0 makes z run away within one interval, the root is continued
/// linearly (finite).
///
/// The form m y'' + c y' + k_L y + w = u, w' = a y' - b (g |y'| |w|^(n-1) w + e y' |w|^n) of the published benchmark
/// [NS16] is k = k_L + a, alpha = k_L / k, A = 1, beta = b g a^(n-1), gamma = b e a^(n-1), with w = a z.
ConnectorLawPtr bouc_wen_law();

/// The law of Bouc and Wen whose strength and stiffness fall with the dissipated energy [BN85] and whose loops are
/// pinched [Fol95], f = alpha k d + (1 - alpha) k z + c v with
///     z' = h (A v - nu (beta |v| |z|^(n-1) z + gamma v |z|^n)) / eta,     e' = z v,
///     nu = 1 + delta_nu e,     eta = 1 + delta_eta e,     h = 1 - zeta_1 exp(-(z sgn(v) - q z_u)^2 / zeta_2^2),
///     zeta_1 = zeta_s (1 - exp(-p e)),     zeta_2 = (psi + delta_psi e) (lambda + zeta_1),
///     z_u = (A / (nu (beta + gamma)))^(1/n).
/// States z [m] and e [m^2], the energy over (1 - alpha) k. With delta_nu, delta_eta and zeta_s zero, the default, it
/// is bouc_wen_law, integrated along time.
ConnectorLawPtr degrading_bouc_wen_law();

/// Iwan's joint with four parameters [Seg05]: sliders in parallel, those that slip at a deformation phi with the
/// density R phi^chi up to phi_max, and a spring S that slips there,
///     phi_max = f_s (1 + beta) / (k_t (beta + (chi + 1) / (chi + 2))).
/// The dissipation of a cycle of amplitude a < phi_max is 4 R a^(3+chi) / ((2 + chi) (3 + chi)). Twenty sliders over
/// three decades and the last one stand for the density; each is a Jenkins element with its exact return map.
/// Parameters f_s [N], k_t [N/m], chi in (-1, 0] [-], beta [-], k [N/m], c [N s/m].
ConnectorLawPtr iwan_law();

/// A spring and a dashpot in series (Maxwell) beside a spring and a dashpot, f = k d + c v + k_branch (d - z),
/// z' = (d - z) / tau. Several in parallel are a Prony series. Parameters k_branch [N/m], tau [s], k [N/m], c [N s/m].
ConnectorLawPtr maxwell_law();

/// A Prony series, as of rubber: Maxwell branches in parallel with a spring and a dashpot [Fer80],
///     f = k_inf d + c v + sum_i k_i (d - z_i),     z_i' = (d - z_i) / tau_i,     i = 1 .. branches,
/// of the complex stiffness k_inf + i w c + sum_i k_i i w tau_i / (1 + i w tau_i), and k_inf + sum_i k_i exp(-t /
/// tau_i) after a step. States z_i [m]. Parameters k_inf [N/m], c [N s/m], k1, tau1 .. [N/m, s]. Throws InvalidInput
/// unless there are 1 to 8 branches.
ConnectorLawPtr prony_law(int branches);

/// Hysteresis of Ramberg and Osgood [RO43] with Masing's rules [Mas26], as Jennings wrote it for structures [Jen64],
///     d = f/k (1 + alpha |f/f_y|^(r-1)) at first loading,
///     (d - d_0)/2 = (f - f_0)/(2 k) (1 + alpha |(f - f_0)/(2 f_y)|^(r-1)) after a reversal at (d_0, f_0),
/// until a branch meets an earlier one, which it then continues. A cycle of the force amplitude a dissipates
///     4 (r-1)/(r+1) alpha (f_y^2/k) (a/f_y)^(r+1).
/// Twenty sliders in parallel [Iwa67] hold Masing's rules and the stiffness at rest exactly, and the backbone
/// approximately: for r >= 2 and a plastic deformation of 0.01 to 20 times the elastic one, that deformation within 2 %
/// and the force within 1 %; the dissipation of a cycle within 5 %. Below that range the law is elastic, beyond it the
/// backbone is its tangent. No rate is needed; the states are the slips [m], each advanced by its exact return map (the
/// path within a step is taken as monotone).
/// Parameters k [N/m], f_y [N], alpha [-], r [-], c [N s/m]. Only alpha f_y^(1-r) acts: alpha is held, f_y is sought.
ConnectorLawPtr ramberg_osgood_law();

/// Friction by the deflection z of bristles [CdW95],
///     f = k d + sigma_0 z + sigma_1 z' + sigma_2 v,     z' = v - sigma_0 |v| z / g(v),
///     g(v) = f_c + (f_s - f_c) exp(-(v / v_s)^2).
/// Parameters sigma_0 [N/m], f_c [N], f_s [N], v_s [m/s], sigma_1 [N s/m], sigma_2 [N s/m], k [N/m].
ConnectorLawPtr lugre_law();

/// No force. It carries a signal of a law: its deformation is the signal, and it stands behind the law's connector, in
/// the order of ConnectorLaw::signals().
ConnectorLawPtr signal_law();
inline const std::string signal_law_name = "signal";

/// What some laws need beside their name; the other laws ignore it.
struct LawArguments {
  /// The parameters that are given. polynomial: k1 .. kN, c1 .. cM set the degrees; expression: its parameters, with
  /// the unit that each was given in, empty for a bare number.
  std::vector<LawQuantity> parameters = {};
  LinearNominal nominal = {};                ///< linear_change
  std::string force = {};                    ///< expression
  std::vector<ExpressionState> states = {};  ///< expression
  std::vector<LawQuantity> signals = {};     ///< expression
  std::vector<ExpressionLet> lets = {};      ///< expression
};

/// The law of that name, such as "saturating". Throws InvalidInput for an unknown name or unsuitable arguments.
ConnectorLawPtr make_law(const std::string& name, const LawArguments& arguments = {});

/// One entry of the schema. The parameters of polynomial and expression are examples.
struct LawDescription {
  std::string name;
  std::string equation;  ///< in one line of plain text
  std::string meaning;
  std::vector<LawQuantity> parameters;
  std::vector<LawQuantity> states;
};

/// Every law that make_law knows, in the order of a reference page.
std::vector<LawDescription> law_library();

/// Every value (in the order of law.parameters()) that is not finite or outside its range, or the one issue that their
/// number is wrong. Infinity passes where it is the default.
std::vector<Issue> validate_parameters(const ConnectorLaw& law, const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace kalfem
