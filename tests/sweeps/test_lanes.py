"""Batches compute what single runs compute, and are vector code."""

import re
import subprocess
import sys

import numpy as np
import pytest

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.simulation.inputs import profile
from imo_analysis.simulation.kernel import Loop
from imo_analysis.simulation.run import simulate
from imo_analysis.sweeps.batch import place, run_batch
from imo_analysis.sweeps.lanes import lanes
from imo_analysis.sweeps.trace import CONSTANT, LIVE, Trace, evaluated, statements
from imo_analysis.sweeps.values import with_values

# relative to the largest value of the state over the batch: rounding of 500 steps of a stable loop, with a wide margin
SAME = 1e-12


@pytest.fixture(scope="module")
def fields(turning):
    random = np.random.default_rng(3)
    share = lambda: 1 + 0.3 * (2 * random.random(21) - 1)  # noqa: E731
    machine = turning.machine
    gains = turning.observers["repaired"].gains
    return {
        "machine.R_r": machine.R_r * share(), "machine.R_s": machine.R_s * share(), "machine.J": machine.J * share(),
        "observers.repaired.gains.k_1": gains["k_1"] * share(), "observers.baseline.errors.L_m": 0.01 * (share() - 1),
        "observers.consistent_12.initial.alpha_hat": 8.0 * share(),
        "reference.omega.1": 80 * share(), "load.T_l.1": 5 * share(),
        "drive.flux": 0.5 * share(), "sensors.current_gain.0": share(), "initial.omega": 60 * share(),
    }


@pytest.mark.slow
@pytest.mark.parametrize("options", [
    {},
    {"sensors.sampling": "sampled", "sensors.current_noise": 0.05, "simulation.substeps": 3},
    {"drive.feedback": "repaired", "drive.flux_modulation": 0.05, "drive.flux_modulation_frequency": 100.0},
    {"reference.shape": "linear", "load.shape": "linear"},
], ids=["plain", "sampled", "closed", "linear"])
def test_every_lane_is_the_single_run(turning, fields, options):
    study = turning.changed({**options, "simulation.record_every": 1})
    batch = run_batch(study, fields, jobs=1)
    for lane in (0, 15, 16, 20):
        one = with_values(study, {name: float(value[lane]) for name, value in fields.items()})
        run = simulate(one.changed({"simulation.duration": 0.0501}))  # the record after the last sample is the batch's end
        last = run.isel(time=-1)
        for name, values in batch.ends.items():
            observer, _, state = name.rpartition("/")
            single = float(last[state].sel(observer=observer) if observer else last[state])
            size = float(np.max(np.abs(values)))
            assert abs(single - values[lane]) <= SAME * max(size, 1.0), (lane, name)


def test_the_place_in_the_batch_and_the_threads_change_no_bit(turning, fields):
    batch = run_batch(turning, fields, jobs=1)
    again = run_batch(turning, {name: value[::-1] for name, value in fields.items()}, jobs=2)
    for part in ("tallies", "ends"):
        for name, values in getattr(batch, part).items():
            np.testing.assert_array_equal(values, getattr(again, part)[name][::-1], err_msg=name)


@pytest.mark.slow
def test_a_lost_machine_disturbs_no_other(paper):
    study = paper.only(["repaired"]).changed({"simulation.duration": 0.3, "windows": [], "drive.feedback": "repaired"})
    gains = {"observers.repaired.gains.K_p": np.array([100.0, -1e6, 100.0]),
             "observers.repaired.gains.k_1": np.array([300, -1e5, 300.0])}
    batch = run_batch(study, gains)
    lost = batch.tallies["repaired/lost"]
    assert lost[1] >= 0 and lost[0] == lost[2] == -1
    alone = run_batch(study, {name: value[:1] for name, value in gains.items()})
    assert batch.ends["omega"][0] == alone.ends["omega"][0] == batch.ends["omega"][2]
    assert np.isfinite(batch.tallies["repaired/speed_square"][1])


def test_places_in_a_table_give_its_profile(turning):
    T = 1e-4
    time = np.arange(600) * T
    for shape in ("steps", "linear"):
        given = {"shape": shape, "time": [0.0, 0.011, 0.03], "omega": [60.0, -10.0, 80.0]}
        table = turning.changed({"reference": given}).reference
        entry, share = place(table, time, T)
        values = np.array([*table.omega, table.omega[-1]])
        np.testing.assert_allclose(values[entry] + share * (values[entry + 1] - values[entry]),
                                   profile(table, table.omega, time, T), rtol=1e-13, atol=1e-13)


