"""A chain of masses and springs in numpy, felt through the uneven timing of the paper's figure 1.

    python3 mass_spring.py
"""
import sys
from pathlib import Path

import evenstep
import numpy as np


class Chain:
    """Masses in a row, of which the hand holds the first one by a spring, and a spring holds the last one where it is."""

    def __init__(self, request: evenstep.SolverRequest) -> None:
        options = request.options
        self.mass_kg, self.stiffness, self.damping = options["mass_kg"], options["stiffness"], options["damping"]
        self.substeps = options["substeps"]
        self.masses = options["masses"]
        self.reset()

    def reset(self) -> None:
        self.x_m, self.v_m_per_s = np.zeros((self.masses, 3)), np.zeros((self.masses, 3))
        self.hand_m = np.zeros(3)

    def step(self, positions_m, step_s):
        h, begin_m, end_m = step_s / self.substeps, self.hand_m, positions_m[0]
        for substep in range(1, self.substeps + 1):  # symplectic Euler
            hand_m = begin_m + (end_m - begin_m) * (substep / self.substeps)
            ends = np.vstack([hand_m, self.x_m, np.zeros(3)])
            springs_N = self.stiffness * np.diff(ends, axis=0)
            force_N = np.diff(springs_N, axis=0) - self.damping * self.v_m_per_s
            self.v_m_per_s += h * force_N / self.mass_kg
            self.x_m += h * self.v_m_per_s
        self.hand_m = end_m.copy()
        return [self.stiffness * (self.x_m[0] - end_m)]

    def energy_J(self) -> float:
        stretched = np.diff(np.vstack([self.hand_m, self.x_m, np.zeros(3)]), axis=0)
        return float(0.5 * self.stiffness * (stretched ** 2).sum() + 0.5 * self.mass_kg * (self.v_m_per_s ** 2).sum())

    def particles(self):
        return self.x_m, self.v_m_per_s


if __name__ == "__main__":
    run = evenstep.run(Path(__file__).with_name("mass_spring.toml"), solver={"chain": Chain}, repeat=True)
    for name in ("direct", "phase_locked"):
        force = run.metrics[name]["left.force"]
        print(f"{name}: {1e3 * force['deviation_from_ideal']:.3g} mN from what an ideal exchange gives")
    print(f"{run.verdict}, trace {run.trace_hash}, twice the same")
    sys.exit(run.exit_code)
