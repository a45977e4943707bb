"""A mass on a spring in MuJoCo, which the hand pulls by another spring, under the uneven timing of the paper's figure 1.

    python3 mujoco_mass.py

Debian has no bindings of MuJoCo for Python, so its C library is called (libmujoco-dev, and a C compiler for mujoco_fields.c).
"""
import ctypes
import subprocess
import sys
import tempfile
from pathlib import Path

import evenstep
import numpy as np

HERE = Path(__file__).resolve().parent
COUPLING = 500.0  # N/m, from the hand to the mass
MODEL = """<mujoco><option gravity="0 0 0" integrator="Euler"/><worldbody><body>
<joint type="slide" axis="1 0 0" stiffness="200" damping="6"/><joint type="slide" axis="0 1 0" stiffness="200" damping="6"/>
<joint type="slide" axis="0 0 1" stiffness="200" damping="6"/><geom type="sphere" size="0.01" mass="0.05"/>
</body></worldbody></mujoco>"""
SUBSTEPS = 4
EXPECT = """[{ signal = "left.force.direct", metric = "deviation_from_ideal", min = "1 mN" },
             { signal = "left.force.phase_locked", metric = "deviation_from_ideal", max = "1 uN" },
             { signal = "left.force.phase_locked", metric = "underruns", equals = 0 }]"""


def library(folder: str) -> ctypes.CDLL:
    built = Path(folder, "libmujoco_fields.so")
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", str(HERE / "mujoco_fields.c"), "-o", str(built),
                    "-Wl,--no-as-needed", "-lmujoco"], check=True)
    mujoco = ctypes.CDLL(str(built))  # with it, libmujoco is loaded
    for name in ("mj_loadXML", "mj_makeData"):
        getattr(mujoco, name).restype = ctypes.c_void_p
    for name in ("applied_N", "position_m"):
        getattr(mujoco, name).restype = ctypes.POINTER(ctypes.c_double)
    mujoco.set_step_s.argtypes = [ctypes.c_void_p, ctypes.c_double]
    return mujoco


class Mass:
    def __init__(self, request: evenstep.SolverRequest, mujoco: ctypes.CDLL, model_file: str) -> None:
        self.mujoco, error = mujoco, ctypes.create_string_buffer(1000)
        self.model = ctypes.c_void_p(mujoco.mj_loadXML(model_file.encode(), None, error, len(error)))
        if not self.model:
            raise ValueError(error.value.decode())
        self.data = ctypes.c_void_p(mujoco.mj_makeData(self.model))
        self.pull_N = np.ctypeslib.as_array(mujoco.applied_N(self.data, 1), (3,))  # on body 1, in MuJoCo's own memory
        self.mass_m = np.ctypeslib.as_array(mujoco.position_m(self.data), (3,))
        self.hand_m = np.zeros(3)

    def __del__(self) -> None:
        self.mujoco.mj_deleteData(self.data)
        self.mujoco.mj_deleteModel(self.model)

    def step(self, positions_m, step_s):
        self.mujoco.set_step_s(self.model, step_s / SUBSTEPS)
        begin_m, end_m = self.hand_m, positions_m[0].copy()
        for substep in range(1, SUBSTEPS + 1):
            self.hand_m = begin_m + (end_m - begin_m) * (substep / SUBSTEPS)
            self.pull_N[:] = COUPLING * (self.hand_m - self.mass_m)
            self.mujoco.mj_step(self.model, self.data)
        if self.mujoco.warnings(self.data):
            raise evenstep.SolverError("MuJoCo has reset the scene", remedy="more substeps or less stiffness",
                                       reason="unstable-step")
        return [COUPLING * (self.mass_m - end_m)]


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        mujoco, model_file = library(folder), Path(folder, "mass.xml")
        model_file.write_text(MODEL, encoding="utf-8")
        run = evenstep.run(HERE / "mass_spring.toml", repeat=True, set={"expect": EXPECT},
                           solver={"chain": lambda request: Mass(request, mujoco, str(model_file))})
    for name in ("direct", "phase_locked"):
        force = run.metrics[name]["left.force"]
        print(f"{name}: {1e3 * force['deviation_from_ideal']:.3g} mN from what an ideal exchange gives")
    print(f"{run.verdict}, trace {run.trace_hash}, twice the same")
    return run.exit_code


if __name__ == "__main__":
    sys.exit(main())
