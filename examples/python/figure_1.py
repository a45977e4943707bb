# %% [markdown]
# Figure 1 of the paper, from a run: the motion that the simulation sees, and the force that the hand feels. A notebook's cells
# begin with "# %%"; as a script it writes figure-1.png.
#
#     python3 figure_1.py SCENARIO [OUT.png]

# %%
import sys

import evenstep
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

scenario = sys.argv[1] if len(sys.argv) > 1 else "scenarios/paper/figure-1-spring.toml"
run = evenstep.run(scenario)

# %%
begin_s, end_s = 2.0, 2.1  # three segments
figure, (motion, force) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
looks = {"direct": ("#d55e00", "-", "direct"), "phase_locked": ("#0072b2", ":", "remapped")}
for name, (colour, line, label) in looks.items():
    strategy = run.series[name]
    step = strategy.steps
    of_device = strategy.devices["left"]
    in_window = (step["begin_ns"] >= begin_s * 1e9) & (step["begin_ns"] < end_s * 1e9)
    motion.plot(range(in_window.sum()), 1e3 * of_device.steps["position_m"][in_window, 0], line, color=colour, label=label)
    tick = of_device.ticks
    in_window = (tick["at_ns"] >= begin_s * 1e9) & (tick["at_ns"] < end_s * 1e9)
    force.plot(1e3 * (tick["at_ns"][in_window] * 1e-9 - begin_s), tick["force_N"][in_window, 0], line, color=colour, label=label)
motion.set(title="a  what the steps read", xlabel="step", ylabel="position, mm")
force.set(title="b  what the hand feels", xlabel="time, ms", ylabel="force, N")
for axes in (motion, force):
    axes.legend()

# %%
out = sys.argv[2] if len(sys.argv) > 2 else "figure-1.png"
figure.savefig(out, dpi=110)
print(f"{run.file}: {run.verdict}, {out}")
