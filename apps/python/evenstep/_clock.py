"""A virtual clock, and what runs under it."""
from __future__ import annotations

import typing

import numpy as np
import numpy.typing as npt

from . import _core

Time = typing.Union[int, np.timedelta64]
"""ns since the start"""


def tick_ns(rate_Hz: tuple[int, int], k: int, origin: int = 0) -> int:
    """When tick k of a rate is due, ns: exact, so that 30 Hz and 450 Hz do not drift. rate_Hz: (ticks, seconds)."""
    return origin + k * rate_Hz[1] * 1_000_000_000 // rate_Hz[0]


class _Awaited:
    def __init__(self, wait: typing.Any) -> None:
        self._wait = wait

    def __await__(self) -> typing.Generator[typing.Any, typing.Any, typing.Any]:
        return (yield self._wait)


class LoopTime(typing.Protocol):
    """The clock that a loop is given."""

    @property
    def now_ns(self) -> int: ...

    def sleep_until(self, at: Time, lane: str | None = None) -> None:
        """Returns at `at`. Raises Stopped when the run is over."""


class VirtualClock:
    """A clock that jumps from event to event, so that what runs under it gives the same trace every time.

    Events on the same nanosecond run in the order of their lanes, "completion", "device", "launch", and within one in the
    order in which they were asked for; permute_ties, a seed, puts that last order in another one.

    What is started before the first run() runs up to its first wait at once. close(), or a `with` around it, ends what has
    not ended: coroutines and loops are left, and their `finally` runs. Without it they are kept until Python ends."""

    def __init__(self, permute_ties: int | None = None) -> None:
        self._core = _core.Clock(permute_ties)

    @property
    def now_ns(self) -> int:
        """ns; stands still during an event."""
        return int(self._core.now_ns)

    @property
    def trace_hash(self) -> str:
        """16 hex digits over every event so far and what was noted in it."""
        return str(self._core.trace_hash)

    @property
    def events(self) -> list[tuple[int, str, str]]:
        """(ns, lane, name) of each event so far."""
        return list(self._core.events())

    def until(self, at: Time, lane: str = "launch", name: str = "until") -> typing.Awaitable[int]:
        """`await clock.until(t)`: wakes at t, or at now_ns if t has passed, in both cases as a new event. Gives now_ns."""
        return _Awaited(self._core.wait_until(at, lane, name))

    def external(self, end: Time, work: typing.Callable[[], typing.Any] | None = None,
                 name: str = "external") -> typing.Awaitable[typing.Any]:
        """Work that ends at `end`, in the lane "completion": it is called now, and gives its result, or raises, then."""
        return _Awaited(self._core.wait_for(end, work, name))

    def spawn(self, coroutine: typing.Coroutine[typing.Any, typing.Any, None]) -> None:
        """Starts a coroutine that awaits waits of this clock. RuntimeError: the run has begun."""
        self._core.spawn(coroutine)

    def every(self, rate_Hz: tuple[int, int], call: typing.Callable[[int], object], *, lane: str = "device",
              name: str = "tick") -> None:
        """Calls call(now_ns) at each tick of a rate, (ticks, seconds)."""

        async def ticks() -> None:
            k = 0
            while True:
                call(await self.until(tick_ns(rate_Hz, k), lane, name))
                k += 1

        self.spawn(ticks())

    def loop(self, loop: typing.Callable[[LoopTime], object], *, name: str = "sleep", lane: str = "launch") -> None:
        """Runs loop(time), which blocks in time.sleep_until(t), on a thread of its own. Only one thing runs at any time."""
        self._core.loop(loop, name, lane)

    def device(self, remapper: Remapper, rate_Hz: tuple[int, int], positions: npt.ArrayLike, *, origin: Time = 0,
               name: str = "tick") -> npt.NDArray[np.float64]:
        """A device in C++ beside the coroutines: at each tick k it gives positions[k] to the remapper and asks for a force,
        which it keeps in row k of the array that is returned. positions: shape (ticks, remapper.components)."""
        return typing.cast("npt.NDArray[np.float64]",
                           self._core.device(remapper._core, rate_Hz, positions, origin, name))

    def note(self, value: npt.ArrayLike) -> None:
        """Puts a number, or each of an array, into the trace of the event that is running."""
        self._core.note(value)

    def close(self) -> None:
        """Ends what still runs under the clock; nothing can be asked of it afterwards."""
        self._core.close()

    def __enter__(self) -> VirtualClock:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def run(self, until: Time) -> str:
        """Runs all events before `until`: "reached_end", or "idle" when none is left. Raises what a coroutine, callable or
        loop raised; that is final. RunFailed: a limit was exceeded, such as of events on one instant."""
        return str(self._core.run(until))


