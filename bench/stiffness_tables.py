"""The largest stable stiffness of the tables of one spring, one mode and the lattice block in docs/stiffness.md.

stiffness_tables.py EVENSTEP [TABLE ...]    TABLE: spring, delay, device, mode or lattice; default all. One line for each cell:
                                            table, row, column, then raw and remapped in N/m
"""
import json
import os
import subprocess
import sys
import tempfile

FOLDER = "scenarios/closed-loop"
JITTER = ['timing.jitter={ visualization = "lognormal 10 %", step = "lognormal 10 %" }',
          'study.stiffness_limit={ from = "20 N/m", to = "30000 N/m", seeds = 3 }']
PID = '{{ travel = ["40 mm", "40 mm", "0 mm"], full_scale = "1000 N", full_slope = "{}", gain = 1.0, ' \
      'springs = ["x", "y"], firmware_rate = "{}" }}'


def local(alpha, more=""):
    return f'device.left.render={{ kind = "local", alpha = {alpha}{more} }}'


def limit(least, most="30000 N/m"):
    return f'study.stiffness_limit={{ from = "{least} N/m", to = "{most}" }}'


def spring():
    yield "force", "", "price-study", []
    for alpha in ("0.8", "0.9", "1", "1.0332", "1.1", '"auto"', "1.2", "1.5", "2"):
        yield "local", f"alpha {alpha}", "price-local-study", [local(alpha)]


def delay():
    for row, more in (("device delay 0", []), ("device delay 1 ms", ['device.left.delay="1 ms"']),
                      ("device delay 2 ms", ['device.left.delay="2 ms"'])):
        for alpha in ("0.9", "1", "1.1", "1.2", '"auto"'):
            yield row, f"alpha {alpha}", "price-local-study", [local(alpha), *more]
    for friction in ("2 N s/m", "5 N s/m"):
        for alpha in ("1", "1.1"):
            yield f"friction {friction}", f"alpha {alpha}", "price-local-study", [
                local(alpha), f'device.left.motion.damping="{friction}"']
    for alpha in ("0.9", "1", "1.1", '"auto"'):
        yield "10 % jitter", f"alpha {alpha}", "price-local-study", [local(alpha), *JITTER]
    yield "10 % jitter", "force", "price-local-study", ['device.left.render={ kind = "force" }', *JITTER]


def device():
    for rate, slope in (("1 kHz", "20 kN/m"), ("4 kHz", "20 kN/m"), ("8 kHz", "20 kN/m"), ("4 kHz", "1000 N/m"),
                        ("4 kHz", "2000 N/m"), ("4 kHz", "4000 N/m")):
        yield rate, slope, "price-device-spring-study", [f"device.left.pid={PID.format(slope, rate)}",
                                                          'device.left.force_limit="1000 N"']


def mode():
    renders = {
        "force": '{ kind = "force" }',
        "local instantaneous": '{ kind = "local" }',
        "local settled": '{ kind = "local", stiffness = "settled" }',
        "settled, alpha 1.1": '{ kind = "local", stiffness = "settled", alpha = 1.1 }',
        "smith exact": '{ kind = "smith", factor = 1.0 }',
        "smith 10 % too stiff": '{ kind = "smith", factor = 1.1 }',
        "smith 20 % too soft": '{ kind = "smith", factor = 0.8 }',
    }
    for frequency in ("3 Hz", "7 Hz", "15 Hz", "30 Hz", "60 Hz"):
        for column, render in renders.items():
            yield frequency, column, "tissue-static", [f'scene.frequency="{frequency}"', f"device.left.render={render}",
                                                       'run.strategies=["phase_locked"]', limit(10)]


def lattice():
    for tool in ("grab", "probe"):
        for column, render in (("force", '{ kind = "force" }'), ("local instantaneous", '{ kind = "local" }'),
                               ("local settled", '{ kind = "local", stiffness = "settled" }')):
            yield tool, column, f"lattice-{tool}-study", [f"device.left.render={render}"]
    yield "probe, without the gap", "local instantaneous", "lattice-probe-study", [
        'device.left.render={ kind = "local", gap = false }']


TABLES = {"spring": spring, "delay": delay, "device": device, "mode": mode, "lattice": lattice}


def search(evenstep, file, sets):
    with tempfile.TemporaryDirectory() as folder:
        command = [evenstep, "study", f"{FOLDER}/{file}.toml", "--json", "--out", os.path.join(folder, "out"),
                   "--set", "expect=[]"]
        for setting in sets:
            command += ["--set", setting]
        result = subprocess.run(command, capture_output=True, text=True)
        if result.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{result.stderr}")
        return json.loads(result.stdout)["limits"]


def main(evenstep, *names):
    for name in names or TABLES:
        for row, column, file, sets in TABLES[name]():
            found = {one["strategy"]: (one["state"], one["stable_N_per_m"]) for one in search(evenstep, file, sets)}
            cells = ", ".join(f"{strategy} {'above ' if state == 'above' else ''}{stable:.5g}"
                              for strategy, (state, stable) in found.items())
            print(f"{name} | {row} | {column} | {cells}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
