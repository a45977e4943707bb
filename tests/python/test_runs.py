"""run, check, size, study and compare."""
import gc
import json
import os
import signal
import subprocess
import sys
import threading
import weakref

import evenstep
import numpy as np
import pytest


def test_a_run_has_metrics_by_strategy_and_series_that_are_not_copied(spring):
    run = evenstep.run(spring)
    assert run.ok and run.verdict == "pass" and run.failures == []
    assert run.metrics["direct"]["left.interaction"]["velocity_jump"] > 4 * 0.1 / 450
    assert run.metrics["phase_locked"]["left.interaction"]["velocity_jump"] < 1e-6 * 0.1 / 450
    assert run.metrics["run"]["events.device.tick"]["sometimes"] == 2000  # of both strategies
    steps, ticks = run.series["phase_locked"].steps, run.series["phase_locked"].devices["left"].ticks
    assert ticks["at_ns"].tolist() == [k * 1_000_000 for k in range(1000)]
    assert ticks["force_N"].shape == (1000, 3)
    mapped = steps[steps["mapped"]]
    assert np.unique(mapped["emission_ns"] - mapped["read_ns"]).tolist() == [run.summary["latency"]["phase_locked"]["latency_ns"]]
    with pytest.raises(ValueError, match="read-only"):
        ticks["force_N"][0] = 0
    assert evenstep.run(spring).series["phase_locked"].devices["left"].ticks["force_N"].tobytes() == ticks["force_N"].tobytes()


def test_a_damaged_recording_is_warned_of(tmp_path):
    def interval(name, begin_us, length_us):
        return {"ph": "X", "pid": 1, "tid": 7, "cat": "kernel", "name": name, "ts": begin_us, "dur": length_us}
    events = [interval(*row) for begin in range(0, 400_000, 16_000)
              for row in (("draw", begin, 3000), ("step", begin + 3000, 900), ("step", begin + 4000, 900))]
    events[1]["dur"] = 1_600_000  # it runs over the next begin of its queue
    trace, scenario = tmp_path / "trace.json", tmp_path / "damaged.toml"
    trace.write_text(json.dumps({"traceEvents": events}))
    scenario.write_text('format = 1\n[run]\nduration = "20 ms"\nstrategies = ["direct"]\n[timing]\ntrace = "trace.json"\n'
                        '[scene]\nkind = "spring"\nstiffness = "100 N/m"\n'
                        '[[device]]\nname = "d"\nmotion = { kind = "still" }\n')
    for call in (lambda: evenstep.size(trace), lambda: evenstep.run(scenario), lambda: evenstep.check(scenario)):
        with pytest.warns(UserWarning, match="1 of 75 intervals .* were merged, clipped or left out"):
            call()


def test_an_option_without_what_it_belongs_to_is_refused():
    recording = "scenarios/recorded/small-paced30-basic.csv"
    for options, expected in (({"confidence": "95 %"}, "confidence=: error: goes with a rate or a span"),
                              ({"steps": 3}, "steps=: error: goes with step_time="),
                              ({"step_time": "1 ms"}, "steps=: error: goes with step_time="),
                              ({"rate": "100 %"}, "rate=: error: \"100 %\" must be above 0 % and below 100 %"),
                              ({"per": "0 h"}, "per=: error: must be above 0 h"),
                              ({"sampling": "2 s"}, "sampling=: error: \"2 s\" is no period of at most 1 s")):
        with pytest.raises(evenstep.ScenarioError) as refused:
            evenstep.size(recording, **options)
        assert str(refused.value).startswith(expected)


def test_an_array_keeps_the_run_that_it_lies_in(spring):
    run = evenstep.run(spring)
    core = weakref.ref(run)
    force = run.series["direct"].devices["left"].ticks["force_N"]
    before = force.copy()
    del run
    gc.collect()
    assert core() is None
    evenstep.run(spring, seed=2)  # would reuse the memory
    assert np.array_equal(force, before)


def test_what_does_not_hold_is_said_with_its_place(spring):
    run = evenstep.run(spring, set={"remap.latency": "11 ms"})
    assert not run.ok and run.exit_code == 1 and run.verdict == "fail"
    failure, = run.failures
    assert failure.startswith(f"{spring}:26:1: left.force.phase_locked underruns: ")
    assert "first at step 120" in failure and "15.064444 ms would do" in failure
    again = subprocess.run(run.command.replace("evenstep", os.environ["EVENSTEP_PROGRAM"], 1), shell=True, check=False,
                           cwd=spring.parent, capture_output=True, text=True)
    assert again.returncode == 1 and run.trace_hash in again.stdout