class Remapper:
    """The remap between one device thread and one simulation thread (docs/parts/embedding.md).

    lead, latency: int ns or numpy.timedelta64, those that `evenstep size` gives
    components: numbers in a position and in a force, 1 to 8
    emission: "linear" or "hold"
    bandwidth_Hz: how fast the map follows a change of pace
    sample_capacity, force_capacity: of the rings
    sample_window_ns, sample_furthest_ns, force_window_ns, force_furthest_ns: a line past the newest entry; 0: it is held
    adapt: {"start_ns", "least_ns", "most_ns", "window_ns", "margin_ns", "slew_ppm"}: a latency that adapts
    steps_per_s: for a loop that knows its own simulation time, which begin_step is then given

    As in C++ no call waits, locks or changes anything if it is refused. Times on each thread must not decrease.
    ArgumentError: a number is out of its range. OrderError: a time goes back, or begin_step and end_step do not alternate.
    TypeError: a time is a float, or there is no such option. ValueError: an array has another shape."""

    def __init__(self, *, lead: Time, latency: Time, **options: typing.Any) -> None:
        self._core = _core.Remapper(lead=lead, latency=latency, **options)

    @property
    def components(self) -> int:
        return int(self._core.components)

    def sample(self, now: Time, position: npt.ArrayLike) -> None:
        """Device thread, each tick: where the hand is, shape (components,)."""
        self._core.sample(now, position)

    def force(self, now: Time) -> Reading:
        """Device thread, each tick: the force to play now."""
        return typing.cast(Reading, self._core.force(now))

    def segment(self, begin: Time) -> None:
        """Simulation thread: a visualization and its steps begin. Without it no step ever has a slot."""
        self._core.segment(begin)

    def begin_step(self, now: Time, simulated: Time | None = None) -> StepInput:
        """Simulation thread: what to compute the step with. `simulated`: the step's own time, with steps_per_s."""
        return typing.cast(StepInput, self._core.begin_step(now, simulated))

    def end_step(self, now: Time, force: npt.ArrayLike) -> int:
        """Simulation thread: the step's force, shape (components,). Returns when it will be emitted, F(n), ns."""
        return int(self._core.end_step(now, force))

    def counts(self) -> dict[str, typing.Any]:
        """steps, acquiring, late_forces, latest_force_ns, and of the reads "hand" and "force": inside, held, extrapolated,
        overruns, empty. Any thread."""
        return dict(self._core.counts())


class Reading(typing.Protocol):
    """A force to play."""

    @property
    def value(self) -> npt.NDArray[np.float64]: ...

    @property
    def status(self) -> str:
        """"inside", "underrun" (past the newest), "overrun" (older than the ring) or "empty"."""


class StepInput(typing.Protocol):
    """What a step reads."""

    @property
    def position(self) -> npt.NDArray[np.float64]: ...

    @property
    def status(self) -> str:
        """As of Reading."""

    @property
    def read_ns(self) -> int:
        """R(n): the time that the position belongs to."""

    @property
    def newest_ns(self) -> int:
        """Time of the newest sample that was there."""

    @property
    def has_slot(self) -> bool:
        """False while no complete segment was seen."""
