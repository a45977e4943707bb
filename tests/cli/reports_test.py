"""What a run leaves on the disk, whatever happens to it: --junit, --trace-json, a full disk, a killed process, hostile
names. reports_test.py PROGRAM SOURCE CASE"""
import json
import os
import pathlib
import pty
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

program, source, case = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
sys.path.insert(0, str(source / "tests/reports"))
import check_junit  # noqa: E402
import check_trace  # noqa: E402

HOSTILE = '<script>alert("1")</script> ]]> \u202ethgir\u200f \x1b[2J\x1b]0;x\x07 %0A::error::x\n::warning::y & \' 100 %'
KILLS = 40

SCENARIO = """format = 1
name = {name}
[run]
duration = "{duration}"
warmup = "8 segments"
strategies = ["direct", "phase_locked"]
{run}
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
kind = "spring"
stiffness = "200 N/m"
[[device]]
name = "left"
rate = "1 kHz"
motion = {{ kind = "constant-velocity", velocity = ["0.01 m/s", "0 m/s", "0 m/s"] }}
render = {{ kind = "force", emission = "hold" }}
[remap]
latency = "15 ms"
"""
EXPECT = """[[expect]]
because = {because}
signal = "left.force.phase_locked"
metric = "late"
max = {most}
"""


def scenario(name="s", duration="0.6 s", most=0, because="b", run="", expect=True):
    quoted = json.dumps(name).replace("\\u007f", "?")
    text = SCENARIO.format(name=quoted, duration=duration, run=run)
    return text + (EXPECT.format(because=json.dumps(because), most=most) if expect else "")


def run(*arguments, **options):
    return subprocess.run([program, "run", *map(str, arguments)], capture_output=True, text=True, timeout=200, **options)


def write(folder, **scenarios):
    folder.mkdir(exist_ok=True)
    for name, text in scenarios.items():
        (folder / f"{name}.toml").write_text(text, "utf-8")
    return folder


