"""Where reference values are found: computed by scripts that share no code with the project."""

import csv
import gzip
from pathlib import Path

import numpy as np

FIXTURES = Path(__file__).parents[2] / "crates" / "stiction-model" / "tests" / "fixtures"


def table(name):
    """The columns of a table of the library's fixtures: numbers where all are, else text."""
    path = FIXTURES / name
    opened = gzip.open(path, "rt") if path.suffix == ".gz" else open(path)
    with opened as file:
        header, *rows = csv.reader(file)

    def column(values):
        try:
            return np.array([float(value) for value in values])
        except ValueError:
            return np.array(values)

    return {name: column(values) for name, values in zip(header, zip(*rows))}
