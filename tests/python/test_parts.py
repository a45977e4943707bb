"""Parts that are Python objects."""
import evenstep
import numpy as np
import pytest


class Spring:
    def __init__(self, request):
        self.stiffness = request.options.get("stiffness", 200)
        self.request = request
        self.step_number = 0

    def step(self, positions_m, step_s):
        assert positions_m.shape == (1, 3) and step_s == 1 / 450
        self.step_number += 1
        return -self.stiffness * positions_m


class Arm:
    def __init__(self, request):
        self.grip = request.grip
        assert request.device == "left" and request.rate_Hz == (1000, 1)

    def read(self, now_ns):
        return self.grip.hand_m()

    def write(self, force_N):
        self.grip.drive(force_N)

    def stop(self):
        self.grip.drive(np.zeros(3))


class Pacer:
    """Even slots, by the step rate."""

    def __init__(self, request):
        self.ticks, self.seconds = request.step_rate_Hz

    def boundary(self, n, begin_ns):
        pass

    def slot(self, n):
        return n * self.seconds * 1_000_000_000 // self.ticks + 11_100_000


def paper_timing(request):
    def at(k, i):
        begin = k * 1_000_000_000 // 30
        end = (k + 1) * 1_000_000_000 // 30
        return begin + 11_100_000 + (end - begin - 11_100_000) * i // 15

    for k in range(1000):
        begin = k * 1_000_000_000 // 30
        yield evenstep.Segment(begin, (begin, begin + 11_100_000), [(at(k, i), at(k, i + 1)) for i in range(15)])


def forces(run):
    return run.series["phase_locked"].devices["left"].ticks["force_N"]


def test_a_spring_of_python_gives_the_forces_of_evensteps_own_bit_for_bit(spring):
    own, python = evenstep.run(spring), evenstep.run(spring, solver=Spring, repeat=True)
    assert forces(python).tobytes() == forces(own).tobytes()
    assert python.trace_hash == own.trace_hash


def test_an_object_is_copied_for_each_strategy(spring):
    class Counts:
        def __init__(self):
            self.steps = 0

        def step(self, positions_m, step_s):
            self.steps += 1
            return np.array([[float(self.steps), 0, 0]])

    counts = Counts()
    run = evenstep.run(spring, solver=counts, set={"expect": []})
    assert counts.steps == 0
    for name in ("direct", "phase_locked"):  # one that both shared would have counted for both
        force = run.series[name].devices["left"].steps["force_N"][:, 0]
        assert force.tolist() == list(range(1, len(force) + 1))


def test_device_map_and_timing(spring):
    own = evenstep.run(spring)
    device = evenstep.run(spring, device=Arm)
    assert device.ok and abs(forces(device) - forces(own)).max() < 0.01  # a reference device rounds to 10 um
    even = evenstep.run(spring, map=Pacer)
    assert even.metrics["foreign"]["left.interaction"]["velocity_jump"] < 1e-6 * 0.1 / 450
    timed = evenstep.run(spring, timing=paper_timing)
    assert timed.ok
    assert timed.series["phase_locked"].steps["begin_ns"].tolist() == own.series["phase_locked"].steps["begin_ns"].tolist()
    needs = evenstep.size(spring, timing=paper_timing)
    assert needs["strategies"] == evenstep.size(spring)["strategies"]


def test_a_scenario_names_its_parts_and_their_options(spring):
    text = spring.read_text().replace('solver = "cpu-double"\n', "").replace('kind = "spring"\nstiffness = "200 N/m"',
                                      'kind = "foreign"\nname = "mine"\noptions = { stiffness = 100 }')
    spring.write_text(text)
    by_name = evenstep.run(spring, solver={"mine": Spring})
    assert by_name.trace_hash == evenstep.run(spring, solver=Spring).trace_hash
    assert forces(by_name)[-1, 0] == pytest.approx(-100 * 0.1 * 0.983, abs=0.05)
    assert evenstep.check(spring, solver={"mine": Spring})["verdict"] == "open"
    with pytest.raises(evenstep.ScenarioError, match="'mine' is not registered; did you mean 'mime'"):
        evenstep.run(spring, solver={"mime": Spring})
    with pytest.raises(TypeError, match="dictionary"):
        evenstep.check(spring, solver=Spring)


