"""run, check, size, study and compare."""
from __future__ import annotations

import functools
import json
import os
import shlex
import typing

import numpy as np
import numpy.typing as npt

from . import _core, _parts
from ._errors import Error

Path = typing.Union[str, "os.PathLike[str]"]
Rows = npt.NDArray[np.void]


class DeviceSeries(typing.NamedTuple):
    """The columns of one device under one strategy."""

    steps: Rows
    """a row per step: position_m and force_N, shape (3,); read: 0 inside, 1 underrun, 2 overrun, 3 newest, 4 acquiring,
    5 gated, 6 predicted"""
    ticks: Rows
    """a row per tick of the device: at_ns, lateness_ns, position_m, force_N, started (False: no force yet)"""


class StrategySeries(typing.NamedTuple):
    """The columns of one strategy: arrays with named fields that cannot be written to, and that lie where the run has them."""

    steps: Rows
    """a row per step: segment, begin_ns, end_ns, read_ns: R(n), emission_ns: F(n), mapped"""
    segments: Rows
    """a row per segment: index, begin_ns, end_ns"""
    events: Rows
    """a row per event of the trace: at_ns, lane (0 completion, 1 device, 2 launch), name: an index into event_names, hash"""
    event_names: list[str]
    devices: dict[str, DeviceSeries]


class Run:
    """A finished run, judged. `if run.ok` asks what the program's exit code says."""

    def __init__(self, core: typing.Any, file: str, command: str) -> None:
        self._core, self.file, self.command = core, file, command

    def __repr__(self) -> str:
        return f"<evenstep.Run {self.file}: {self.verdict}, trace {self.trace_hash}>"

    @property
    def exit_code(self) -> int:
        """0 all expectations hold, 1 one does not or nothing was asserted."""
        return int(self._core.exit)

    @property
    def ok(self) -> bool:
        return self.exit_code == 0

    @property
    def verdict(self) -> str:
        """"pass", "none" (nothing was asserted), "degraded", "fail" or "error"."""
        return str(self._core.verdict)

    @property
    def trace_hash(self) -> str:
        """16 hex digits, those that `evenstep run` prints."""
        return str(self._core.trace_hash)

    @property
    def failures(self) -> list[str]:
        """What does not hold, one text per expectation: file, line, limit, and the first and the worst place."""
        return list(self._core.failures)

    @functools.cached_property
    def metrics(self) -> dict[str, dict[str, dict[str, float]]]:
        """strategy -> signal -> metric -> value, in SI base units or a count (docs/reference/metrics.md). A signal is named
        without its strategy: metrics["paper"]["left.force"]["velocity_jump"]. What belongs to no strategy is in "run"."""
        by_strategy: dict[str, dict[str, dict[str, float]]] = {}
        strategies = self._core.strategies
        for signal, values in self._core.metrics.items():
            parts = signal.split(".")
            of = parts[-1] if parts[-1] in strategies else "run"
            name = signal if of == "run" else ".".join(parts[:-1])
            by_strategy.setdefault(of, {})[name] = dict(values)
        return by_strategy

    @functools.cached_property
    def series(self) -> dict[str, StrategySeries]:
        """strategy -> its columns. Times are ns of real time, positions m, forces N. Nothing is copied; the arrays keep the
        run alive."""
        return {name: StrategySeries(steps, segments, events, event_names,
                                     {device: DeviceSeries(*both) for device, both in devices.items()})
                for name, (steps, segments, events, event_names, devices) in _core.series(self._core).items()}

    @functools.cached_property
    def summary(self) -> dict[str, typing.Any]:
        """What the program writes as summary.json (docs/schema/summary-1.json)."""
        return typing.cast("dict[str, typing.Any]", json.loads(self._core.summary()))

    def text(self) -> str:
        """A line per strategy, and the table of all expectations, for people."""
        return str(self._core.text())

    def write(self, folder: Path) -> None:
        """Writes the run folder, with report.html, for `evenstep compare` and `evenstep index`. Error: it cannot be
        written."""
        self._core.write(os.fspath(folder), self.command)


def _assignments(given: typing.Mapping[str, object] | typing.Sequence[str]) -> list[str]:
    """Assignments as --set has them, from a list of them or from {"path": value}."""
    if isinstance(given, str):
        raise TypeError('set= is a list of "path=value" or a dictionary of them, not a single text')
    if not isinstance(given, typing.Mapping):
        return [str(one) for one in given]
    return [f"{path}={value if isinstance(value, str) else json.dumps(value)}" for path, value in given.items()]


