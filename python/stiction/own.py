"""Base classes for a valve, a controller or a process written in Python, for `stiction.simulate`."""

from __future__ import annotations

from abc import ABC, abstractmethod

from stiction._words import documented

__all__ = ["OwnController", "OwnProcess", "OwnValve"]


class OwnValve(ABC):
    """A valve of your own. Derive a class from this class, and pass an object of the class to `stiction.simulate`.

    Examples
    --------
    >>> import stiction
    >>> class Backlash(stiction.own.OwnValve):
    ...     def restart(self, position):
    ...         self.position = position
    ...
    ...     def step(self, op):
    ...         self.position = min(max(self.position, op - 2.5), op + 2.5)
    ...         return self.position
    >>> mine = stiction.simulate("paper/closed-loop", {"duration": 60}, valve=Backlash())
    >>> play = stiction.simulate("paper/closed-loop", {"duration": 60, "valve.model": "play", "valve.S": 5})
    >>> mine.vp.tolist() == play.vp.tolist()
    True
    """

    @abstractmethod
    def restart(self, position: float) -> None:
        """Begin at rest.

        Parameters
        ----------
        position : float
            Valve position (VP), and OP before the first sample, percent of span.
        """

    @abstractmethod
    def step(self, op: float) -> float:
        """Return the valve position (VP) for one new sample of the OP.

        Parameters
        ----------
        op : float
            The new OP, percent of span.

        Returns
        -------
        float
            The valve position, percent of span.
        """


class OwnController(ABC):
    """A controller of your own. Derive a class from this class, and pass an object of the class to `stiction.simulate`.

    Examples
    --------
    >>> import stiction
    >>> class OnOff(stiction.own.OwnController):
    ...     def restart(self, sample_time, op, sp, pv):
    ...         self.op = op
    ...
    ...     def step(self, sp, pv):
    ...         return self.op + (10 if pv < sp else -10)
    >>> run = stiction.simulate("paper/closed-loop", {"duration": 60}, controller=OnOff())
    >>> run.half_pp_op
    10.0
    """

    @abstractmethod
    @documented
    def restart(self, sample_time: float, op: float, sp: float, pv: float) -> None:
        """Take over control.

        Parameters
        ----------
        op : float
            OP at which the controller takes over, percent of span.
        sp, pv : float
            Set point and PV when the controller takes over, in PV units.
        """

    @abstractmethod
    def step(self, sp: float, pv: float) -> float:
        """Return the OP for one new sample of SP and PV.

        Parameters
        ----------
        sp, pv : float
            Set point and measured PV, in PV units.

        Returns
        -------
        float
            The OP, percent of span.
        """


class OwnProcess(ABC):
    """A process of your own, relative to the operating point. Derive a class from this class, and pass an object of the class to
    `stiction.simulate`.

    Examples
    --------
    >>> import stiction
    >>> class Tank(stiction.own.OwnProcess):
    ...     def restart(self, sample_time):
    ...         self.sample_time, self.level = sample_time, 0.0
    ...
    ...     def output(self):
    ...         return self.level
    ...
    ...     def advance(self, flow):
    ...         self.level += 0.2 * self.sample_time * flow
    >>> run = stiction.simulate("paper/closed-loop", {"duration": 60}, process=Tank())
    >>> len(run.pv) == len(run.vp)
    True
    """

    @abstractmethod
    @documented
    def restart(self, sample_time: float) -> None:
        """Begin at rest."""

    @abstractmethod
    def output(self) -> float:
        """Return the PV of the present sample, before the input of this sample acts.

        Returns
        -------
        float
            The PV relative to the operating point, in PV units.
        """

    @abstractmethod
    def advance(self, input: float) -> None:
        """Advance to the next sample.

        Parameters
        ----------
        input : float
            Sum of valve position and load until the next sample, percent of span. The valve position is relative to the operating
            point.
        """
