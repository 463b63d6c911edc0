"""Frames as data bases and clients of historians give them: each is read as the plain frame of the same numbers, or the
message names the column."""

from decimal import Decimal

import numpy as np
import pandas as pd
import pytest
import stiction

RUN = stiction.simulate("samples/sticky-flow")  # S = 4, J = 2
TIMES = pd.date_range("2023-03-04 08:00", periods=len(RUN.op), freq="s", tz="UTC")
FRAME = pd.DataFrame({"sp": RUN.sp, "pv": RUN.pv, "op": RUN.op}, index=TIMES)
OF_OTHER_TIMES = pd.concat([FRAME.pv, FRAME.op.shift(freq="200ms"), FRAME.sp[::60]], axis=1, sort=True)


def with_cells(value, *rows):
    """The frame with objects, some of which are this value."""
    frame = FRAME.astype(object)
    for row in rows:
        frame.iloc[row, 1] = value
    return frame


FRAMES = {
    "plain": FRAME,
    "one Bad in an object column": with_cells("Bad", 50),
    "Decimal": FRAME.assign(pv=[Decimal(f"{v:.3f}") for v in RUN.pv]),
    "TimedeltaIndex": FRAME.set_axis(pd.to_timedelta(np.arange(len(FRAME)), unit="s")),
    "reset_index": FRAME.reset_index(),
    "concat of series at other times": OF_OTHER_TIMES,
    # Further frames of the same kind.
    "None and NaN among objects": with_cells(None, 50, 700),
    "a state of a historian": with_cells("I/O Timeout", 50, 51, 52),
    "numbers as text": FRAME.astype(str),
    "nullable numbers": FRAME.convert_dtypes().assign(pv=FRAME.pv.astype("Float64").where(np.arange(len(FRAME)) != 50)),
    "an index of nanoseconds with a name": FRAME.rename_axis("when"),
    "naive times": FRAME.tz_localize(None),
    "times of another zone": FRAME.tz_convert("Europe/Berlin"),
    "a concat whose set point is held": OF_OTHER_TIMES.assign(sp=OF_OTHER_TIMES.sp.ffill()),
}


@pytest.mark.parametrize("name", FRAMES)
def test_a_frame_sticks_by_four_percent(name):
    found = stiction.diagnose(FRAMES[name], detectors="none")
    assert found.verdict.class_ == "sticks", f"{name}: {found.verdict}"
    size = found.stiction.S
    assert size is not None and 3.3 < size.value < 4.6 and size.low < 4 < size.high + 0.3, f"{name}: {size}"
    assert abs(found.judged.samples - len(FRAME)) <= 10, f"{name}: {found.judged}"
    assert abs(found.judged.sample_time_s - 1) < 0.01, f"{name}: {found.judged}"


def test_a_cell_that_is_no_number_is_named():
    frame = FRAME.astype(object)
    frame.iat[50, 1] = {"a": 1}
    with pytest.raises((ValueError, TypeError), match="pv") as refused:
        stiction.diagnose(frame, detectors="none")
    assert not type(refused.value).__name__.startswith("Arrow")
