# SPDX-License-Identifier: Apache-2.0
"""An unscented Kalman filter as it is commonly written in Python: NumPy, one call of the model for each sigma point.

It estimates what kalfem does on the chain of examples/chain: 11 degrees of freedom, two unknown parameters, 24 states. It
is the comparison of python_overhead.py; the package FilterPy, which is written like that, is not in Debian.
"""

import numpy as np


class PlainUKF:
    """Scaled sigma points, additive noise: x' = f(x, u), y = h(x, u)."""

    def __init__(self, f, h, mean, covariance, process_noise, noise):
        self.f, self.h, self.x, self.P, self.Q, self.R = f, h, mean, covariance, process_noise, noise
        n = len(mean)
        alpha, beta, kappa = 1.0, 2.0, 0.0
        self.spread = alpha**2 * (n + kappa)
        self.Wm = np.full(2 * n + 1, 0.5 / self.spread)
        self.Wc = self.Wm.copy()
        self.Wm[0] = 1 - n / self.spread
        self.Wc[0] = self.Wm[0] + 1 - alpha**2 + beta

    def sigma_points(self):
        root = np.linalg.cholesky(self.spread * self.P)
        return np.vstack([self.x, self.x + root.T, self.x - root.T])

    def predict(self, u):
        points = np.array([self.f(point, u) for point in self.sigma_points()])
        self.x = self.Wm @ points
        d = points - self.x
        self.P = d.T @ (self.Wc[:, None] * d) + self.Q

    def update(self, y, u):
        points = self.sigma_points()
        outputs = np.array([self.h(point, u) for point in points])
        mean = self.Wm @ outputs
        d = outputs - mean
        S = d.T @ (self.Wc[:, None] * d) + self.R
        K = np.linalg.solve(S, d.T @ (self.Wc[:, None] * (points - self.x))).T
        self.x = self.x + K @ (y - mean)
        self.P = self.P - K @ S @ K.T
        self.P = 0.5 * (self.P + self.P.T)


class Chain:
    """The chain as functions of the state [z; z'; ln mu_k1; ln mu_c1]; classical Runge-Kutta over a sample."""

    def __init__(self, step):
        self.step = step
        k = np.zeros((11, 11))
        k[0, 0] = 20e3
        for i in range(1, 10):
            k[i : i + 2, i : i + 2] += 30e3 * np.array([[1, -1], [-1, 1]])
        self.K = k
        body = k[1:, 1:]
        values, shapes = np.linalg.eigh(body)
        c = np.zeros((11, 11))
        c[1:, 1:] = shapes @ np.diag(2 * 0.01 * np.sqrt(np.maximum(values, 0))) @ shapes.T
        self.C = c
        self.mass = np.array([1.5] + [1.0] * 10)

    def acceleration(self, z, v, mu, road):
        d, r = z[1] - z[0], v[1] - v[0]
        force = 5e3 * d + mu[0] * d / (2e-3 + abs(d)) + 10 * r + mu[1] * r / (0.05 + abs(r))
        load = -self.K @ z - self.C @ v
        load[0] += 20e3 * road + force
        load[1] -= force
        return load / self.mass

    def slope(self, x, road):
        z, v = x[:11], x[11:22]
        return np.concatenate([v, self.acceleration(z, v, np.exp(x[22:]), road), [0.0, 0.0]])

    def f(self, x, u):
        h, (before, now) = self.step, u
        middle = 0.5 * (before + now)
        a = self.slope(x, before)
        b = self.slope(x + 0.5 * h * a, middle)
        c = self.slope(x + 0.5 * h * b, middle)
        d = self.slope(x + h * c, now)
        return x + h / 6 * (a + 2 * b + 2 * c + d)

    def h(self, x, u):
        return self.acceleration(x[:11], x[11:22], np.exp(x[22:]), u[1])[[2, 4, 6, 10]]


def chain_filter(rate, noise):
    """The filter of the chain from rest, mu_k1 = 10 N and mu_c1 = 16 N, known within 50 %."""
    chain = Chain(1 / rate)
    mean = np.concatenate([np.zeros(22), np.log([10.0, 16.0])])
    covariance = np.diag([1e-14] * 22 + [0.25, 0.25])
    return PlainUKF(chain.f, chain.h, mean, covariance, np.diag([1e-16] * 22 + [0.0, 0.0]), noise**2 * np.eye(4))