def test_an_error_has_file_line_column_and_remedy(spring):
    spring.write_text(spring.read_text().replace("steps = 15", "steps = 15\nvizualization = 1"))
    for call in (evenstep.run, evenstep.check, evenstep.size, evenstep.study):
        with pytest.raises(evenstep.ScenarioError, match="unknown key 'vizualization'") as caught:
            call(spring)
        error = caught.value
        assert (error.file, error.line, error.column, error.exit_code) == (str(spring), 12, 1, 2)
        assert error.remedy == "did you mean 'visualization'?"
        assert error.errors[0].message.endswith(error.remedy)


@pytest.mark.parametrize("option, what", [({"rate": "150 %"}, "rate=.*below 100 %"), ({"per": "0 h"}, "per=.*above 0 h"),
                                          ({"sampling": "2"}, "sampling=.*no rate"), ({"fits": "x 1"}, "fits="),
                                          ({"what_if": ["nothing"]}, "what_if=")])
def test_size_refuses_what_the_program_refuses(option, what):
    with pytest.raises(evenstep.ScenarioError, match=what):
        evenstep.size("scenarios/recorded/small-paced30-basic.csv", **option)


def test_size_knows_its_options():
    with pytest.raises(TypeError, match="no option 'latency'; it has set, sampling"):
        evenstep.size("scenarios/recorded/small-paced30-basic.csv", latency="1 ms")


@pytest.mark.parametrize("words, options", [
    (["scenarios/recorded/small-paced30-basic.csv", "--rate", "1 %", "--emission", "linear", "--split", "2"],
     {"rate": "1 %", "emission": "linear", "what_if": ["split 2"]}),
    (["scenarios/timing/jitter-10.toml", "--fits", "latency 20 ms", "--set", "run.seed=3"],
     {"fits": "latency 20 ms", "set": {"run.seed": 3}})])
def test_size_and_check_give_the_documents_of_the_program(words, options):
    def program(*command):
        told = subprocess.run([os.environ["EVENSTEP_PROGRAM"], *command, "--json"], capture_output=True, text=True, check=False)
        return json.loads(told.stdout)

    assert evenstep.size(words[0], **options) == program("size", *words)
    if words[0].endswith(".toml"):
        assert evenstep.check(words[0], set=options["set"]) == program("check", words[0], "--set", "run.seed=3")


def test_a_study_gives_its_document(spring):
    spring.write_text(spring.read_text() + """
[study]
error = "felt-force"
repeats = 1
""")
    study = evenstep.study(spring, set={"expect": []})
    assert {point["strategy"] for point in study["points"]} == {"direct", "phase_locked"}
    with pytest.raises(evenstep.ScenarioError, match="kind = \"tissue\""):
        evenstep.study(spring, set={"expect": [], "study.error": "state"})


def test_compare_takes_runs_and_folders(spring, tmp_path):
    before, after = evenstep.run(spring), evenstep.run(spring, set={"remap.latency": "16 ms"})
    assert evenstep.compare(before, before, fail_if=["worse > +0 %", "trace"]).holds
    slower = evenstep.compare(before, after, fail_if=["*.force.phase_locked schedule_latency > +1 %"])
    assert not slower.holds
    figures = {figure["metric"] for figure in slower.record["figures"]}
    assert "schedule_latency" in figures
    before.write(tmp_path / "a")
    after.write(tmp_path / "b")
    assert (tmp_path / "a" / "report.html").exists()
    folders = evenstep.compare(tmp_path / "a", tmp_path / "b", fail_if=["*.force.phase_locked schedule_latency > +1 %"])
    assert folders.record["figures"] == slower.record["figures"]
    with pytest.raises(evenstep.ScenarioError, match="no such"):
        evenstep.compare(before, tmp_path / "nowhere")


def test_ctrl_c_ends_a_run_and_leaves_the_next_one_alone(spring):
    code = f"""
import evenstep, os, signal, threading
class Waits:
    def __init__(self, request): pass
    def step(self, positions_m, step_s):
        if not interrupted: os.kill(os.getpid(), signal.SIGINT); interrupted.append(1)
        return 0 * positions_m
for threads in (1, 2):
    interrupted = []
    try:
        evenstep.run({str(spring)!r}, solver=Waits, set={{"run.duration": "1000 s", "expect": []}}, threads=threads)
    except KeyboardInterrupt:
        print("ended")
print(evenstep.run({str(spring)!r}).verdict, signal.getsignal(signal.SIGINT) is signal.default_int_handler)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert (done.stdout, done.stderr) == ("ended\nended\npass True\n", "")


def test_runs_of_several_threads_are_the_same(spring):
    traces = []
    threads = [threading.Thread(target=lambda: traces.append(evenstep.run(spring).trace_hash)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(traces)) == 1 and len(traces) == 4
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
