"""Actions for a loop whose valve sticks: repair, retune, compensate, or add a positioner."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from stiction import _core
from stiction._arguments import callback, optional
from stiction._core import Table
from stiction._document import TestPlan
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn
from stiction.closed_loop import ScenarioLike
from stiction.closed_loop import scenario as _scenario
from stiction.compensation import Outcome, Parameter, Protocol, _bars, _names, _table
from stiction.cycles import Cycle, Retuning

__all__ = ["Action", "WhatIf", "what_if"]


@result
class Action(Result):
    """An action, and the effects of the action on the loop."""

    action: str = about(
        'The action: ``"as it is"``, ``"valve repaired"``, ``"retuned"``, ``"positioner"``, or the name of a '
        'compensator.'
    )
    parameters: list[Parameter] = about("Nominal parameters.")
    error: float = about("Mean absolute control error in the window of the nominal case, in PV units.")
    worst_error: float = about(
        "Mean absolute control error in the worst of the cases without noise, in PV units. This error determines the "
        "rank."
    )
    outcomes: list[Outcome] = about("The nominal case first, then S and J wrong, then with noise.")
    against: list[str] = about("Reasons against the action, each in a few words.")
    state: str = about('State of the loop after the action: ``"cycle"``, ``"no cycle"`` or ``"not known"``.')
    reason: str = about("The reason for no cycle, or for an unknown result.")
    cycle: Cycle | None = about("The exact limit cycle of the loop after the action; None without a limit cycle.")


@result
class WhatIf(Result):
    """All actions, ranked, and a recommendation."""

    rows: list[Action] = about("The actions, by ascending worst error.")
    interim: str | None = about("The recommended action until the valve is repaired, if any.")
    recommendation: list[str] = about("The recommendation, in sentences.")
    assumptions: list[str] = about("The assumptions, in sentences.")
    manual_test: TestPlan | None = about(
        "The test to confirm stiction before any action; None for a valve without friction, or if no test can be "
        "planned."
    )
    retuning: Retuning | None = about("Effects and cost of retuning.")
    no_retuning: str | None = about("The reason for no retuning.")
    protocol: Protocol = about("The protocol of the actions.")

    def _summary(self) -> list[str]:
        best = self.rows[0]
        [as_it_is] = [row for row in self.rows if row.action == "as it is"]
        return [
            f"WhatIf of {len(self.rows)} actions, recommended until the repair: {self.interim or 'none'}",
            f"smallest control error: {best.action}, {best.worst_error:.3g} PV units in the worst case",
            f"{as_it_is.action}: {as_it_is.worst_error:.3g}" if as_it_is is not best else "nothing is better",
        ]

    def to_table(self) -> Table:
        """Return a row for every action and case.

        Returns
        -------
        Table
            Columns are rank, action, s_factor, j_factor, noise, the first five measures, and settling time and error of each
            step.
        """
        return _table(self.rows)

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Draw control error and stem travel for every action, with correct and wrong S and J."""
        return _bars(self.rows, ax)


@documented
def what_if(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    repaired_S: float | None = None,
    repaired_J: float | None = None,
    positioner_gain: float | None = None,
    ms: float | None = None,
    methods: Sequence[str] | None = None,
    progress: Callable[[int], object] | None = None,
) -> WhatIf:
    """Compare actions for a loop whose valve sticks.

    Every action is simulated, with correct and wrong S and J, and ranked by the mean absolute control error in the worst case.

    Parameters
    ----------
    repaired_S, repaired_J : float, optional
        S and J of a repaired valve, percent of span; by default 0.4 and 0.1, or S and J of the valve if these are smaller.
    positioner_gain : float, optional
        Gain of a positioner; by default 10.
    ms : float, optional
        Bound on the peak of the sensitivity function of a retuned loop, above 1; by default 2.
    methods : sequence of str, optional
        Compensators to try, see `stiction.compensation.compensators`; by default all.
    progress : callable, optional
        Called with the number of finished simulations and tunings after each increase. The total number is not known in advance.

    Raises
    ------
    TypeError
        If `methods` is not a sequence of names, or `progress` cannot be called.
    ValueError
        If the scenario is not a closed loop, the signals grow without bound, or a number is out of its range.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.what_if("paper/closed-loop", methods=[])
    >>> found.rows[-1].action
    'as it is'
    >>> found.recommendation[1].startswith("Repair the valve")
    True
    """
    bound = optional("ms", ms)
    if bound is not None and not 1.0 < bound < float("inf"):
        raise ValueError(f"ms is {bound:g}, but must be a finite number above 1")
    found = _core.what_if_loop(
        _scenario(scenario, settings),
        optional("repaired_S", repaired_S),
        optional("repaired_J", repaired_J),
        optional("positioner_gain", positioner_gain),
        bound,
        _names("methods", methods),
        callback("progress", progress),
    )
    return result_of(WhatIf, found)
