#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""against_scipy.py [--defaults] MATERIAL: one material's fits against the same least squares in SciPy.

Both sides fit the same slices (18 theta_d x 3 colours x up to 90 theta_h), single-threaded, in turns:
the same residuals (vectorised in NumPy), from the same starts, to the same tolerances, by SciPy's
least_squares. SciPy at its best is MINPACK's Levenberg-Marquardt with analytic derivatives; with
--defaults it is what people get who pass residuals only (trust region, numerical derivatives). Prints
the median seconds and ratio over the rounds, and the costs, which must be alike for the ratio to mean
anything.

Needs Debian's python3-scipy, which nothing else of this project does.
"""
import json
import os
import subprocess
import sys
import time

for pool in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[pool] = "1"  # before NumPy is loaded

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares

LOG_KAPPA = (-14, 2.77)  # fitting/hemi_epd.h
LOG_GAMMA = (-4.6, 10.8)
VANISHED = -40
ROUNDS = 3
DEFAULTS = "--defaults" in sys.argv


def minimise(residuals, start, jacobian, **tolerances):
    if DEFAULTS:
        return least_squares(residuals, start, **tolerances)
    return least_squares(residuals, start, jacobian, method="lm", **tolerances)


def log_cos(theta_h):
    return np.log(np.maximum(np.cos(theta_h), 1e-9))


def lobe(log_kappa, log_gamma, at):
    """f_r of lobes, and its slopes by log kappa and log gamma; shapes broadcast."""
    kappa = np.exp(np.clip(log_kappa, *LOG_KAPPA))
    gamma = np.exp(np.clip(log_gamma, *LOG_GAMMA))
    exponent = gamma * at
    x = np.where(exponent > VANISHED, kappa * np.exp(np.maximum(exponent, VANISHED)), 0)
    rise = np.expm1(x)
    slope = (rise + 1) * x
    inside = lambda y, range: (y >= range[0]) & (y <= range[1])
    return rise, slope * inside(log_kappa, LOG_KAPPA), slope * exponent * inside(log_gamma, LOG_GAMMA)


def starting_lobes(theta_h, f_r, lobes, narrowest):
    """fitting/slice_fit.h, as log kappa, log gamma, log kappa, ..."""
    peak = max(f_r.max(), 1e-4)
    beyond = np.sort(f_r[theta_h > np.radians(30)])
    if len(beyond) == 0:
        beyond = np.sort(f_r)
    level = np.clip(beyond[len(beyond) // 2], 1e-2 * peak, peak)
    logs = []
    for k in range(lobes):
        position = k / (lobes - 1) if lobes > 1 else 0
        height = level * (peak / level) ** position
        logs += [np.log(np.log1p(height)), np.log(0.5 * (narrowest / 0.5) ** position)]
    return np.array(logs)


def clamp(logs):
    logs = logs.copy()
    logs[0::2] = np.clip(logs[0::2], *LOG_KAPPA)
    logs[1::2] = np.clip(logs[1::2], *LOG_GAMMA)
    return logs


class Em:
    """Algorithm 1 as fitting/slice_em.h reads it, each M-step by least_squares."""

    def __init__(self, problem):
        self.options, self.lobes = problem["em"], problem["lobes"]
        self.slices = [np.array(s) for channel in problem["slices"] for s in channel]

    def log_integral(self, kappa, gamma):
        m = np.arange(1, 200)
        log_terms = m * np.log(kappa) - np.cumsum(np.log(m)) - np.log(gamma * m + 1)
        return np.log(2 * np.pi) + np.logaddexp.reduce(log_terms)

    def shares(self, logs, at, f_r):
        log_p = np.empty((len(at), self.lobes))
        for k in range(self.lobes):
            kappa, gamma = np.exp(logs[2 * k]), np.exp(logs[2 * k + 1])
            log_x = np.log(kappa) + gamma * at
            x = np.exp(log_x)
            with np.errstate(divide="ignore", invalid="ignore"):
                large = x + np.log1p(-np.exp(-x))
            log_p[:, k] = np.where(x < 1e-8, log_x + x / 2, large) - self.log_integral(kappa, gamma)
        p = np.exp(log_p - log_p.max(axis=1, keepdims=True))
        return f_r[:, None] * p / p.sum(axis=1, keepdims=True)

    def fit(self, points):
        theta_h, f_r = points[:, 0], points[:, 1]
        at = log_cos(theta_h)
        logs = starting_lobes(theta_h, f_r, self.lobes, 200)
        for _ in range(self.options["max_iterations"]):
            shares, before = self.shares(logs, at, f_r), logs.copy()
            for k in range(self.lobes):
                residuals = lambda y: shares[:, k] - lobe(y[0], y[1], at)[0]
                jacobian = lambda y: -np.stack(lobe(y[0], y[1], at)[1:], axis=1)
                logs[2 * k:2 * k + 2] = clamp(
                    minimise(residuals, logs[2 * k:2 * k + 2], jacobian, ftol=1e-6,
                             xtol=1e-8, gtol=1e-10, max_nfev=20).x)
            if np.abs(logs - before).max() < self.options["tolerance"]:
                break
        f = lobe(logs[0::2, None], logs[1::2, None], at)[0].sum(axis=0)
        return ((f_r - f) ** 2).sum()

    def run(self):
        return sum(self.fit(points) for points in self.slices)


class Joint:
    """fitting/slice_joint.h, each slice's Levenberg-Marquardt by least_squares."""

    def __init__(self, problem):
        self.o, self.lobes = problem["joint"], problem["lobes"]
        self.channels = [[self.prepare(np.array(s)) for s in channel] for channel in problem["slices"]]

    def prepare(self, points):
        cosine = points[:, 2] / self.o["floor"]
        return {"theta_h": points[:, 0], "f_r": points[:, 1], "at": log_cos(points[:, 0]),
                "cosine": cosine, "seen": np.log1p(np.maximum(cosine * points[:, 1], -0.9)),
                "weight": np.sqrt(points[:, 3] * len(points) / points[:, 3].sum())}

    def evaluate(self, s, logs, neighbours):
        f, by_kappa, by_gamma = lobe(logs[0::2, None], logs[1::2, None], s["at"])
        shown = 1 + s["cosine"] * f.sum(axis=0)
        r = (s["seen"] - np.log(shown)) / self.o["model_error"]
        q = r / self.o["huber"]
        root = np.sqrt(1 + q * q)
        half = np.sqrt(2 / (1 + root))
        residuals = s["weight"] * r * half
        slope = half * (1 - q * q / (2 * root * (1 + root)))
        outer = -s["weight"] * slope * s["cosine"] / (shown * self.o["model_error"])
        jacobian = np.empty((len(r), 2 * self.lobes))
        jacobian[:, 0::2] = (outer * by_kappa).T
        jacobian[:, 1::2] = (outer * by_gamma).T
        if neighbours:
            residuals = np.concatenate(
                [residuals] + [(logs - n) / self.o["coupling"] for n in neighbours])
            jacobian = np.concatenate(
                [jacobian] + [np.eye(2 * self.lobes) / self.o["coupling"] for _ in neighbours])
        return residuals, jacobian

    def solve(self, s, start, neighbours):
        result = minimise(lambda y: self.evaluate(s, y, neighbours)[0], start,
                          lambda y: self.evaluate(s, y, neighbours)[1], ftol=1e-5, xtol=1e-6,
                          gtol=1e-6, max_nfev=60)
        return clamp(result.x), result.cost

    def alone(self, s):
        fits = [self.solve(s, starting_lobes(s["theta_h"], s["f_r"], self.lobes, narrowest), [])
                for narrowest in (5, 30, 150, 800, 5000)]
        logs, cost = min(fits, key=lambda fit: fit[1])
        order = np.argsort(logs[1::2], kind="stable")
        return logs.reshape(-1, 2)[order].ravel(), cost

    def fit(self, slices):
        states = [self.alone(s) for s in slices]
        last = len(slices) - 1
        for sweep in range(self.o["sweeps"]):
            settled = True
            for step in range(last + 1):
                i = step if sweep % 2 == 0 else last - step
                neighbours = [states[j][0] for j in (i - 1, i + 1) if 0 <= j <= last]
                before = (self.evaluate(slices[i], states[i][0], neighbours)[0] ** 2).sum() / 2
                states[i] = min((self.solve(slices[i], start, neighbours)
                                 for start in [states[i][0]] + neighbours), key=lambda fit: fit[1])
                settled &= before - states[i][1] < 2e-3 * before + 0.05
            if settled:
                break
        return sum(cost for _, cost in states)

    def run(self):
        return sum(self.fit(channel) for channel in self.channels)


