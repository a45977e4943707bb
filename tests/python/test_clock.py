"""The virtual clock, and the Remapper under it."""
import threading

import evenstep
import numpy as np
import pytest

MS = 1_000_000


def test_a_remapper_told_of_a_run_gives_all_of_it_bit_for_bit(virtual_clock):
    run = evenstep.run("scenarios/paper/figure-1-spring.toml")
    own, steps = run.series["phase_locked"], run.series["phase_locked"].steps
    ticks, tool = own.devices["left"].ticks, own.devices["left"].steps
    needs = run.summary["latency"]["phase_locked"]
    remapper = evenstep.Remapper(lead=needs["lead_ns"], latency=np.timedelta64(needs["latency_ns"], "ns"))
    felt = virtual_clock.device(remapper, (1000, 1), ticks["position_m"])  # C++
    seen = []

    async def simulation():  # Python beside it
        begins = own.segments["begin_ns"].tolist()
        for n, step in enumerate(steps):
            while begins and begins[0] <= step["begin_ns"]:
                remapper.segment(begins.pop(0))
            await virtual_clock.until(int(step["begin_ns"]))
            read = remapper.begin_step(virtual_clock.now_ns)
            await virtual_clock.external(int(step["end_ns"]))
            emission = remapper.end_step(virtual_clock.now_ns, -200 * read.position)
            seen.append((read.read_ns, read.has_slot, read.position.tobytes(), emission))

    virtual_clock.spawn(simulation())
    virtual_clock.run(4_000 * MS)
    assert [one[0] for one in seen] == steps["read_ns"].tolist()[:len(seen)] and len(seen) == len(steps)
    assert [one[1] for one in seen] == steps["mapped"].tolist()
    assert [one[2] for one in seen] == [position.tobytes() for position in tool["position_m"]]
    assert [one[3] for one in seen] == steps["emission_ns"].tolist()
    assert felt.tobytes() == ticks["force_N"].tobytes()
    counts = remapper.counts()
    assert counts["steps"] == len(steps) and counts["late_forces"] == counts["hand"]["held"] == 0


def test_a_remapper_refuses_and_changes_nothing():
    remapper = evenstep.Remapper(lead=0, latency=15 * MS, components=2)
    remapper.sample(10, [1, 2])
    for at, position, kind, what in [(5, [1, 2], evenstep.OrderError, "before the time of the last one"),
                                     (20, [1, 2, 3], ValueError, r"shape \(3,\), and the shape must be \(2,\)"),
                                     (20, [1, np.nan], evenstep.ArgumentError, "finite"),
                                     (0.02, [1, 2], TypeError, "not float; 15 ms is 15_000_000"),
                                     (2**70, [1, 2], OverflowError, "int too big"),
                                     ("20", [1, 2], TypeError, "not str")]:
        with pytest.raises(kind, match=what):
            remapper.sample(at, position)
    with pytest.raises(evenstep.OrderError, match="no step has begun"):
        remapper.end_step(30, [0, 0])
    assert remapper.begin_step(np.timedelta64(1, "us")).position.tolist() == [1, 2]
    assert remapper.counts()["steps"] == 1
    for options, kind, what in [({"components": 9}, evenstep.ArgumentError, "components is 9"),
                                ({"emission": "even"}, evenstep.ArgumentError, '"linear" or "hold"'),
                                ({"rings": 3}, TypeError, "no option 'rings'; it has components")]:
        with pytest.raises(kind, match=what):
            evenstep.Remapper(lead=0, latency=0, **options)


def test_two_threads_of_python_share_a_remapper():
    remapper = evenstep.Remapper(lead=0, latency=15 * MS, components=1)
    status = []

    def device():
        for k in range(20_000):
            remapper.sample(k, [k])
            status.append(remapper.force(k).status)

    thread = threading.Thread(target=device)
    thread.start()
    for n in range(5_000):
        remapper.segment(2 * n)
        position = remapper.begin_step(2 * n).position
        assert 0 <= position[0] < 20_000
        remapper.end_step(2 * n + 1, position)
    thread.join()
    assert len(status) == 20_000 and remapper.counts()["steps"] == 5_000


def lanes(clock, log):
    async def steps():
        for k in range(3):
            log.append(("step", await clock.until(10 * k * MS)))
            clock.note(k)
            assert await clock.external(10 * k * MS + 5 * MS, lambda: k * k) == k * k
            log.append(("done", clock.now_ns))

    def loop(time):
        k = 0
        try:
            while True:
                time.sleep_until(5 * k * MS)
                log.append(("loop", time.now_ns))
                k += 1
        finally:
            log.append(("left", k))

    clock.spawn(steps())
    clock.every((200, 1), lambda now_ns: log.append(("tick", now_ns)))
    clock.loop(loop)


def test_coroutines_callables_and_loops_run_in_one_order():
    logs, traces = [], []
    for permute_ties in (None, None, 7):
        log = []
        with evenstep.VirtualClock(permute_ties) as clock:
            lanes(clock, log)
            assert clock.run(25 * MS) == "reached_end" and clock.now_ns == 20 * MS
            traces.append(clock.trace_hash)
        logs.append(log)
    assert logs[0] == logs[1] and traces[0] == traces[1] != traces[2]
    # Completion < device < launch, and in one lane the order in which it was asked for.
    assert logs[0][:3] == [("tick", 0), ("step", 0), ("loop", 0)]
    assert logs[0][3:6] == [("done", 5 * MS), ("tick", 5 * MS), ("loop", 5 * MS)]
    assert logs[0][-1] == ("left", 5)


@pytest.mark.parametrize("start", ["coroutine", "callable", "loop", "work"])
def test_what_is_raised_comes_out_of_run(virtual_clock, start):
    def raises(_=None):
        raise LookupError("here")

    async def coroutine():
        await virtual_clock.until(5)
        raises()

    async def works():
        await virtual_clock.external(5, raises)

    def loop(time):
        time.sleep_until(5)
        raises()

    if start == "callable":
        virtual_clock.every((1000, 1), raises)
    elif start == "loop":
        virtual_clock.loop(loop)
    else:
        virtual_clock.spawn(coroutine() if start == "coroutine" else works())
    with pytest.raises(LookupError, match="here"):
        virtual_clock.run(10)


def test_what_cannot_work_says_why(virtual_clock):
    async def awaits_another():
        await evenstep.VirtualClock().until(5)
        await Forever()

    class Forever:
        def __await__(self):
            yield "forever"

    async def livelock():
        while True:
            await virtual_clock.until(0)

    with pytest.raises(ValueError, match="there are completion, device and launch"):
        virtual_clock.until(5, lane="devise")
    with pytest.raises(RuntimeError, match="after the first await"):
        virtual_clock.note(1)
    with evenstep.VirtualClock() as other:
        other.spawn(awaits_another())
        with pytest.raises(evenstep.RunFailed, match="await clock.until"):
            other.run(10)
    with pytest.raises(RuntimeError, match="the clock is closed"):
        other.run(10)
    virtual_clock.spawn(livelock())
    with pytest.raises(evenstep.RunFailed, match="events"):
        virtual_clock.run(10)