@pytest.mark.slow
def test_the_loops_over_lanes_are_packed_instructions(tmp_path):
    """Compiled in a process of its own, since the assembly of a kernel out of the cache cannot be looked at."""
    script = """
import re
from imo_analysis.sweeps.lanes import lanes
from imo_analysis.simulation.kernel import Loop
from imo_analysis.sweeps.batch import run_batch
from imo_analysis.study import Study
study = Study.paper().only(["repaired"]).changed({"simulation.duration": 0.002, "simulation.record_every": 1, "windows": [],
    "reference": {"time": [0.0], "omega": [20.0]}})
import numpy as np
run_batch(study, {"machine.R_r": np.array([0.5])}, jobs=1)
(text,) = lanes(Loop(("repaired",))).run.inspect_asm().values()
arithmetic = r"\\bv?(?:add|sub|mul|fn?m(?:add|sub)\\d*)"
for kind in (arithmetic + "pd", arithmetic + "sd", "fmla|fmul.*2d"):
    print(len(re.findall(kind, text)))
"""
    done = subprocess.run([sys.executable, "-c", script], env={"IMO_CACHE_DIR": str(tmp_path), "PATH": ""}, text=True,
                          capture_output=True, check=True)
    packed, scalar, neon = map(int, done.stdout.split())
    assert packed + neon > 200
    assert scalar < 0.05 * (packed + neon)


def test_every_observer_has_a_batch(turning):
    """The text of every kind compiles as Python; what it computes is held by the tests above for the three that run there."""
    for kind in OBSERVERS:
        compile(lanes(Loop((kind,))).source, kind, "exec")


def test_a_trace_moves_constants_out_and_keeps_the_value():
    trace = Trace()
    a, b = trace.inputs(("a", "b"), CONSTANT)
    (x,) = trace.inputs(("x",), LIVE)
    value = 0.0 * x + (a * b + 1) * x / b + 1.0 * x - 0.0 + x**3
    lines, needed = statements([value], LIVE, {id(x): "x"}, "t")
    assert len(needed) == 2 and not any("/" in line for line in lines)
    given = {"a": 3.0, "b": 7.0}
    names = dict(zip(["t_1", "t_2"], evaluated(needed, given), strict=True)) | {"x": 1.7}
    for line in lines:
        name, text = line.split(" = ")
        names[name] = _value(text, names)
    assert names[lines[-1].split(" = ")[0]] == pytest.approx((3 * 7 + 1) * 1.7 / 7 + 1.7 + 1.7**3, rel=1e-15)


def _value(text, names):
    left, operation, right = re.fullmatch(r"\((\S+) (.) (\S+)\)", text).groups()
    left, right = (names[word] if word in names else float(word) for word in (left, right))
    return {"+": left + right, "-": left - right, "*": left * right}[operation]


def test_a_definition_that_branches_is_refused():
    trace = Trace()
    (x,) = trace.inputs(("x",), LIVE)
    with pytest.raises(TypeError, match="cannot be traced"):
        trace.run(lambda value: 1 if value else 2, x)




def test_what_a_trace_leaves_out_changes_no_bit():
    """Signs that move outwards, the larger of x and 0, and what occurs twice: exact, so numpy's answer is the definition's."""
    def definition(x, y, a):
        return (-a * x - y * x, -(-a * x), (0.0 - x) * (y - x) - (x - y), abs(-x) + -y, (x - y + abs(x - y)) / 2,
                (-x + abs(-x)) / 2, x / -y, -x - -y, (-x) * (-a), -a / -y)

    trace = Trace()
    names = ("x", "y", "a")
    inputs = trace.inputs(names, LIVE)
    results = trace.run(definition, *inputs)
    lines, _ = statements(results, LIVE, dict(zip(map(id, inputs), names, strict=True)), "t")
    assert sum("max" in line for line in lines) == 2 and not any("0.5" in line for line in lines)
    assert len(lines) < 22
    draws = np.random.default_rng(3).normal(size=(3, 1000))
    given = dict(zip(names, draws, strict=True))
    for made, wanted in zip(evaluated(results, given), definition(*draws), strict=True):
        assert np.array_equal(made, wanted)
