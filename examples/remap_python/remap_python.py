"""The remap from Python, with the timing of the paper: 30 times a second a visualization of 11.1 ms, and then 15 steps. The
hand moves evenly, and so do the positions that the steps read and the forces that the device plays.

    python3 remap_python.py libevenstep_remap_c.so
"""
import ctypes
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int64, c_uint32, c_uint64, c_void_p

MS = 1_000_000  # ns


class Options(ctypes.Structure):
    _fields_ = [(name, c_uint32) for name in ("struct_size", "components")]
    _fields_ += [(name, c_int64) for name in ("lead_ns", "latency_ns")]
    _fields_ += [("emission", c_uint32), ("adapts", c_uint32), ("bandwidth_Hz", c_double)]
    _fields_ += [("sample_capacity", c_uint32), ("force_capacity", c_uint32)]
    _fields_ += [(name + "_ns", c_int64) for name in ("sample_window", "sample_furthest", "force_window", "force_furthest",
                 "adapt_start", "adapt_least", "adapt_most", "adapt_window", "adapt_margin")] + [("adapt_slew_ppm", c_int64)]


class Counts(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("steps", c_uint64), ("acquiring", c_uint64)]
    _fields_ += [("late_forces", c_uint64), ("latest_force_ns", c_int64)]
    _fields_ += [(ring + "_" + way, c_uint64) for ring in ("hand", "force")
                 for way in ("inside", "held", "extrapolated", "overruns", "empty")]


lib = ctypes.CDLL(sys.argv[1])
lib.evenstep_remap_last_error.restype = c_char_p
for name, arguments in {"options_init": [c_void_p, c_uint32], "create": [c_void_p, POINTER(c_void_p)],
                        "sample": [c_void_p, c_int64, c_void_p], "force": [c_void_p, c_int64, c_void_p, c_void_p],
                        "segment": [c_void_p, c_int64], "begin_step": [c_void_p, c_int64, c_void_p, c_void_p],
                        "end_step": [c_void_p, c_int64, c_void_p, c_void_p], "get_counts": [c_void_p, c_void_p]}.items():
    getattr(lib, "evenstep_remap_" + name).argtypes = arguments
lib.evenstep_remap_destroy.argtypes = [c_void_p]


def call(name, *arguments):
    if getattr(lib, "evenstep_remap_" + name)(*arguments) != 0:
        raise RuntimeError(lib.evenstep_remap_last_error().decode())


def velocity_jump(values, step):
    return max(abs(c - 2 * b + a) for a, b, c in zip(values, values[1:], values[2:])) / step


assert lib.evenstep_remap_abi() == 1
options, counts, remap, value = Options(), Counts(struct_size=ctypes.sizeof(Counts)), c_void_p(), (c_double * 3)()
call("options_init", byref(options), ctypes.sizeof(options))
options.lead_ns, options.latency_ns = MS * 261 // 1000, MS * 15_066 // 1000
call("create", byref(options), byref(remap))
END, TICK, BEGIN = range(3)  # of two things at the same time, the first in this order comes first
events = [(tick * MS, TICK, None) for tick in range(2000)]
for k in range(60):
    segment, end = k * 1000 * MS // 30, (k + 1) * 1000 * MS // 30
    first = segment + MS * 111 // 10
    times = [first + (end - first) * i // 15 for i in range(16)]
    events += [(segment, BEGIN, "segment")] + [(at, BEGIN, "begin_step") for at in times[:-1]]
    events += [(at, END, "end_step") for at in times[1:]]
read_m, felt_N = [], []
for time_ns, _, what in sorted(events, key=lambda event: event[:2]):
    if what is None:  # a device thread does this
        call("sample", remap, time_ns, (c_double * 3)(1e-10 * time_ns))  # 0.1 m/s
        call("force", remap, time_ns, value, None)
        felt_N.append(value[0])
    elif what == "segment":  # and a simulation thread does the rest
        call("segment", remap, time_ns)
    elif what == "begin_step":
        call("begin_step", remap, time_ns, value, None)
        read_m.append(value[0])
    else:
        call("end_step", remap, time_ns, (c_double * 3)(-200 * read_m[-1]), None)
call("get_counts", remap, byref(counts))
lib.evenstep_remap_destroy(remap)
read, felt = velocity_jump(read_m[120:], 0.1 / 450), velocity_jump(felt_N[270:], 200 * 0.1 / 450)
print(f"velocity jump: {read:.2g} step in, {felt:.2g} step out; {counts.hand_held} underruns,",
      f"{counts.late_forces} late forces")
sys.exit(not (read < 1e-6 and felt < 1e-6 and counts.hand_held == counts.late_forces == 0))