def run(scenario: Path, *, solver: typing.Any = None, device: typing.Any = None, map: typing.Any = None,
        timing: typing.Any = None, set: typing.Mapping[str, object] | typing.Sequence[str] = (), seed: int | None = None,
        repeat: bool = False, permute_ties: int | None = None, threads: int = 0) -> Run:
    """Runs a scenario in virtual time and judges it, as `evenstep run` does. Nothing is written.

    scenario: a file, *.toml
    solver, device, map, timing: parts of your own: a class (or function) that is called with a request and makes one for
        each strategy, an object that is copied for each, or a dictionary of these by the names that the scenario has for
        them. One alone takes the place of the part that the scenario names, or of evenstep's own (docs/parts/python.md).
    set: {"remap.latency": "20 ms"} or ["remap.latency=20 ms"]: overrides the file
    seed: in place of [run] seed
    repeat: runs twice and compares the traces
    permute_ties: a seed that puts simultaneous events in another order
    threads: how many strategies run at the same time; 0: one per core

    ScenarioError: the file is wrong, and nothing ran. RunFailed: the run could not go on, or a part raised; the run so far
    is its `run`. NotReproducible. KeyboardInterrupt: Ctrl-C ends the run in order, within 20 ms of its virtual time.
    """
    file, assignments = os.fspath(scenario), _assignments(set)
    parts = _parts.normalized({"solver": solver, "device": device, "map": map, "timing": timing})
    words = ["evenstep", "run", file] + (["--seed", str(seed)] if seed is not None else [])
    words += [word for one in assignments for word in ("--set", one)] + (["--repeat"] if repeat else [])
    words += ["--permute-ties", str(permute_ties)] if permute_ties is not None else []
    command = shlex.join(words) + ("   # with parts of Python: " + ", ".join(parts) if parts else "")
    try:
        return Run(_core.run(file, assignments, seed, parts, threads, repeat, permute_ties), file, command)
    except Error as error:
        if error.run is not None:
            error.run = Run(error.run, file, command)
        raise


def check(scenario: Path, *, set: typing.Mapping[str, object] | typing.Sequence[str] = (), seed: int | None = None,
          solver: typing.Any = None, device: typing.Any = None, map: typing.Any = None,
          timing: typing.Any = None) -> dict[str, typing.Any]:
    """Reads and explains a scenario and runs nothing: the document of `evenstep check --json` (docs/reference/json.md).
    Parts are dictionaries by name here, because the file is checked as it is. ScenarioError: it is refused."""
    parts = _parts.normalized({"solver": solver, "device": device, "map": map, "timing": timing})
    for kind, part in parts.items():
        if not isinstance(part, dict):
            raise TypeError(f"check() takes {kind}= as a dictionary from the name in the scenario to the part")
    return typing.cast("dict[str, typing.Any]",
                       json.loads(_core.check(os.fspath(scenario), _assignments(set), seed, parts)))


def size(recording: Path, *, map: typing.Any = None, timing: typing.Any = None, solver: typing.Any = None,
         device: typing.Any = None, **options: typing.Any) -> dict[str, typing.Any]:
    """The least latency, lead and rings for which nothing underruns: the document of `evenstep size --json`.

    recording: timing.csv, a list of steps begin_ns,end_ns, a profiler's file, or a scenario (*.toml)
    options: those of `evenstep size --help`, with _ for -: sampling="1 kHz", emission="linear", step_size="90 Hz",
        rate="0.1 %", per="1 h", confidence="95 %", damping="1 N s/m", fits="latency 20 ms, lead 2 ms", worst_order="1 s",
        what_if=["split 2"], adaptive=True, other_maps=True; of a profiler's file segment, visualization, step, step_begin,
        process, preset, steps, step_time, format; of a scenario set={…}, and parts

    ScenarioError: with file, line and column of what is wrong. TypeError: there is no such option."""
    if "set" in options:
        options["set"] = _assignments(options["set"])
    parts = _parts.normalized({"solver": solver, "device": device, "map": map, "timing": timing})
    return typing.cast("dict[str, typing.Any]", json.loads(_core.size(os.fspath(recording), options, parts)))


def study(scenario: Path, *, set: typing.Mapping[str, object] | typing.Sequence[str] = (), cache: Path = "",
          solver: typing.Any = None, device: typing.Any = None, map: typing.Any = None,
          timing: typing.Any = None) -> dict[str, typing.Any]:
    """Error against run time of the scenario's [study]: the document of `evenstep study --json`.

    cache: the folder in which references of a study of the felt force are kept; "": none is

    ScenarioError, RunFailed, KeyboardInterrupt as of run()."""
    parts = _parts.normalized({"solver": solver, "device": device, "map": map, "timing": timing})
    return typing.cast("dict[str, typing.Any]",
                       json.loads(_core.study(os.fspath(scenario), _assignments(set), os.fspath(cache), parts)))


class Comparison(typing.NamedTuple):
    """What differs from a to b."""

    holds: bool
    """no condition is broken"""
    record: dict[str, typing.Any]
    """the document of `evenstep compare --json`"""


def compare(a: Run | Path, b: Run | Path, *, fail_if: typing.Sequence[str] = ("verdict",),
            allow_missing: bool = False) -> Comparison:
    """The figures of two runs, or of two folders of runs: a before, b after (docs/begin/compare.md).

    fail_if: conditions such as "latency > +5 %" or "worse > +10 %"

    ScenarioError: a file that is no summary, or a condition that cannot be read."""
    sides = [side._core if isinstance(side, Run) else os.fspath(side) for side in (a, b)]
    record, holds = _core.compare(sides[0], sides[1], list(fail_if), allow_missing)
    return Comparison(holds, json.loads(record))
