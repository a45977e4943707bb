"""evenstep: even simulation steps and forces from an unevenly running haptic simulator, and tests of them.

    run = evenstep.run("scenarios/paper/figure-1-spring.toml")
    run.metrics["paper"]["left.interaction"]["velocity_jump"]       # m
    run.series["paper"].devices["left"].ticks["force_N"]            # N, shape (ticks, 3)

docs/parts/python.md explains it all."""
from . import _core
from ._clock import LoopTime, Reading, Remapper, StepInput, Time, VirtualClock, tick_ns
from ._errors import ArgumentError, Error, NotReproducible, OrderError, Place, RunFailed, ScenarioError, SolverError, Stopped
from ._parts import (Device, DeviceRequest, Grip, Map, MapRequest, Segment, Solver, SolverRequest, TimingRequest)
from ._runs import Comparison, DeviceSeries, Run, StrategySeries, check, compare, run, size, study

__version__: str = _core.version
__all__ = ["ArgumentError", "Comparison", "Device", "DeviceRequest", "DeviceSeries", "Error", "Grip", "LoopTime", "Map",
           "MapRequest", "NotReproducible", "OrderError", "Place", "Reading", "Remapper", "Run", "RunFailed",
           "ScenarioError", "Segment", "Solver", "SolverError", "SolverRequest", "StepInput", "Stopped", "StrategySeries",
           "Time", "TimingRequest", "VirtualClock", "check", "compare", "run", "size", "study", "tick_ns"]
