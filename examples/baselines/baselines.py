"""Detectors that others would try first, trained on the training loops of the benchmark and measured on a suite.

    pip install -r requirements.txt
    python baselines.py boosting --train 4000 --suite v1       # writes boosting.json
    python baselines.py multirocket --train 4000 --suite v1    # writes multirocket.json
    python baselines.py convolution --train 4000 --suite v1    # writes convolution.json

The results are read by `stiction bench report` and `stiction bench verify`.
"""

import argparse
import os

import numpy as np
import stiction.bench
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.linear_model import RidgeClassifierCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler

LAGS = [1, 2, 4, 8, 16, 32, 64, 128]
SAMPLES = 512


def standard(x):
    """A signal without its mean, in units of its standard deviation; zeros if the signal is constant."""
    x = np.asarray(x, dtype=float)
    spread = x.std()
    return (x - x.mean()) / spread if spread > 0 else np.zeros_like(x)


def correlation(a, b, lag):
    """The mean product of two standardised signals, the second later by `lag`."""
    return float(np.mean(a[: len(a) - lag] * b[lag:])) if len(a) > lag else 0.0


def of_signal(x):
    """Statistics of one signal in any units: moments, changes, autocorrelation, spectrum."""
    z = standard(x)
    steps = np.diff(z)
    moving = steps[steps != 0]
    power = np.abs(np.fft.rfft(z)[1:]) ** 2
    share = power / power.sum() if power.sum() > 0 else np.full(len(power), 1 / len(power))
    turns = np.mean(np.diff(np.sign(moving)) != 0) if len(moving) > 1 else 0.0
    yield from [np.mean(z**3), np.mean(z**4), np.mean(steps == 0), np.mean(np.abs(steps)), turns]
    yield from [np.mean(standard(steps) ** 3), np.mean(standard(steps) ** 4), np.mean(z[1:] * z[:-1] < 0)]
    yield from [share.max(), np.argmax(share) / len(share), -np.sum(share * np.log(share + 1e-12)) / np.log(len(share) + 1)]
    yield from np.quantile(z, [0.02, 0.1, 0.25, 0.75, 0.9, 0.98])
    yield from [correlation(z, z, lag) for lag in LAGS]


def of_loop(recording):
    """Statistics of OP, PV and their relation."""
    op, pv = standard(recording.op), standard(recording.pv)
    resting = np.diff(recording.pv) == 0
    yield from of_signal(recording.op)
    yield from of_signal(recording.pv)
    yield from of_signal(np.cumsum(pv))
    yield from [correlation(op, pv, lag) for lag in [0, *LAGS]] + [correlation(pv, op, lag) for lag in LAGS]
    yield from [np.mean(resting), np.ptp(recording.op), np.std(np.diff(recording.op)), len(op)]
    yield float(np.mean(np.abs(np.diff(op))) / (np.mean(np.abs(np.diff(pv))) + 1e-9))
    yield {"flow": 0, "level": 1, "pressure": 2, "temperature": 3}.get(recording.loop_type, 4)


def features(recordings):
    """One row of statistics for each recording."""
    return np.array([list(of_loop(each)) for each in recordings])


def series(recordings):
    """OP and PV of each recording, standardised and interpolated to 512 samples."""
    def short(x):
        return np.interp(np.linspace(0, len(x) - 1, SAMPLES), np.arange(len(x)), standard(x))

    return np.array([[short(each.op), short(each.pv)] for each in recordings])


def series_and_changes(recordings):
    """Recordings with the changes from sample to sample, from which a network learns more easily."""
    x = series(recordings)
    changes = np.diff(x, axis=2, prepend=x[:, :, :1])
    return np.concatenate([x, changes / (changes.std(axis=2, keepdims=True) + 1e-9)], axis=1)


def boosting():
    """Gradient boosting on statistics."""
    trees = HistGradientBoostingClassifier(max_iter=400, learning_rate=0.04, l2_regularization=1.0, random_state=1)
    return make_pipeline(FunctionTransformer(features), trees)


def multirocket():
    """MultiRocket with a ridge classifier, as in its paper."""
    from aeon.transformations.collection.convolution_based import MultiRocket

    ridge = RidgeClassifierCV(alphas=np.logspace(-3, 5, 17))
    return make_pipeline(FunctionTransformer(series), MultiRocket(random_state=1), StandardScaler(), ridge)


class Network(ClassifierMixin, BaseEstimator):
    """A small fully convolutional network, after Wang, Yan and Oates (2017, IJCNN).

    A tenth of the loops decides when training ends.
    """

    def fit(self, x, y):
        os.environ.setdefault("KERAS_BACKEND", "jax")
        import keras

        self.classes_, y = np.unique(y, return_inverse=True)
        keras.utils.set_random_seed(1)
        mixed = np.random.default_rng(1).permutation(len(x))
        kept, held = mixed[len(x) // 10 :], mixed[: len(x) // 10]
        layers = [keras.Input(x.shape[1:]), keras.layers.Permute((2, 1))]
        for filters, width in [(32, 9), (64, 7), (64, 5), (64, 5)]:
            layers += [
                keras.layers.Conv1D(filters, width, padding="same", use_bias=False),
                keras.layers.BatchNormalization(),
                keras.layers.ReLU(),
                keras.layers.MaxPooling1D(2),
            ]
        layers += [keras.layers.GlobalAveragePooling1D(), keras.layers.Dropout(0.3), keras.layers.Dense(1, activation="sigmoid")]
        self.network_ = keras.Sequential(layers)
        self.network_.compile(keras.optimizers.Adam(2e-3), "binary_crossentropy")
        ends = keras.callbacks.EarlyStopping(patience=12, restore_best_weights=True)
        slows = keras.callbacks.ReduceLROnPlateau(patience=5, factor=0.5)
        self.network_.fit(
            x[kept], y[kept], validation_data=(x[held], y[held]), epochs=100, batch_size=64, callbacks=[ends, slows], verbose=0
        )
        return self

    def predict_proba(self, x):
        sticking = np.asarray(self.network_.predict(x, verbose=0), dtype=float)[:, 0]
        return np.column_stack([1 - sticking, sticking])

    def predict(self, x):
        return self.classes_[(self.predict_proba(x)[:, 1] > 0.5).astype(int)]


def convolution():
    """A convolutional network on the signals and their changes."""
    return make_pipeline(FunctionTransformer(series_and_changes), Network())


BASELINES = {"boosting": boosting, "multirocket": multirocket, "convolution": convolution}


def main():
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("baseline", choices=BASELINES)
    asked.add_argument("--train", type=int, default=4000, help="number of training loops, at most 10000")
    asked.add_argument("--suite", default="v1")
    options = asked.parse_args()
    found = stiction.bench.run(
        {options.baseline: BASELINES[options.baseline]()}, options.suite, train=options.train, version=f"{options.train} loops"
    )
    found.save(f"{options.baseline}.json")
    print(found)


if __name__ == "__main__":
    main()
