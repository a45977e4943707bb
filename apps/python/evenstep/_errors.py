"""The exceptions of evenstep. Each has the exit code that the program would have."""
from __future__ import annotations

import typing


class Place(typing.NamedTuple):
    """An error in a file. Lines and columns count from 1; 0 means the whole file."""

    file: str
    line: int
    column: int
    message: str

    @property
    def remedy(self) -> str:
        """What to do, as the message says it; "" where it does not."""
        return self.message.partition("; ")[2]


class Error(Exception):
    """What evenstep could not do.

    message: what is wrong, and what to do
    errors: every place in a file that is wrong, in order; may be empty
    file, line, column: those of the first one; "" and 0 without one
    remedy: what to do; "" if the message alone says it
    run: the run so far, if one had begun; otherwise None
    """

    exit_code = 3

    def __init__(self, message: str, errors: typing.Sequence[tuple[str, int, int, str]] = (), remedy: str = "",
                 run: typing.Any = None) -> None:
        super().__init__(message + (f"; {remedy}" if remedy else ""))
        self.message = message
        self.errors = [Place(*error) for error in errors]
        first = self.errors[0] if self.errors else Place("", 0, 0, "")
        self.file, self.line, self.column = first.file, first.line, first.column
        self.remedy = remedy or first.remedy
        self.run = run


class ScenarioError(Error):
    """A scenario, recording or option that evenstep refuses. Nothing ran."""

    exit_code = 2


class RunFailed(Error):
    """A run that could not go on. If a Python part raised, that exception is the __cause__."""


class NotReproducible(Error):
    """With repeat=True: the second run had another trace. `message` names the first event that differs."""

    exit_code = 4


class ArgumentError(Error, ValueError):
    """A number that a Remapper refuses. The call has changed nothing."""

    exit_code = 2


class OrderError(ArgumentError):
    """A time before the one of the call before, or begin_step and end_step that do not alternate."""


class SolverError(Exception):
    """For a solver to raise.

    reason: "bad-input" or "unstable-step", which a scenario's [expect_stop] can name
    """

    def __init__(self, message: str, remedy: str = "see what the solver does there", reason: str = "bad-input") -> None:
        super().__init__(message)
        if reason not in ("bad-input", "unstable-step"):
            raise ValueError(f"reason is '{reason}'; write \"bad-input\" or \"unstable-step\"")
        self.remedy, self.reason = remedy, reason


class Stopped(BaseException):
    """Raised by sleep_until() of a loop when the run is over, so that the loop is left. It is no Exception, so that a loop
    that survives a lost device does not survive its run."""

    def __init__(self, message: str = "the run is over", *_: object) -> None:
        super().__init__(message)
