"""Every scenario of the paper and of timing has the trace from Python that it has from the program."""
import json
import os
import subprocess
from pathlib import Path

import evenstep

# Those that take longer than a second are shorter here: the rest of such a run is more of the same.
SHORTER = {"figure-1": ["run.duration=0.5 s"], "ten-minutes": ["run.duration=10 s"], "ten-minutes-jitter": ["run.duration=10 s"],
           "variable-step-substeps": ["run.duration=0.5 s"]}
LEFT_OUT = {"figure-1-minute"}  # figure-1, on a cpu solver that takes ten seconds for a second
FILES = sorted(file for folder in ("paper", "timing") for file in Path("scenarios", folder).glob("*.toml")
               if file.stem not in LEFT_OUT)


def program(files, folder, *options):
    # It need not write series and events.
    done = subprocess.run([os.environ["EVENSTEP_PROGRAM"], "run", *map(str, files), "--json", "--out", str(folder),
                           "--set=run.keep=summary", *options], capture_output=True, text=True, check=False)
    runs = json.loads(done.stdout)
    return {run["file"]: run for run in (runs if isinstance(runs, list) else [runs])}


def test_every_trace_and_every_metric_is_that_of_the_program(tmp_path):
    assert len(FILES) > 40
    whole = [file for file in FILES if file.stem not in SHORTER]
    expected = program(whole, tmp_path / "whole")
    for file in FILES:
        if file.stem in SHORTER:
            assignments = SHORTER[file.stem]
            expected |= program([file], tmp_path / file.stem, *(f"--set={one}" for one in assignments))
            run = evenstep.run(file, set=assignments)
        else:
            run = evenstep.run(file)
        told = expected[str(file)]
        assert (run.trace_hash, run.verdict) == (told["trace_hash"], told["verdict"]), file
        ours = run.summary["metrics"]
        for metrics in (ours, told["metrics"]):
            for signal, values in list(metrics.items()):
                values.pop("solver_seconds", None)  # how long it took, as in the signal "run"
                if signal == "run" or signal.startswith("events."):  # without series no event is counted
                    del metrics[signal]
        assert ours == told["metrics"], file
