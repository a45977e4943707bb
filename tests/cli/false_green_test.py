"""Tries at a verdict that is green for the wrong reason: scenarios and calls that judge nothing, or whose intent is violated. Each
must not exit with 0, and must name its reason. false_green_test.py PROGRAM"""
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

program = sys.argv[1]
BASE = """format = 1
name = "base"
{top}
[run]
duration = "0.5 s"
warmup = "0.2 s"
strategies = ["direct", "phase_locked"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
kind = "spring"
stiffness = "200 N/m"
[[device]]
name = "left"
motion = {{ kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"], start = "smooth 0.1 s" }}
"""
EXPECT = '[[expect]]\nsignal = "left.force.phase_locked"\nmetric = "late"\nmax = 0\n'
CASE = """format = 1
name = "c"
[case]
kind = "stiffness"
methods = ["symplectic-euler", "implicit-euler"]
solvers = ["cpu-double"]
values = [1e2, 1e4, 1e9]
[[expect]]
signal = "case.symplectic-euler.*"
metric = "refused"
equals = 2
"""
F, I = "left.force.phase_locked", "left.interaction.phase_locked"
LIMITED = "device.left.force_limit=1 uN"
SINE = 'device.left.motion={kind="sine",amplitude=["50 mm","0 m","0 m"],frequency="1 Hz"}'
SPIKES = 'timing.spikes={rate="1000 Hz",cost="5 ms"}'
rows = []


def row(code, reason, call, *sets, environment=None):
    rows.append((code, reason, [*shlex.split(call), *(word for one in sets for word in ("--set", one))], environment))


def run(code, reason, *sets):
    row(code, reason, "run base.toml", *sets)


def expect(code, reason, signal, metric, limits, *sets):
    run(code, reason, f'expect=[{{signal="{signal}",metric="{metric}"{"," if limits else ""}{limits}}}]', *sets)


def case(code, reason, metric, limits, *sets):
    row(code, reason, "run case.toml", f'expect=[{{signal="case.symplectic-euler.*",metric="{metric}",{limits}}}]', *sets)


# What is judged is empty.
for warmup in ("0.5 s", "10 s"):
    run(2, "leave nothing to judge", f"run.warmup={warmup}")
run(2, "no sample", "run.warmup=0.4999 s")
for signal, metric, limit, warmup in (
        (F, "velocity_jump", "1 N", "0.4985 s"), (F, "deviation_max", "1 N", "0.4985 s"), (F, "residual_20_500_hz", "1 N", "0.4975 s"),
        (I, "velocity_jump", "1 m", "0.498 s"), (I, "error_at_stop", "1 m", "0.2 s"), (F, "onset_delay", "1 s", "0.2 s")):
    expect(2, "no sample", signal, metric, f'max="{limit}"', f"run.warmup={warmup}")
expect(2, "no sample", I, "back_steps", "equals=0", "run.warmup=0.4995 s")
for metric in ("gain", "distortion"):
    expect(2, "nan", F, metric, "max=2", SINE)
    expect(2, "nan", F, metric, "max=2,expect_fail=true", SINE)
expect(2, "nan", F, "phase_delay", 'max="1 s"', SINE)
expect(2, "no sample", "closed_loop.left.*", "stable", "min=0")
expect(2, "no sample", "events.completion.step", "deadline_misses", "max=0")
expect(2, "no sample", "events.device.nothing", "deadline_misses", "max=0")
expect(2, "no sample", "events.*.x", "lateness_max", 'max="1 s"')
expect(2, "no sample", "events.device.hope", "sometimes", "max=1")
expect(2, "nothing to recover from", F, "recovery_time", 'max="1 s"')
expect(2, "nothing to recover from", F, "recovered", "equals=1")
expect(1, "NO VERDICT", F, "recovered", "equals=1", 'device.left.faults=[{kind="lost",at="0.3 s"}]',
       'run.faults_off=["device.left.faults.0"]')
run(1, "NO VERDICT", "expect=[]")
expect(1, "NO VERDICT", F, "late", 'max=0,clock="wall"')
expect(1, "NO VERDICT", F, "late", 'min=1,expect_fail=true,clock="wall"')
# What is programmed does not happen.
for late in ('timing.hitch={every="10 s",visualization="20 ms"}', 'device.left.faults=[{kind="lost",at="10 s"}]',
             'device.left.faults=[{kind="lost",at="0.3 s"},{kind="lost",at="10 s"}]', "device.left.unplug=10 s",
             'timing.changes=[{at="10 s",visualization="12 ms"}]',
             'timing.changes=[{at="0.3 s",visualization="12 ms"},{at="10 s",visualization="12 ms"}]', "run.interrupt=10 s"):
    run(2, "the run has ended by 500 ms", late)
