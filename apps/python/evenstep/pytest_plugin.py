"""The plugin of pytest: scenarios are collected as tests, and a fixture is a virtual clock.

A file *.toml that pytest comes across, and that has a `format` and a [run] or a [case], is a test. Its tags are marks, so
`-m ci` chooses. One with the tag "long" is skipped unless it is named, or --evenstep-long is given."""
from __future__ import annotations

import pathlib
import tomllib
import typing

import pytest

from . import _errors, _runs
from ._clock import VirtualClock

RUN_FILES = ("summary.json", "study.json")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("evenstep")
    group.addoption("--evenstep-long", action="store_true", help="run scenarios with the tag \"long\", too")
    group.addoption("--evenstep-set", action="append", default=[], metavar="PATH=VALUE", help="override every scenario")


def _with_bases(file: pathlib.Path, depth: int = 0) -> dict[str, typing.Any]:
    """The table of a scenario, as far as it is read here: the keys of its bases where it has none itself."""
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    merged: dict[str, typing.Any] = {}
    for base in table.get("extends", []) if depth < 16 else []:  # what is wrong with a base is reported by the run
        if isinstance(base, str) and (file.parent / base).is_file():
            merged.update(_with_bases(file.parent / base, depth + 1))
    merged.update(table)
    return merged


def pytest_collect_file(file_path: pathlib.Path, parent: pytest.Collector) -> pytest.Collector | None:
    if file_path.suffix != ".toml" or any((file_path.parent / name).exists() for name in RUN_FILES):
        return None
    try:
        table = _with_bases(file_path)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        table = {"format": 1, "run": {}} if str(file_path) in parent.config.args else {}
    if "format" not in table or not ("run" in table or "case" in table):
        return None
    return typing.cast(pytest.Collector, ScenarioFile.from_parent(parent, path=file_path))


class ScenarioFile(pytest.File):
    def collect(self) -> typing.Iterator[pytest.Item]:
        yield ScenarioItem.from_parent(self, name="run")


class ScenarioFailed(Exception):
    """A run whose verdict is not "pass"."""

    def __init__(self, run: _runs.Run) -> None:
        super().__init__(run)
        self.run = run


class ScenarioItem(pytest.Item):
    def __init__(self, **given: typing.Any) -> None:
        super().__init__(**given)
        try:
            tags = _with_bases(self.path).get("tags", [])
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
            tags = []
        for tag in tags if isinstance(tags, list) else []:
            self.config.addinivalue_line("markers", f"{tag}: a tag of scenarios")
            self.add_marker(getattr(pytest.mark, str(tag).replace("-", "_")))
        named = any(pathlib.Path(argument.split("::")[0]).resolve() == self.path for argument in self.config.args)
        if "long" in tags and not named and not self.config.getoption("--evenstep-long"):
            self.add_marker(pytest.mark.skip(reason='it has the tag "long"; name it, or add --evenstep-long'))

    def runtest(self) -> None:
        try:
            file = self.path.relative_to(pathlib.Path.cwd())
        except ValueError:
            file = self.path
        run = _runs.run(file, set=self.config.getoption("--evenstep-set"))
        if not run.ok:
            raise ScenarioFailed(run)

    def repr_failure(self, excinfo: typing.Any, style: typing.Any = None) -> typing.Any:
        error = excinfo.value
        if isinstance(error, ScenarioFailed):
            none = ["nothing was asserted; write [[expect]]"] if error.run.verdict == "none" else []
            return "\n".join([*error.run.failures, *none, f"again: {error.run.command}"])
        if isinstance(error, _errors.Error):
            return str(error) + (f"\nagain: {error.run.command}" if error.run is not None else "")
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[pathlib.Path, int | None, str]:
        return self.path, 0, f"scenario: {self.path.name}"


@pytest.fixture
def virtual_clock() -> typing.Iterator[VirtualClock]:
    """A virtual clock that starts at 0, and is closed after the test."""
    with VirtualClock() as clock:
        yield clock