def content(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def left_behind(place):
    return [path.name for path in place.iterdir() if path.name.startswith(".")]


SWEEP = """[sweep]
seeds = "0..3"
grid = {{ "remap.latency" = ["9 ms", "40 ms"] }}
{find}"""


def case_points_of_a_sweep_in_junit(place):
    """Each point that fails is a testcase, also with a hostile name. Points that pass are only counted. `merge` writes the same."""
    file = place / "s.toml"
    file.write_text(scenario(HOSTILE, because=HOSTILE) + SWEEP.format(find=""), "utf-8")

    def call(command, *arguments):
        return subprocess.run([program, command, *map(str, arguments)], capture_output=True, text=True, timeout=200, cwd=place)

    assert call("sweep", file, "--junit", place / "one.xml").returncode == 1
    root = check_junit.main(place / "one.xml", 4, 3, 0)
    cases = root.findall(".//testcase")
    assert cases[0].get("name") == "3 of 6 points pass" and len(cases[0]) == 0
    assert [case.get("name") for case in cases[1:]] == [f"seed {seed}, remap.latency 9 ms" for seed in (0, 1, 2)]
    for case in cases[1:]:
        assert "left.force.phase_locked late" in case.find("failure").get("message"), case.find("failure").attrib
        assert "--seed" in case.find("failure").text and "remap.latency=9 ms" in case.find("failure").text
    values = {item.get("name"): item.get("value") for item in root.findall(".//property")}
    assert values["points"] == "6" and values["passed"] == "3" and values["failed"] == "3", values
    for shard in "12":
        assert call("sweep", file, "--shard", f"{shard}/2", "--out", "parts").returncode <= 1
    parts = [place / f"parts/sweep-{shard}-of-2.jsonl" for shard in "21"]
    assert call("merge", *parts, "--out", place / "merged.jsonl", "--junit", place / "two.xml").returncode == 1
    assert (place / "two.xml").read_bytes() == (place / "one.xml").read_bytes()

    for latency, failures in (("40 ms", 0), ("9 ms", 1)):  # with `find` only the value found counts
        find = f'find = {{ smallest = "remap.latency", at_most = "{latency}" }}'
        file.write_text(scenario("found") + SWEEP.format(find=find), "utf-8")
        assert call("sweep", file, "--out", f"found-{failures}", "--junit", place / "f.xml").returncode == failures
        check_junit.main(place / "f.xml", 1, failures, 0)


def case_one_junit_file_for_a_call_tells_errors_from_failures(place):
    late = scenario(HOSTILE, because=HOSTILE).replace('"15 ms"', '"9 ms"')
    files = write(place / "in", passes=scenario(), fails=late, silent=scenario(expect=False), broken="format = 1\nnonsense = 2\n",
                  impossible=scenario().replace('"late"', '"error_at_stop"'))
    result = run(files, "--out", place / "out", "--junit", place / "all/junit.xml")
    assert result.returncode == 2, result
    root = check_junit.main(place / "all/junit.xml", "5", "2", "2")
    kinds = {pathlib.Path(suite.get("file")).stem: [problem.tag for problem in suite.iter() if problem.tag in ("error", "failure")]
             for suite in root}
    assert kinds == {"passes": [], "fails": ["failure"], "silent": ["failure"], "broken": ["error"], "impossible": ["error"]}, kinds
    shown = "".join("\ufffd" if ord(c) < 32 and c != "\n" else c for c in HOSTILE)
    assert any(suite.get("name") == shown for suite in root)
    for stem in kinds:
        check_junit.main(place / "out" / stem / "junit.xml")
    assert not left_behind(place / "all") and not left_behind(place / "out")
    result = run(write(place / "empty"), "--junit", place / "empty.xml")
    assert result.returncode == 2
    check_junit.main(place / "empty.xml", "1", "0", "1")
    result = run(files / "passes.toml", "--out", place / "one", "--junit", "/dev/stdout", "--json")
    assert result.returncode == 0 and "<testsuites tests=\"1\"" in result.stdout


def case_a_trace_for_the_viewer_is_written_where_it_is_asked_for_and_keeps_the_rules(place):
    write(place, s=scenario(HOSTILE))
    assert run(place / "s.toml", "--out", place / "plain").returncode == 0
    assert run(place / "s.toml", "--out", place / "traced", "--trace-json").returncode == 0
    assert set(content(place / "traced")) - set(content(place / "plain")) == {"trace.json"}
    check_trace.main(place / "traced/trace.json")


def case_a_killed_process_leaves_the_old_report_or_the_new_one_and_the_next_run_cleans_up(place):
    write(place, s=scenario(duration="4 s"))
    arguments = [place / "s.toml", "--out", place / "out/run", "--junit", place / "out/j.xml", "--trace-json", "--allow-degraded"]
    whole, took = {}, 0
    for seed in (1, 2):
        began = time.monotonic()
        assert run(*arguments, "--seed", seed).returncode == 0
        took = max(took, time.monotonic() - began)
        whole[seed] = (content(place / "out/run"), (place / "out/j.xml").read_bytes())
    assert whole[1] != whole[2]
    states = {"old": 0, "new": 0}
    draw = random.Random(1)
    seed = 2
    for number in range(KILLS):
        other = 3 - seed
        process = subprocess.Popen([program, "run", *map(str, arguments), "--seed", str(other)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        time.sleep(draw.uniform(0, 1.2 * took))
        process.send_signal(signal.SIGKILL)
        process.wait()
        found = content(place / "out/run")
        json.loads(found.pop("summary.json"))  # it has seconds of the solver, which differ from run to run
        for candidate in (seed, other):
            expected = dict(whole[candidate][0])
            expected.pop("summary.json")
            if found == expected:
                states["old" if candidate == seed else "new"] += 1
                seed = candidate
                break
        else:
            raise AssertionError(f"kill {number}: neither the old report nor the new one is there, or not whole")
        assert (place / "out/j.xml").read_bytes() in (whole[1][1], whole[2][1]), f"kill {number}"
    print(states)
    assert states["old"] > 0
    assert run(*arguments).returncode == 0
    assert not left_behind(place / "out"), left_behind(place / "out")


def case_processes_that_write_to_one_place_at_once_all_end_as_if_they_were_alone(place):
    """Into the usual folder, and into that of --out; some are killed meanwhile. One whole run is there, and nothing beside it."""
    write(place, s=scenario())
    draw = random.Random(1)
    for out in ([], ["--out", "out/run"]):
        folder = place / (out[1] if out else "runs/s")
        arguments = [program, "run", "s.toml", *out, "--junit", "j.xml"]
        traces = {}
        for seed in range(4):
            assert subprocess.run([*arguments, "--seed", str(seed)], cwd=place, capture_output=True).returncode == 0
            traces[json.loads((folder / "summary.json").read_text())["seed"]] = (folder / "events.bin").read_bytes()
        for round_ in range(15):
            running = [subprocess.Popen([*arguments, "--seed", str(seed)], cwd=place, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, text=True) for seed in range(4)]
            victim = draw.randrange(4)
            time.sleep(draw.uniform(0, 0.1))
            running[victim].kill()
            for number, process in enumerate(running):
                err = process.communicate()[1]
                assert process.returncode == 0 or number == victim, (round_, process.returncode, err)
            seed = json.loads((folder / "summary.json").read_text())["seed"]
            assert (folder / "events.bin").read_bytes() == traces[seed], "files of two runs are mixed"
            check_junit.main(place / "j.xml")
        assert subprocess.run(arguments, cwd=place, capture_output=True).returncode == 0
        assert not left_behind(folder.parent) and not left_behind(place), left_behind(place)


def case_merges_into_one_file_at_once_give_it_whole_or_say_why_not(place):
    write(place, s=scenario("s") + SWEEP.format(find=""))

    def call(*arguments):
        return subprocess.Popen([program, *arguments], cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    for shard in ("1/2", "2/2"):
        assert call("sweep", "s.toml", "--shard", shard, "--out", "parts").wait() <= 1
    merge = ["merge", "parts/sweep-1-of-2.jsonl", "parts/sweep-2-of-2.jsonl", "--out", "merged.jsonl"]
    assert call(*merge).wait() == 1
    whole = (place / "merged.jsonl").read_bytes()
    for _ in range(15):
        for process in [call(*merge) for _ in range(4)]:
            err = process.communicate()[1]
            assert process.returncode == 1 or (process.returncode == 3 and "another process" in err), err
            assert (place / "merged.jsonl").read_bytes() == whole
    assert not [path.name for path in place.iterdir() if path.name.endswith(".merging")] and not left_behind(place)


def case_a_full_disk_leaves_the_old_report_whole_and_says_so(place):
    write(place, s=scenario(duration="4 s"))
    arguments = [place / "s.toml", "--out", place / "out/run", "--junit", place / "out/j.xml"]
    assert run(*arguments).returncode == 0
    before = content(place / "out/run"), (place / "out/j.xml").read_bytes()
    largest = max(map(len, before[0].values()))
    for limit in [0, 1, 100, 5000, *range(20000, largest, max(1, largest // 12))]:
        result = run(*arguments, "--seed", 2, restore_signals=False,
                     preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        assert result.returncode == 3 and "cannot write" in result.stderr, (limit, result)
        assert (content(place / "out/run") == before[0]), limit
        assert not left_behind(place / "out"), left_behind(place / "out")
    for device in ("/dev/full",):
        result = run(place / "s.toml", "--out", place / "out/run", "--junit", device)
        assert result.returncode == 3 and "No space left" in result.stderr, result
    small_disk(place, arguments)


CASE = """format = 1
name = "c"
[case]
kind = "oscillator"
methods = ["symplectic-euler"]
values = [1]
most_steps = 50
[[expect]]
signal = "case.*.*"
metric = "cells"
equals = 1
"""


def calls_of_every_command(place):
    """A call of each command that --help lists, by its name. A new command needs an entry here."""
    swept = scenario("s") + SWEEP.format(find="")
    write(place, s=scenario(), swept=swept, case=CASE)
    for ready in ('run s.toml --out a --set "run.duration=1.5 s"', "run s.toml --out b", "sweep swept.toml --shard 1/1 --out parts",
                  'run s.toml --clock wall --record live.rec --set "remap.lead=3 ms" --out live'):
        result = subprocess.run([program, *shlex.split(ready)], cwd=place, capture_output=True, text=True, timeout=100)
        assert result.returncode <= 1, result
    return {
        "run": "s.toml", "check": "s.toml", "devices": "", "list": ".", "study": "s.toml --out study",
        "record": "s.toml --seconds 1 --out recorded.csv", "replay": "live.rec", "import": "live.rec --out imported.csv",
        "fit": "a/timing.csv", "size": "a/timing.csv", "advise": "a/timing.csv --out advice", "sweep": "swept.toml --out swept",
        "catalogue": "case.toml --out catalogue", "merge": "parts/sweep.jsonl --out merged.jsonl",
        "shrink": 'swept.toml --seed 0 --set "remap.latency=9 ms" --out shrunk', "diff": "a b", "compare": "a b", "index": "a",
        "init": "first", "schema": "", "completion": "", "manual": ""}


FILES = ("run s.toml --junit", "compare a b --markdown", "compare a b --html", "size a/timing.csv --figure",
         "size a/timing.csv --report", "size a/timing.csv --timing", "sweep swept.toml --out swept-junit --junit",
         "merge parts/sweep.jsonl --out merged-junit.jsonl --junit", "replay live.rec --timing",
         "import live.rec --out")


def case_every_command_fails_if_what_it_prints_or_writes_is_cut(place):
    """Onto a full disk, and into a pipe that nobody reads. A command whose text is all that it gives ends well then: its reader
    has read as much as it wanted."""
    calls = calls_of_every_command(place)
    shown = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    commands = re.findall(r"^  ([a-z]+) ", shown[shown.lower().index("\ntest:"):], re.M)
    assert set(calls) == set(commands), f"not called here, or no command: {set(calls) ^ set(commands)}"
    lines = [f"{command} {call}" for command, call in calls.items()]
    lines += ["--help", "--version", "help", *(f"{command} --help" for command in calls)]
    for line in lines:
        def to(out):
            shutil.rmtree(place / "first", ignore_errors=True)
            shutil.rmtree(place / "swept", ignore_errors=True)
            return subprocess.run([program, *shlex.split(line)], cwd=place, stdout=out, stderr=subprocess.PIPE, text=True,
                                  timeout=200)
        with open("/dev/full", "w") as full:
            result = to(full)
        assert result.returncode == 3 and "stdout has not taken all" in result.stderr, (line, result)
        read_end, write_end = os.pipe()
        os.close(read_end)
        result = to(write_end)
        os.close(write_end)
        only_text = line.split()[0] in ("list", "schema", "completion", "manual", "help") or line.startswith("--")
        assert result.returncode == (0 if only_text else 3), (line, result)
        assert ("nobody reads it" in result.stderr) != only_text, (line, result)
    for line in FILES:
        result = subprocess.run([program, *shlex.split(line), "/dev/full"], cwd=place, capture_output=True, text=True,
                                timeout=200)
        assert result.returncode == 3 and "No space left" in result.stderr, (line, result)


def case_a_closed_stdout_is_said_and_nothing_is_printed_into_a_file(place):
    write(place, s=scenario())
    assert run(place / "s.toml", "--out", place / "before").returncode == 0
    result = subprocess.run(["sh", "-c", '"$@" >&-', "sh", program, "run", "s.toml", "--out", "after"], cwd=place,
                            capture_output=True, text=True)
    assert result.returncode == 3 and "stdout has not taken all" in result.stderr, result
    for name, text in content(place / "before").items():
        if name not in ("summary.json", "junit.xml", "report.html"):  # they name the folder, or seconds that were measured
            assert (place / "after" / name).read_bytes() == text, name


def small_disk(place, arguments):
    """The same on a file system that is really full, where one can be mounted."""
    mounted = place / "disk"
    mounted.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=900k", "none", mounted], capture_output=True).returncode != 0:
        print("no file system can be mounted here: RLIMIT_FSIZE and /dev/full alone")
        return
    try:
        short = ["--set", "run.duration=0.5 s"]
        assert run(place / "s.toml", "--out", mounted / "run", *short).returncode == 0
        before = content(mounted / "run")
        result = run(place / "s.toml", "--out", mounted / "run", "--trace-json")
        assert result.returncode == 3 and "No space left" in result.stderr, result
        assert content(mounted / "run") == before and not left_behind(mounted)
    finally:
        subprocess.run(["umount", mounted], check=True)


def case_nothing_in_a_name_commands_a_terminal(place):
    write(place, s=scenario(HOSTILE, because=HOSTILE, most=0).replace('"15 ms"', '"9 ms"'))
    shown = bytearray()

    def keep(descriptor):
        data = os.read(descriptor, 4096)
        shown.extend(data)
        return data

    out = os.dup(1)
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    pty.spawn([program, "run", str(place / "s.toml"), "--out", str(place / "run")], keep, lambda descriptor: b"")
    os.dup2(out, 1)
    text = bytes(shown).decode("utf-8")
    assert "<script>" in text
    for own in ("\r\n", "\r\x1b[K", *(f"\x1b[{code}m" for code in (0, 31, 32, 33, 35, 90))):
        text = text.replace(own, "")
    assert not [c for c in text if (ord(c) < 32 and c != "\n") or c in "\x7f\u202e\u200f"], text


if __name__ == "__main__":
    folder = pathlib.Path(tempfile.mkdtemp(prefix="evenstep-reports-"))
    try:
        globals()["case_" + case](folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