run(2, "the run has ended by 500 ms", SPIKES, 'timing.disturbed={from="10 s",to="20 s"}')
# expect_stop
for reason in ("unstable-step", "diverged", "bad-input", "device", "interrupted"):
    run(1, "but it ran to its end", f'expect_stop={{reason="{reason}"}}')
STOP = "run.interrupt=0.3 s"
run(3, "interrupted at 0.3 s", 'expect_stop={reason="device"}', STOP)
run(1, 'expected to say "xyz"', 'expect_stop={reason="interrupted",message="xyz"}', STOP)
run(1, "earlier or later", 'expect_stop={reason="interrupted",at_least_step=1000}', STOP)
run(1, "earlier or later", 'expect_stop={reason="interrupted",at_most_step=10}', STOP)
run(2, "nothing can hold", 'expect_stop={reason="interrupted",at_most_step=10,at_least_step=20}', STOP)
run(2, "no sample", 'expect_stop={reason="interrupted"}', "run.interrupt=0.1 s")
run(3, "is gone", "device.left.unplug=0.3 s")
run(3, "is gone", "device.left.unplug=0.3 s", "expect.0.expect_fail=true")
run(1, "was expected to fail", 'expect_stop={reason="device"}', "device.left.unplug=0.3 s", "expect.0.expect_fail=true")
# expect_fail
expect(1, "was expected to fail", F, "late", "max=0,expect_fail=true")
expect(1, "was expected to fail", "left.force.*", "late", "max=0,expect_fail=true")
expect(2, "did you mean 'late'", F, "lates", "max=0,expect_fail=true")
expect(2, "there is no strategy 'paper'", "left.force.paper", "late", "max=0,expect_fail=true")
# saturated signals
for metric, limits in (("velocity_jump", 'max="1 uN"'), ("velocity_jump", 'max="1 uN",expect_fail=true'),
                       ("velocity_jump", 'min="1 N",expect_fail=true'), ("error_max", 'max="1 N"')):
    expect(2, "so its shape says nothing", F, metric, limits, LIMITED)
expect(2, "so its shape says nothing", F, "jump_max", 'max="2 uN"', "device.left.slew_limit=1 mN/s")
expect(1, "FAIL", F, "saturated", "max=0", LIMITED)
# confidence
expect(2, "needs a max", F, "underrun_rate", 'min="0 %",confidence="95 %"')
expect(2, "'late' has none", F, "late", 'max=1,confidence="95 %"')
expect(1, "FAIL", F, "underrun_rate", 'max="1 %",confidence="95 %",seeds=2')
for most in (0, 100, 200):
    expect(2, "no number of seeds shows", F, "underrun_rate", f'max="{most} %",confidence="95 %"')
expect(2, "goes with 'confidence'", F, "underrun_rate", 'max="1 %",seeds=3')
expect(2, "no sample", "left.force.direct", "underrun_rate", 'max="50 %",confidence="95 %"')
# signals, patterns, limits
for signal, reason in (("right.force.*", "there is no device 'right'"), ("left.forces.*", "did you mean 'force'"),
                       ("Left.force.direct", "there is no device 'Left'"), ("left.force.direct ", "there is no strategy 'direct '"),
                       ("left.force.paper", "there is no strategy 'paper'"), ("**", "is not a signal"), ("*", "is not a signal"),
                       ("left.force", "is not a signal"), ("run", "unknown metric 'late'")):
    expect(2, reason, signal, "late", "max=0")
for limits, reason in (("min=3,max=1", "nothing can hold"), ("max=inf", "is not a number"), ('max="nan"', "does not begin with a number"),
                       ("equals=0,min=0", "min and max in one"), ("at=[1],max=5", "picks cells of a [case]"),
                       ('max=0,clock="Wall"', "did you mean 'wall'"), ("max=0,expect_fial=true", "unknown key")):
    expect(2, reason, F, "late", limits)
expect(2, "needs a unit", F, "jump_max", "max=1")
row(2, "needs a unit", "check base.toml", 'expect=[{signal="left.force.*",metric="jump_max",max=1}]')
expect(2, "unit of length", F, "jump_max", 'max="1 mm"')
expect(2, "has no limit", F, "late", "because=\"x\"")
# overrides
for override, reason in (("expects=[]", "did you mean 'expect'"), ("expect.7.max=3", "there is no element 7"),
                         ("expect.-1.max=3", "write an index"), ("expect.0.mx=3", "did you mean 'max'"),
                         ("device.rigth.rate=500 Hz", "one of: left"), ("run.strategies=[]", "name at least one"),
                         ("expect_append=[]", "before --set is applied")):
    run(2, reason, override)
# cases
for at in ("[]", "[1e9,1e2]", "[1]"):
    case(2, "the least and the greatest", "refused", f"max=5,at={at}")
