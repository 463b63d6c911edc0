"""A history is read to its end, wherever the source cuts its answers."""

import random
from bisect import bisect_left, bisect_right

import pytest
from stiction.live import history


def time_of(value):
    return value[0]


class Source:
    """Series of (time, number), and the habits of a server that gives them."""

    def __init__(self, series, *, cap=10_000, points=False, newest=False, descending=False, ignores_count=False, bounds=False,
                 exclusive=False, total=None, ignores_span=False, endless=False):  # fmt: skip
        self.series, self.cap, self.points, self.newest, self.descending = series, cap, points, newest, descending
        self.ignores_count, self.bounds, self.exclusive, self.total = ignores_count, bounds, exclusive, total
        self.ignores_span, self.endless, self.asked = ignores_span, endless, 0

    def answers(self, spans, count):
        room = self.total
        answers = []
        for span in spans:
            self.asked += 1
            begin, end = span.asked
            own = self.series[span.index]
            first = bisect_right(own, begin, key=time_of) if self.exclusive else bisect_left(own, begin, key=time_of)
            found = own if self.ignores_span else own[first : bisect_right(own, end, key=time_of)]
            from_ = int(span.point) if span.point else 0
            most = min(self.cap, 1 << 60 if self.ignores_count else count, 1 << 60 if room is None else room)
            order = found[::-1] if self.newest else found
            part = order[from_ : from_ + most]
            more = from_ + most < len(order)
            point = str(from_ + most).encode() if self.points and more else None
            if self.endless:
                point = b"0"
            if self.descending == self.newest:
                part = list(part)
            else:
                part = part[::-1]
            if self.bounds and not more and not span.point:
                before, after = own[:first][-1:], own[bisect_right(own, end, key=time_of) :][:1]
                part = before + part + after if not self.newest else after + part + before
            if room is not None:
                room -= len(part)
            answers.append(history.Answer(part, point))
        return answers


def read(source, begin, end, *, count=10_000, together=20):
    reading = history.Reading(
        list(source.series), begin, end, together=together, time_of=time_of, key_of=lambda value: value[1]
    )
    found, unread = {index: [] for index in source.series}, []
    while spans := reading.next():
        for span, answer in zip(spans, source.answers(spans, count)):
            for part in reading.take(span, answer, count):
                if isinstance(part, history.Unread):
                    unread.append((span.index, part))
                else:
                    found[span.index] += part
    return found, unread


def regular(count, step=1_000_000, start=0):
    return [(start + k * step, k) for k in range(count)]


HABITS = {
    "a cap without a continuation point": {"cap": 10_000},
    "a cap with continuation points": {"cap": 10_000, "points": True},
    "a cap lower than the count": {"cap": 700},
    "a low cap": {"cap": 40},
    "continuation points of a low cap": {"cap": 40, "points": True},
    "more than the count": {"ignores_count": True, "cap": 1 << 40},
    "the newest first": {"cap": 700, "newest": True, "descending": True},
    "the newest first, with continuation points": {"cap": 700, "newest": True, "descending": True, "points": True},
    "the newest, in order": {"cap": 700, "newest": True},
    "the oldest, in reverse order": {"cap": 700, "descending": True},
    "bounds": {"cap": 700, "bounds": True},
    "the begin left out": {"cap": 700, "exclusive": True},
    "a cap of all nodes together": {"total": 1000},
    "no cap": {"cap": 1 << 40, "ignores_count": True},
}


@pytest.mark.parametrize("count", [10_000, 1_000])
@pytest.mark.parametrize("habit", HABITS, ids=HABITS.keys())
def test_every_value_comes_once(habit, count):
    series = {0: regular(11_850), 1: regular(3_000, 4_000_000, 17), 2: [], 3: regular(1, start=5_000_001), 4: regular(20, 600_000_001)}
    source = Source(series, **HABITS[habit])
    begin, end = (-5, 12_000_000_000) if source.exclusive else (0, 12_000_000_000)
    found, unread = read(source, begin, end, count=count)
    assert unread == []
    for index, own in series.items():
        assert sorted(found[index]) == own, index