class Continuous:
    """The posterior of fitting/posterior.h, Huber's loss folded into the residuals."""

    def __init__(self, problem):
        self.o, self.lobes = problem["continuous"], problem["lobes"]
        rows = self.o["readings"]
        self.channel = np.array([row[0] for row in rows])
        self.first = np.array([row[1] for row in rows])
        self.weights = np.array([row[2] for row in rows])
        self.at = np.array([row[3] for row in rows])
        f_r, sigma = np.array([row[4] for row in rows]), np.array([row[5] for row in rows])
        floor = self.o["floor"]
        self.glog = np.arcsinh(f_r / (2 * floor))
        self.s = np.hypot(sigma / np.hypot(f_r, 2 * floor), self.o["model_error"])
        self.mean = np.array(self.o["mean"])
        self.cholesky = np.linalg.cholesky(np.array(self.o["covariance"]))
        self.prior_jacobian = solve_triangular(self.cholesky, np.eye(len(self.mean)), lower=True)

    def columns(self, k, quantity):
        """Of the four coefficients that each reading's lobe k depends on."""
        first = ((self.channel * self.lobes + k) * 2 + quantity) * self.o["knots"] + self.first
        return first[:, None] + np.arange(4)

    def evaluate(self, p, derive):
        f, lobes = 0, []
        for k in range(self.lobes):
            logs = [(self.weights * p[self.columns(k, quantity)]).sum(axis=1) for quantity in (0, 1)]
            lobes.append(lobe(logs[0], logs[1], self.at))
            f = f + lobes[-1][0]
        floor, huber = self.o["floor"], self.o["huber"]
        r = (self.glog - np.arcsinh(f / (2 * floor))) / self.s
        beyond = np.abs(r) > huber
        robust = np.where(beyond, np.sign(r) * np.sqrt(np.maximum(2 * huber * np.abs(r) - huber**2, 0)), r)
        if not derive:
            return np.concatenate([robust, self.prior_jacobian @ (p - self.mean)])
        slope = np.where(beyond, huber / np.maximum(np.abs(robust), 1e-12), 1)
        outer = -slope / (self.s * np.hypot(f, 2 * floor))
        jacobian = np.zeros((len(r), len(p)))
        row = np.arange(len(r))[:, None]
        for k in range(self.lobes):
            for quantity in (0, 1):
                jacobian[row, self.columns(k, quantity)] = (outer * lobes[k][1 + quantity])[:, None] * self.weights
        return np.concatenate([jacobian, self.prior_jacobian])

    def run(self):
        return minimise(lambda p: self.evaluate(p, False), np.array(self.o["start"]),
                        lambda p: self.evaluate(p, True), ftol=self.o["tolerance"], xtol=1e-8,
                        gtol=1e-8, max_nfev=400).cost


