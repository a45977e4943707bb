"""What Python parts look like to evenstep. These classes need not be derived from: what counts are the methods."""
from __future__ import annotations

import copy
import typing

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]


class SolverRequest(typing.Protocol):
    """What a solver is made for."""

    name: str
    options: dict[str, typing.Any]
    """[scene] options"""
    seed: int
    """[run] seed: all that may be drawn at random follows from it"""
    step_s: float
    """nominal simulated seconds of a step"""
    tool_count: int
    variable_step: bool
    """whether steps will differ from step_s"""


class Solver(typing.Protocol):
    """A scene. Besides step() it may have energy_J() -> J, state_digest() -> int below 2**64, reset(), and particles() ->
    (displacements, m, velocities, m/s), two arrays of shape (n, 3). What it lacks is left out of the run, which says so.

    Every strategy has a solver of its own, and strategies run at the same time: two solvers must not share what changes."""

    def step(self, positions_m: Vector, step_s: float) -> npt.ArrayLike:
        """Advances the scene by step_s simulated seconds, at the end of which the tools are at positions_m, shape
        (tool_count, 3). Returns the forces on the hand, N, in the same shape."""


class Grip(typing.Protocol):
    """The hand and the motors of a simulated device."""

    def hand_m(self) -> Vector:
        """Where the hand is now, m, shape (3,)."""

    def drive(self, force_N: npt.ArrayLike) -> None:
        """From now on the motors render this force, N, shape (3,)."""


class DeviceRequest(typing.Protocol):
    """What a device is made for."""

    name: str
    options: dict[str, typing.Any]
    seed: int
    device: str
    """name of the [[device]]"""
    rate_Hz: tuple[int, int]
    """ticks, and in how many seconds: (1000, 1)"""
    first_tick_ns: int
    grip: Grip


class Device(typing.Protocol):
    """A device. evenstep's guard clamps, slews and cuts every force before write()."""

    def read(self, now_ns: int) -> npt.ArrayLike | None:
        """The newest position, m, shape (3,); None: no new one since the last read."""

    def write(self, force_N: Vector) -> None:
        """The force to render from now on, N, shape (3,)."""

    def stop(self) -> None:
        """From now on no force. If the grip's motors still render one after the run, the run fails."""


class MapRequest(typing.Protocol):
    """What a map is made for."""

    name: str
    options: dict[str, typing.Any]
    seed: int
    step_rate_Hz: tuple[int, int]
    """steps, and in how many seconds of simulation time: (450, 1)"""


class Map(typing.Protocol):
    """A map, for strategy `foreign`. It may have began(n, at_ns) and ended(n, at_ns), too. It runs alone first, and again in
    each run: told the same times it must give the same slots."""

    def boundary(self, n: int, begin_ns: int) -> None:
        """A segment began; the next step is n, counted from 0."""

    def slot(self, n: int) -> int | np.timedelta64 | None:
        """When step n would be due if steps were even; None while the map does not know."""


class TimingRequest(typing.Protocol):
    """What a timing source is made for."""

    name: str
    options: dict[str, typing.Any]
    seed: int


class Segment(typing.NamedTuple):
    """A visualization and the steps after it, in ns. Steps do not overlap; the first segment begins at 0."""

    begin_ns: int
    visualization: tuple[int, int] | None
    """begin and end; None: there is none"""
    steps: typing.Sequence[tuple[int, int]]
    """begin and end of each"""


def factory(part: typing.Any) -> typing.Any:
    """`part` as something that makes one for each strategy: a class or function as it is, anything else by being copied."""
    if callable(part):
        return part
    return lambda request: copy.deepcopy(part)


def normalized(parts: dict[str, typing.Any]) -> dict[str, typing.Any]:
    """The given ones, each as a factory or as a dictionary from names to factories."""
    return {kind: {name: factory(one) for name, one in part.items()} if isinstance(part, dict) else factory(part)
            for kind, part in parts.items() if part is not None}
