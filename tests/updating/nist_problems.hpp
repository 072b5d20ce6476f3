// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "updating/function_residual.hpp"

// Nonlinear regressions with certified results to eleven digits from the Statistical Reference Datasets of the National
// Institute of Standards and Technology (public domain).

namespace kalfem {

struct NistProblem {
  std::string name;
  FunctionResidual residual;
  std::array<Eigen::VectorXd, 2> starts;
  Eigen::VectorXd certified, certified_deviations;
  double sum_of_squares;
};

namespace nist {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

inline VectorXd vector(std::initializer_list<double> values) {
  return Eigen::Map<const VectorXd>(values.begin(), static_cast<Index>(values.size()));
}

/// A residual of pairs y, x and a model that gives its value at all x and its derivatives, a column a parameter.
template <class Model>
FunctionResidual regression(std::initializer_list<double> pairs, Model model) {
  const Eigen::Map<const Eigen::Array2Xd> data(pairs.begin(), 2, static_cast<Index>(pairs.size() / 2));
  const ArrayXd y = data.row(0), x = data.row(1);
  return {y.size(), [=](const VectorXd& b) {
            ResidualValue value{VectorXd(y.size()), Eigen::MatrixXd(y.size(), b.size())};
            value.values = (model(x, b, value.jacobian) - y).matrix();
            return value;
          }};
}

/// y = b1 (1 - exp(-b2 x)), adsorption of a monomolecular layer.
inline NistProblem misra1a() {
  const auto model = [](const ArrayXd& x, const VectorXd& b, Eigen::MatrixXd& jacobian) -> ArrayXd {
    const ArrayXd decay = (-b[1] * x).exp();
    jacobian.col(0) = 1.0 - decay;
    jacobian.col(1) = b[0] * x * decay;
    return b[0] * (1.0 - decay);
  };
  return {"Misra1a",
          regression({10.07, 77.6,  14.73, 114.9, 17.94, 141.1, 23.93, 190.8, 29.61, 239.9, 35.18, 289.0, 40.02, 332.8,
                      44.82, 378.4, 50.76, 434.8, 55.05, 477.3, 61.01, 536.8, 66.40, 593.1, 75.47, 689.1, 81.78, 760.0},
                     model),
          {vector({500, 0.0001}), vector({250, 0.0005})},
          vector({2.3894212918E+02, 5.5015643181E-04}),
          vector({2.7070075241E+00, 7.2668688436E-06}),
          1.2455138894E-01};
}

/// y = b1 / b2 exp(-((x - b3) / b2)^2 / 2), a peak of transmittance.
inline NistProblem eckerle4() {
  const auto model = [](const ArrayXd& x, const VectorXd& b, Eigen::MatrixXd& jacobian) -> ArrayXd {
    const ArrayXd u = (x - b[2]) / b[1], bell = (-0.5 * u * u).exp();
    jacobian.col(0) = bell / b[1];
    jacobian.col(1) = b[0] / (b[1] * b[1]) * bell * (u * u - 1.0);
    jacobian.col(2) = b[0] / (b[1] * b[1]) * bell * u;
    return b[0] / b[1] * bell;
  };
  return {"Eckerle4",
          regression({0.0001575, 400.0, 0.0001699, 405.0, 0.0002350, 410.0, 0.0003102, 415.0, 0.0004917, 420.0,
                      0.0008710, 425.0, 0.0017418, 430.0, 0.0046400, 435.0, 0.0065895, 436.5, 0.0097302, 438.0,
                      0.0149002, 439.5, 0.0237310, 441.0, 0.0401683, 442.5, 0.0712559, 444.0, 0.1264458, 445.5,
                      0.2073413, 447.0, 0.2902366, 448.5, 0.3445623, 450.0, 0.3698049, 451.5, 0.3668534, 453.0,
                      0.3106727, 454.5, 0.2078154, 456.0, 0.1164354, 457.5, 0.0616764, 459.0, 0.0337200, 460.5,
                      0.0194023, 462.0, 0.0117831, 463.5, 0.0074357, 465.0, 0.0022732, 470.0, 0.0008800, 475.0,
                      0.0004579, 480.0, 0.0002345, 485.0, 0.0001586, 490.0, 0.0001143, 495.0, 0.0000710, 500.0},
                     model),
          {vector({1, 10, 500}), vector({1.5, 5, 450})},
          vector({1.5543827178E+00, 4.0888321754E+00, 4.5154121844E+02}),
          vector({1.5408051163E-02, 4.6803020753E-02, 4.6800518816E-02}),
          1.4635887487E-03};
}

/// y = b1 (x^2 + x b2) / (x^2 + x b3 + b4), with a minimum at infinity too.
inline NistProblem mgh09() {
  const auto model = [](const ArrayXd& x, const VectorXd& b, Eigen::MatrixXd& jacobian) -> ArrayXd {
    const ArrayXd top = x * x + b[1] * x, bottom = x * x + b[2] * x + b[3];
    jacobian.col(0) = top / bottom;
    jacobian.col(1) = b[0] * x / bottom;
    jacobian.col(2) = -b[0] * top * x / (bottom * bottom);
    jacobian.col(3) = -b[0] * top / (bottom * bottom);
    return b[0] * top / bottom;
  };
  return {"MGH09",
          regression({1.957e-01, 4.0,    1.947e-01, 2.0,    1.735e-01, 1.0,   1.600e-01, 0.5,
                      8.440e-02, 0.25,   6.270e-02, 0.167,  4.560e-02, 0.125, 3.420e-02, 0.1,
                      3.230e-02, 0.0833, 2.350e-02, 0.0714, 2.460e-02, 0.0625},
                     model),
          {vector({25, 39, 41.5, 39}), vector({0.25, 0.39, 0.415, 0.39})},
          vector({1.9280693458E-01, 1.9128232873E-01, 1.2305650693E-01, 1.3606233068E-01}),
          vector({1.1435312227E-02, 1.9633220911E-01, 8.0842031232E-02, 9.0025542308E-02}),
          3.0750560385E-04};
}

/// y = cubic / cubic, the mobility of electrons: seven parameters that act nearly alike.
inline NistProblem thurber() {
  const auto model = [](const ArrayXd& x, const VectorXd& b, Eigen::MatrixXd& jacobian) -> ArrayXd {
    const ArrayXd top = b[0] + x * (b[1] + x * (b[2] + x * b[3]));
    const ArrayXd bottom = 1.0 + x * (b[4] + x * (b[5] + x * b[6]));
    for (int i = 0; i < 4; ++i) jacobian.col(i) = x.pow(i) / bottom;
    for (int i = 1; i < 4; ++i) jacobian.col(3 + i) = -top * x.pow(i) / (bottom * bottom);
    return top / bottom;
  };
  return {"Thurber",
          regression({80.574,   -3.067, 84.248,   -2.981, 87.264,   -2.921, 87.195,   -2.912, 89.076,   -2.840,
                      89.608,   -2.797, 89.868,   -2.702, 90.101,   -2.699, 92.405,   -2.633, 95.854,   -2.481,
                      100.696,  -2.363, 101.060,  -2.322, 401.672,  -1.501, 390.724,  -1.460, 567.534,  -1.274,
                      635.316,  -1.212, 733.054,  -1.100, 759.087,  -1.046, 894.206,  -0.915, 990.785,  -0.714,
                      1090.109, -0.566, 1080.914, -0.545, 1122.643, -0.400, 1178.351, -0.309, 1260.531, -0.109,
                      1273.514, -0.103, 1288.339, 0.010,  1327.543, 0.119,  1353.863, 0.377,  1414.509, 0.790,
                      1425.208, 0.963,  1421.384, 1.006,  1442.962, 1.115,  1464.350, 1.572,  1468.705, 1.841,
                      1447.894, 2.047,  1457.628, 2.200},
                     model),
          {vector({1000, 1000, 400, 40, 0.7, 0.3, 0.03}), vector({1300, 1500, 500, 75, 1, 0.4, 0.05})},
          vector({1.2881396800E+03, 1.4910792535E+03, 5.8323836877E+02, 7.5416644291E+01, 9.6629502864E-01,
                  3.9797285797E-01, 4.9727297349E-02}),
          vector({4.6647963344E+00, 3.9571156086E+01, 2.8698696102E+01, 5.5675370270E+00, 3.1333340687E-02,
                  1.4984928198E-02, 6.5842344623E-03}),
          5.6427082397E+03};
}

}  // namespace nist

inline std::vector<NistProblem> nist_problems() {
  return {nist::misra1a(), nist::eckerle4(), nist::mgh09(), nist::thurber()};
}

}  // namespace kalfem