def main():
    materials = [argument for argument in sys.argv[1:] if argument != "--defaults"]
    if len(materials) != 1:
        sys.exit("usage: against_scipy.py [--defaults] MATERIAL (.binary, .bsdf or .yaml)")
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
    program = os.path.join(root, "build", "release", "bin", "gonio_scipy_problem")
    if not os.path.exists(program):
        sys.exit("against_scipy.py: build first: script/build")
    methods = {"em": Em, "joint": Joint, "continuous": Continuous}
    ours, scipy = {name: [] for name in methods}, {name: [] for name in methods}
    for _ in range(ROUNDS):
        answer = subprocess.run([program, materials[0], "5"], check=True, capture_output=True)
        problem = json.loads(answer.stdout)
        for name, method in methods.items():
            fit = method(problem)
            begin = time.perf_counter()
            cost = fit.run()
            scipy[name].append((time.perf_counter() - begin, cost))
            ours[name].append((problem["ours"][name]["seconds"], problem["ours"][name]["cost"]))
    print(f"{os.path.basename(materials[0])}: seconds, medians of {ROUNDS} rounds")
    print(f"{'method':<12}{'ours':>10}{'SciPy':>10}{'ratio':>9}{'cost, ours':>14}{'SciPy':>14}")
    for name in methods:
        us, them = np.array(ours[name]), np.array(scipy[name])
        ratio = np.median(them[:, 0] / us[:, 0])
        print(f"{name:<12}{np.median(us[:, 0]):>10.4f}{np.median(them[:, 0]):>10.3f}{ratio:>8.1f}x"
              f"{us[-1, 1]:>14.6g}{them[-1, 1]:>14.6g}")


if __name__ == "__main__":
    main()