@pytest.mark.parametrize("threads", [1, 2])
def test_an_exception_ends_the_run_and_names_the_step(spring, threads):
    class Fails(Spring):
        def step(self, positions_m, step_s):
            if self.step_number == 99:
                raise ZeroDivisionError("no more")
            return super().step(positions_m, step_s)

    with pytest.raises(evenstep.RunFailed) as caught:
        evenstep.run(spring, solver=Fails, threads=threads)
    error = caught.value
    assert "the solver 'python', step 99: ZeroDivisionError: no more (" in str(error)
    assert __file__ in str(error) and error.exit_code == 3
    assert isinstance(error.__cause__, ZeroDivisionError)
    assert error.__cause__.__traceback__ is not None
    assert error.run.verdict == "error" and error.run.failures == []


@pytest.mark.parametrize("answer, what", [
    ([1, 2], r"step\(\) returned an array of shape \(2,\), and the shape must be \(1, 3\)"),
    ("much", "which is no array of numbers"), (None, r"step\(\) returned"), ([[np.nan, 0, 0]], "not finite")])
def test_an_answer_of_another_shape_is_refused(spring, answer, what):
    class Answers(Spring):
        def step(self, positions_m, step_s):
            return answer

    with pytest.raises(evenstep.RunFailed, match=what):
        evenstep.run(spring, solver=Answers)


def test_a_solver_can_say_why_and_what_helps(spring):
    class Refuses(Spring):
        def step(self, positions_m, step_s):
            raise evenstep.SolverError("too stiff", remedy="more substeps", reason="unstable-step")

    with pytest.raises(evenstep.RunFailed) as caught:
        evenstep.run(spring, solver=Refuses)
    assert caught.value.remedy == "more substeps"
    spring.write_text(spring.read_text() + '\n[expect_stop]\nreason = "unstable-step"\n')
    assert evenstep.run(spring, solver=Refuses, set={"expect": []}).ok


def test_capabilities_are_the_methods_that_are_there(spring):
    class Whole(Spring):
        def step(self, positions_m, step_s):
            self.energy = 100 * (positions_m ** 2).sum()
            return super().step(positions_m, step_s)

        def energy_J(self):
            return self.energy

        def particles(self):
            return np.zeros((2, 3)), np.zeros((2, 3))

        def reset(self):
            self.step_number = 0

    energy = {"expect": [], "run.warmup": "8 segments"}
    lacks = evenstep.run(spring, solver=Spring, set=energy).summary["strategies"]["direct"]["solver_lacks"]
    assert lacks == ["contacts", "state_digest", "energy", "particles", "reset"]
    whole = evenstep.run(spring, solver=Whole, set=energy, repeat=True)
    assert whole.summary["strategies"]["direct"]["solver_lacks"] == ["contacts", "state_digest"]
    wrong = type("Wrong", (Whole,), {"particles": lambda self: (np.zeros(3), np.zeros(3))})
    with pytest.raises(evenstep.RunFailed, match="two arrays of shape"):
        evenstep.run(spring, solver=wrong, set=energy)


def test_what_draws_lots_is_found_out(spring):
    class Draws(Spring):
        drawn = 0

        def step(self, positions_m, step_s):
            Draws.drawn += 1
            return super().step(positions_m, step_s) + 1e-9 * Draws.drawn

    with pytest.raises(evenstep.NotReproducible, match="the solver 'python'") as caught:
        evenstep.run(spring, solver=Draws, repeat=True, threads=1)
    assert caught.value.exit_code == 4 and caught.value.run.verdict == "fail"


def test_a_grip_outlives_nothing(spring):
    grips = []

    class Keeps(Arm):
        def __init__(self, request):
            super().__init__(request)
            grips.append(request.grip)

    evenstep.run(spring, device=Keeps)
    with pytest.raises(ValueError, match="the run is over"):
        grips[0].hand_m()


def test_an_exception_while_a_scenario_is_read_is_its_cause(spring):
    def stops(request):
        yield evenstep.Segment(0, None, [(0, 1000)])
        raise KeyError("lost")

    with pytest.raises(evenstep.ScenarioError, match="KeyError: 'lost'") as caught:
        evenstep.run(spring, timing=stops)
    assert isinstance(caught.value.__cause__, KeyError)
