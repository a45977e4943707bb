"""The remap between two threads of a Python program: a device at 1 kHz, and a simulation that draws for 11.1 ms and then
makes 15 steps, 30 times a second.

    python3 two_threads.py           in virtual time: the same numbers every time
    python3 two_threads.py wall      in real time, for two seconds
"""
import sys
import threading
import time

import evenstep
import numpy as np

MS = 1_000_000  # ns
SEGMENTS, STEPS, SPEED_m_per_s, STIFFNESS_N_per_m = 60, 15, 0.1, 200.0
END = SEGMENTS * 1000 * MS // 30


def device(clock, remapper, felt_N):
    for k in range(END // MS):
        clock.sleep_until(k * MS)
        now = clock.now_ns
        remapper.sample(now, [SPEED_m_per_s * now * 1e-9])  # where a real device would be read
        felt_N.append(remapper.force(now).value[0])  # and be sent this


def simulation(clock, remapper, read_m):
    for segment in range(SEGMENTS):
        begin, end = segment * 1000 * MS // 30, (segment + 1) * 1000 * MS // 30
        clock.sleep_until(begin)
        remapper.segment(clock.now_ns)
        first = begin + 111 * MS // 10  # here it would draw
        for i in range(STEPS):
            clock.sleep_until(first + (end - first) * i // STEPS)
            position = remapper.begin_step(clock.now_ns).position
            read_m.append(position[0])
            clock.sleep_until(first + (end - first) * (i + 1) // STEPS, "completion")  # and here it would compute
            remapper.end_step(clock.now_ns, -STIFFNESS_N_per_m * position)


class WallClock:
    """Real time, with what a loop of VirtualClock has."""

    def __init__(self, start):
        self.start = start

    @property
    def now_ns(self):
        return time.monotonic_ns() - self.start

    def sleep_until(self, at, lane=None):
        time.sleep(max(0, at - self.now_ns) * 1e-9)


def jump(values, step):
    """The largest change from step to step, as a share of a step."""
    return np.abs(np.diff(values, 2)).max() / step


if __name__ == "__main__":
    remapper = evenstep.Remapper(lead=np.timedelta64(261, "us"), latency=np.timedelta64(15_066, "us"), components=1)
    read_m, felt_N = [], []
    if sys.argv[1:] == ["wall"]:
        start = time.monotonic_ns()
        threads = [threading.Thread(target=loop, args=(WallClock(start), remapper, out))
                   for loop, out in ((device, felt_N), (simulation, read_m))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    else:
        with evenstep.VirtualClock() as clock:
            clock.loop(lambda time: device(time, remapper, felt_N), name="tick", lane="device")
            clock.loop(lambda time: simulation(time, remapper, read_m), name="step")
            clock.run(END)
            print("trace", clock.trace_hash)
    print(f"velocity jump: {jump(read_m[120:], SPEED_m_per_s / 450):.2g} step in,",
          f"{jump(felt_N[270:], STIFFNESS_N_per_m * SPEED_m_per_s / 450):.2g} step out;",
          f"{remapper.counts()['late_forces']} late forces")