@pytest.mark.parametrize("points", [False, True])
@pytest.mark.parametrize("newest", [False, True])
def test_values_of_one_time_at_the_seam_all_come(points, newest):
    # Five values of one time lie where an answer of seven ends.
    series = {0: sorted([(k, k) for k in range(5)] + [(5, 100 + k) for k in range(5)] + [(6 + k, k) for k in range(9)])}
    found, unread = read(Source(series, cap=7, points=points, newest=newest, descending=newest), 0, 100)
    assert (sorted(found[0]), unread) == (series[0], [])


def test_more_values_of_one_time_than_an_answer_holds_are_reported_and_the_rest_is_read():
    series = {0: [(0, 0)] + [(5, k) for k in range(9)] + [(6 + k, k) for k in range(9)]}
    found, unread = read(Source(series, cap=4), 0, 100)
    assert [(index, part.begin, part.end) for index, part in unread] == [(0, 5, 5)] and "more values of one time" in unread[0][1].why
    assert [value for value in found[0] if value[0] != 5] == [value for value in series[0] if value[0] != 5]


def test_what_comes_is_within_the_times_but_for_the_last_value_before_them():
    found, _ = read(Source({0: regular(5_000)}, ignores_span=True, cap=1 << 40), 1_000_500_000, 2_000_500_000, count=10_000)
    inside = [value for value in found[0] if 1_000_500_000 <= value[0] <= 2_000_500_000]
    assert inside == regular(5_000)[1001:2001] and found[0][0] == (1_000_000_000, 1000)


def test_continuations_and_values_without_an_end_come_to_one(monkeypatch):
    source = Source({0: regular(50), 1: regular(3)}, endless=True)
    found, _ = read(source, 0, 1_000_000_000)
    assert {index: sorted(own) for index, own in found.items()} == source.series and source.asked < 60
    # A source that invents a value for each question.
    monkeypatch.setattr(history, "MOST_ANSWERS", 100)
    reading = history.Reading([0], 0, 1 << 50, together=1, time_of=lambda value: value, key_of=lambda value: value)
    unread, asked = [], 0
    while spans := reading.next():
        asked += 1
        for part in reading.take(spans[0], history.Answer([spans[0].begin + 1], b"more"), 10_000):
            if isinstance(part, history.Unread):
                unread.append(part)
    assert asked == 100 and [part.end for part in unread] == [1 << 50]


def test_a_node_that_is_refused_among_others_is_requested_alone():
    reading = history.Reading([0, 1], 0, 10, together=2, time_of=lambda value: value, key_of=lambda value: value)
    spans = reading.next()
    assert len(spans) == 2
    given = [list(reading.take(span, history.Answer(code=0x804B_0000, retry=True), 10)) for span in spans]
    alone = [reading.next(), reading.next()]
    assert given == [[], []] and [len(each) for each in alone] == [1, 1]
    # Alone it stays refused: that is the end, with its code.
    assert list(reading.take(alone[0][0], history.Answer(code=0x804B_0000, retry=True), 10)) == [0x804B_0000]
    assert list(reading.take(alone[1][0], history.Answer([1, 2]), 10)) == [[1, 2]]
    # A failure after the first values leaves the rest unread.
    [before], [after] = reading.next(), reading.next()
    assert (before.begin, before.end, after.begin, after.end) == (0, 1, 2, 10)
    assert [(part.begin, part.end) for part in reading.take(after, history.Answer(code=0x8000_0000), 10)] == [(2, 10)]


@pytest.mark.parametrize("seed", range(60))
def test_any_source_gives_all_its_values(seed):
    own = random.Random(seed)
    series = {
        index: sorted((own.randrange(0, 2_000_000_000), own.randrange(10**9)) for _ in range(own.choice([0, 1, 2, 30, 400])))
        for index in range(own.randrange(1, 8))
    }
    habits = {
        "cap": own.choice([3, 10, 50, 1000]), "points": own.random() < 0.4, "newest": own.random() < 0.4,
        "descending": own.random() < 0.4, "ignores_count": own.random() < 0.3, "bounds": own.random() < 0.4,
    }  # fmt: skip
    found, unread = read(Source(series, **habits), 0, 2_000_000_000, count=own.choice([5, 100, 10_000]), together=own.choice([1, 3, 20]))
    assert unread == [] and {index: sorted(each) for index, each in found.items()} == series, habits