case(2, "no sample", "refused", "max=5,at=[5,6]")
case(2, "no sample", "error", "max=5,at=[1e9,2e9]")
for override in ("case.values=[]", "case.methods=[]", "case.solvers=[]", "case.values=[1e2,1e2]", "run.warmup=1 s", "expect.0.clock=wall"):
    row(2, "error", "run case.toml", override)
row(2, "no sample", "run case.toml", 'case.solvers=["opencl"]', 'expect=[{signal="case.*.opencl",metric="diverged",max=0}]',
    environment={"OCL_ICD_VENDORS": "empty"})
# files
for call, code, reason in (
        ("run empty", 2, "no scenario"), ("run long", 2, "every scenario is left out"), ("run link", 2, "no such file"),
        ("run hides", 1, "1 failed"), ("run base.toml empty", 2, "no scenario"), ("run base.toml bad.toml", 1, "1 failed"),
        ("run bad.toml broken.toml base.toml", 2, "2 failed"), ("run bad.toml --allow-degraded --allow-no-expectations", 1, "FAIL"),
        ("run base.toml --junit base.toml/x.xml", 3, "cannot be written"), ("run base.toml --out empty/..", 3, "not a run folder"),
        ("compare a bad", 1, "FAIL"), ("compare a none", 1, "FAIL"), ("compare empty empty", 2, "has no run"),
        ("compare a a --fail-if 'paper latency > +1 %'", 1, "no figure that it could judge"),
        ("compare a a --fail-if 'nonsense > +1 %'", 2, "is no metric"), ("compare a a --fail-if ''", 2, "expected a metric"),
        ("diff empty empty", 2, "cannot read"), ("index empty", 2, "has no run"), ("catalogue empty", 2, "no scenario"),
        ("catalogue long", 2, "every scenario is left out"), ("replay base.toml", 2, "is no recording"),
        ("merge parts/sweep-1-of-2.jsonl --out m.jsonl", 2, "lack 1 of 2 points"),
        ("merge parts/sweep-1-of-2.jsonl parts/sweep-1-of-2.jsonl --out m.jsonl", 2, "merge each part once"),
        ("sweep silent.toml", 2, "every point would pass"), ("sweep never.toml", 1, "no point reached it"),
        ("sweep off.toml", 1, "no point judged"), ("sweep base.toml", 2, "has no [sweep]")):
    row(code, reason, call)


def prepare(place):
    os.chdir(place)
    for folder in ("empty", "long", "link", "hides/sub"):
        os.makedirs(folder)
    base, sweep = BASE.format(top="") + EXPECT, "[sweep]\nseeds = [1, 2]\n"
    fault = base.replace("[[expect]]", 'faults = [{ kind = "lost", at = "0.3 s" }]\n[[expect]]')
    texts = {"base": base, "bad": base.replace("max = 0", "min = 5"), "broken": base + "nonsense = 1\n", "case": CASE,
             "long/a": BASE.format(top='tags = ["long"]') + EXPECT, "link/base": base, "hides/base": base,
             "hides/sub/bad": base.replace("max = 0", "min = 5"), "swept": base + sweep, "silent": BASE.format(top="") + sweep,
             "never": base + sweep + '[[sometimes]]\nname = "x"\nsignal = "left.force.direct"\nmetric = "late"\nmin = 1\n',
             "off": fault.replace('"late"\nmax = 0', '"recovered"\nmin = 1').replace("0.5 s", "1 s") +
             "[sweep]\nswarm = true\nseeds = 1\n"}
    for name, text in texts.items():
        pathlib.Path(name + ".toml").write_text(text)
    os.symlink("nowhere.toml", "link/x.toml")
    pathlib.Path("hides/sub/summary.json").write_text("{}")
    for ready in ("run base.toml --out a", "run bad.toml --out bad", "run base.toml --out none --set expect=[]",
                  "sweep swept.toml --shard 1/2 --out parts"):
        subprocess.run([program, *ready.split()], capture_output=True)


def main(place):
    prepare(place)
    assert subprocess.run([program, "run", "base.toml"], capture_output=True).returncode == 0, "the control does not pass"
    assert subprocess.run([program, "run", "case.toml"], capture_output=True).returncode == 0, "the control does not pass"
    assert len(rows) >= 100, len(rows)
    wrong = 0
    for code, reason, words, environment in rows:
        result = subprocess.run([program, *words], capture_output=True, text=True, timeout=60,
                                env={**os.environ, **(environment or {})})
        said = (result.stdout + result.stderr).replace(" ".join(words), "")
        if result.returncode == code and reason in said:
            continue
        wrong += 1
        print(f"exit {result.returncode} instead of {code}, or no '{reason}': evenstep {shlex.join(words)}\n{said[-600:]}\n")
    print(f"{len(rows)} tries, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    folder = tempfile.mkdtemp(prefix="evenstep-false-green-")
    try:
        sys.exit(main(folder))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
