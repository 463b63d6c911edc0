"""Independent reference values of the statistical detectors, with numpy and scipy.

Run as `python detect_oracle.py > ../fixtures/detect/statistics.json`. Nothing here is shared with the
library: transforms are numpy's, distributions scipy's, neighbours are searched by brute force, and the
ellipse comes from the generalised eigenvalue problem of Fitzgibbon, Pilu and Fisher as it stands.
The signals are closed formulas, repeated in tests/detect_statistics.rs, but for one that is kept with its
values.
"""
import json

import numpy as np
from scipy import integrate, linalg, stats


def signals(n):
    k = np.arange(n)
    pv = np.sin(0.31 * k) + 0.4 * np.sin(0.62 * k + 0.4) + 0.3 * np.sin(0.37 * k * k) + 20
    op = 3 * np.cos(0.31 * k + 0.2) + 0.5 * np.sin(0.29 * k * k) + 50
    return pv, op


def bicoherence(x, length=64, floor=1e-4, alpha=0.01):
    x = x / x.std()
    n = np.arange(length)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * (n + 0.5) / length)
    parts = [x[i : i + length] for i in range(0, len(x) - length + 1, length // 2)]
    spectra = np.array([np.fft.fft((p - p.mean()) * window)[: length // 2 + 1] for p in parts])
    count = len(spectra)
    power = (abs(spectra) ** 2).sum(0)
    strong = power > floor * power[1:].max()
    table = {}
    for i in range(1, length // 2 + 1):
        for j in range(1, i + 1):
            if i + j <= length // 2 and strong[i] and strong[j] and strong[i + j]:
                product = spectra[:, i] * spectra[:, j]
                top = abs(np.sum(product * spectra[:, i + j].conj())) ** 2
                table[i, j] = top / (np.sum(abs(product) ** 2) * power[i + j])
    values = np.array(list(table.values()))
    limit = 1 - (alpha / len(values)) ** (1 / (count - 1))
    significant = values[values > limit]
    peak = max(table, key=table.get)
    cubic = {}
    for i in range(2, length // 2 // 3 + 1):
        if strong[i] and strong[3 * i]:
            cube = spectra[:, i] ** 3
            top = abs(np.sum(cube * spectra[:, 3 * i].conj())) ** 2
            cubic[i] = top / (np.sum(abs(cube) ** 2) * power[3 * i])
    best = max(cubic, key=cubic.get)
    return {
        "segments": count,
        "bins": len(values),
        "critical": limit,
        "peak": [int(peak[0]), int(peak[1]), table[peak]],
        "ngi": significant.mean() - limit if len(significant) else 0.0,
        "nli": abs(values.max() - (values.mean() + 2 * values.std())),
        "cubic": [int(best), cubic[best]],
    }


def ellipse(x, y):
    mx, my, sx, sy = x.mean(), y.mean(), x.std(), y.std()
    u, v = (x - mx) / sx, (y - my) / sy
    design = np.column_stack([u * u, u * v, v * v, u, v, np.ones_like(u)])
    constraint = np.zeros((6, 6))
    constraint[0, 2] = constraint[2, 0] = 2
    constraint[1, 1] = -1
    values, vectors = linalg.eig(np.linalg.inv(design.T @ design) @ constraint)
    a, b, c, d, e, f = np.real(vectors[:, np.argmax(np.real(values))])
    centre = np.linalg.solve([[2 * a, b], [b, 2 * c]], [-d, -e])
    level = -(f + 0.5 * (d * centre[0] + e * centre[1]))
    form = np.array([a, b / 2, c]) / level
    return {
        "centre": [mx + sx * centre[0], my + sy * centre[1]],
        "form": list(form / [sx * sx, sx * sy, sy * sy]),
        "op_width": 2 / np.sqrt(form[0]) * sx,
    }


def gamma(x, embedding, neighbours=8):
    count = len(x) - 2 * embedding + 1
    vectors = np.array([x[i : i + embedding] for i in range(count)])
    future = x[2 * embedding - 1 :]
    total = 0.0
    for i in range(count):
        distance = ((vectors - vectors[i]) ** 2).sum(1)
        distance[abs(np.arange(count) - i) < embedding] = np.inf
        nearest = np.argsort(distance, kind="stable")[:neighbours]
        total += (future[i] - future[nearest].mean()) ** 2
    return total


def surrogate(x, rng, iterations=50):
    magnitude, ordered = abs(np.fft.rfft(x)), np.sort(x)
    y = np.fft.irfft(magnitude * np.exp(2j * np.pi * rng.random(len(magnitude))), len(x))
    y = ordered[np.argsort(np.argsort(y))]
    for _ in range(iterations):
        y = np.fft.irfft(magnitude * np.exp(1j * np.angle(np.fft.rfft(y))), len(x))
        y = ordered[np.argsort(np.argsort(y))]
    return y


def cycles():
    """600 samples of Rössler's oscillator, some 24 to a cycle: a nonlinear oscillation of wandering size."""

    def flow(_, p):
        x, y, z = p
        return [-y - z, x + 0.2 * y, 0.2 + z * (x - 5.7)]

    times = 100 + 0.245 * np.arange(600)
    run = integrate.solve_ivp(flow, (0, 250), [1, 1, 0], t_eval=times, rtol=1e-10, atol=1e-10)
    return np.round(run.y[0], 4)


def refined(x, period):
    def best(turns):
        k = np.arange(len(x))
        power = [abs(np.sum(x * np.exp(2j * np.pi * t * k / len(x)))) for t in turns]
        return turns[int(np.argmax(power))]

    periods = len(x) / period
    steps = int(np.ceil(0.5 * periods))
    top = best(periods * (1 + 0.1 * np.arange(-steps, steps + 1) / steps))
    return len(x) / best(top + 0.04 * np.arange(-5, 6))


def surrogates():
    x = cycles()
    length = int(24 * 24.0)
    piece = x[(len(x) - length) // 2 :][:length]
    piece = piece - piece.mean()
    period = refined(piece, 24.0)
    count = int(length / period + 1e-9) * 8
    sums = np.concatenate([[0], np.cumsum(piece)])
    places = np.arange(count + 1) * period / 8
    y = np.diff(np.interp(places, np.arange(length + 1), sums)) / (period / 8)
    y = (y - y.mean()) / y.std()
    own = gamma(y, 8)
    indices = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        others = np.array([gamma(surrogate(y, rng), 8) for _ in range(50)])
        indices.append((others.mean() - own) / (3 * others.std(ddof=1)))
    return {
        "x": list(x),
        "period": period,
        "gamma": own,
        "n": float(np.mean(indices)),
        "n_sd": float(np.std(indices)),
    }


def windows(x, size):
    return x[: len(x) // size * size].reshape(-1, size)


def hotelling(x):
    out = []
    parts = windows(x, 8)
    for a, b in zip(parts[:-1], parts[1:]):
        # Welch's test, squared: the same as Hotelling's of one variable with modified freedom.
        test = stats.ttest_ind(a, b, equal_var=False)
        out.append([test.statistic**2, stats.f.ppf(0.95, 1, test.df)])
    return out


def arrangements(x):
    pairs = [(i, j) for i in range(6) for j in range(i + 1, 6)]
    return [int(sum(w[i] > w[j] for i, j in pairs)) for w in windows(x, 6)]


pv, op = signals(2000)
print(
    json.dumps(
        {
            "bicoherence": bicoherence(-(pv - pv.mean())),
            "ellipse": ellipse(op, pv),
            "surrogates": surrogates(),
            "hotelling_pv": hotelling(pv)[:20],
            "hotelling_op": hotelling(op)[:20],
            "arrangements_pv": arrangements(pv)[:50],
            "f_critical": stats.f.ppf(0.95, 7, 7),
            "t_critical": stats.t.ppf(0.95, 14),
        },
    )
)
