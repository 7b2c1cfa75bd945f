"""The study: what it accepts, what it refuses and in which words, and that it writes itself back."""

import math
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.study import Study, merged, paper_text
from imo_analysis.toml_writer import toml_text

FAULTS = [
    ("substeps = 1", "substep = 1", "simulation.substep is not a known key"),
    ("[poles]", "[poels]", "poels is not a known key"),
    ("duration = 60.0", 'duration = "60 V"', 'duration = "60 V" has the wrong unit; it must be in s'),
    ("duration = 60.0", 'duration = "long"', "is not a number with a unit"),
    ("duration = 60.0", 'duration = "60,5 s"', '"60,5 s" is not a number with a unit; write it with a point'),
    ("duration = 60.0", 'duration = "0.035"', '"0.035" is not a number with a unit'),
    ("duration = 60.0", "duration = true", "duration = True is not a number"),
    ("duration = 60.0", "duration = -1.0", "simulation.duration = -1 s must be above 0 s"),
    ("duration = 60.0", "duration = nan", "duration = nan is not finite"),
    ("duration = 60.0", "duration = 1e-6", "must be at least one sample_time"),
    ("duration = 60.0       # s", "", "simulation.duration is missing"),
    ("time = [0.0, 15.0,", "time = [0.0, 35.0,", "time must increase, but 30 s follows 35 s (study.toml: reference)"),
    ("time = [0.0, 15.0,", "time = [1.0, 15.0,", "time must start at 0"),
    ("omega = [20.0, 40.0, 100.0, 50.0]", "omega = [20.0]", "time has 4 entries and omega has 1"),
    ("omega = [20.0, 40.0, 100.0, 50.0]", "omega = [20.0, 40.0, inf, 50.0]", "not finite"),
    ("omega = [20.0, 40.0, 100.0, 50.0]", "omega = 5", "reference.omega = 5"),
    ("count = 301", "count = 0", "makes an empty sweep"),
    ("stop = 150.0", "stop = -200.0", "must be above start"),
    ("omega = [30.0, 60.0, 100.0]", "omega = []", "poles.omega"),
    ("h = 100.0", "h = nan", "gains.h = nan is not finite"),
    (", h = 100.0", "", "gains of baseline are missing: h"),
    (", h = 100.0", ", h = 100.0, k_1 = 3", "gains.k_1 is not known for baseline"),
    ("alpha_hat = 6.6 }", "z_9 = 6.6 }", "initial.z_9 is not known for consistent_12"),
    ("errors.R_r = -0.33571", "errors.R_q = 0.1", "errors.R_q is not known"),
    ("errors.R_r = -0.33571", "errors.R_r = -1", "errors.R_r = -1 must be above -1"),
    ('kind = "repaired"', 'kind = "kalman"', "kind = 'kalman' is not a known observer"),
    ("flux = 0.5307", "flux = -0.5", "drive.flux = -0.5"),
    ("flux_modulation = 0.0", "flux_modulation = 0.1", "flux_modulation_frequency = 0 rad/s must be above 0"),
    ('feedback = "measured"', 'feedback = "luck"', "drive.feedback = 'luck' must be one of: measured, baseline"),
    ('sampling = "continuous"', 'sampling = "sometimes"', "sensors.sampling"),
    ("seed = 1", "seed = -1", "simulation.seed"),
    ("[machine]", "[machin]", "the table [machine] is missing"),
    ('preset = "table-iii-printed-alpha"', 'preset = "mine"', "machine.preset = 'mine' is not known"),
    ('preset = "table-iii-printed-alpha"', 'preset = "table-iii"\nL_m = "70 mH"', "L_m = 0.07 H must be below sqrt(L_s L_r)"),
    ('preset = "table-iii-printed-alpha"', 'preset = "table-iii"\nL_m = -0.06', "L_m = -0.06 H must be above 0 H"),
    ('preset = "table-iii-printed-alpha"', 'file = "nowhere.toml"', "cannot read"),
    ('preset = "table-iii-printed-alpha"', 'file = 3', "machine.file = 3 must be the name"),
    ("start = 32.5, stop = 32.6", "start = 32.7, stop = 32.6", "scenarios.fig1"),
    ("[scenarios.fig4]", "[scenarios.fig4.scenarios.a]", "scenarios do not nest"),
    ("[poles]", "[poles", "is not TOML"),
    ('title = "paper"', "data = 3", "data is not a known key"),
    ('title = "paper"', 'title = "a\\u0000b"', "can be printed"),
    ("[observers.baseline]", '[observers."../x"]', "is not a name"),
    ("delta = 0.01", "delta = 0.0", "gains.delta = 0 1/s must be above 0"),
    ("[scenarios.fig1]", '[scenarios."a/b"]', "is not a name"),
]


@pytest.mark.parametrize(("old", "new", "words"), FAULTS, ids=[words[:40] for _, _, words in FAULTS])
def test_faults_are_named_in_one_line(old, new, words):
    text = paper_text()
    assert old in text
    with pytest.raises(InputError) as caught:
        Study.from_toml(text.replace(old, new, 1), "study.toml")
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_units_are_understood():
    text = paper_text().replace("sample_time = 1e-4", 'sample_time = "100 us"').replace("flux = 0.5307", 'flux = "530.7 mWb"')
    study = Study.from_toml(text)
    assert study.simulation.sample_time == pytest.approx(1e-4) and study.drive.flux == pytest.approx(0.5307)


def test_it_writes_itself_back():
    study = Study.paper()
    for one in (study, *(study.scenario(name) for name in study.scenarios), study.changed({"simulation.duration": 0.1})):
        again = Study.from_toml(one.to_toml())
        assert again.sha256 == one.sha256 and again.model_dump() == one.model_dump()
    assert study.changed({"simulation.seed": 4}).sha256 != study.sha256


def test_scenarios_are_laid_over():
    study = Study.paper()
    fig3 = study.scenario("fig3")
    assert fig3.observers["baseline"].errors == {"R_r": -0.33571}
    assert fig3.observers["baseline"].gains == study.observers["baseline"].gains
    assert fig3.observer_machine("baseline").alpha == pytest.approx(6.6, abs=1e-4)
    assert fig3.observer_machine("repaired").alpha == pytest.approx(9.9354)
    assert fig3.reference.omega == (20.0, 40.0, 100.0) and fig3.drive == study.drive
    with pytest.raises(InputError, match="choose one of: fig1, fig2"):
        study.scenario("fig9")


def test_changes_and_choices():
    study = Study.paper().changed({"machine.R_r": 0.5, "observers.repaired.gains.g": 2})
    assert study.machine.R_r == 0.5 and study.observers["repaired"].gains["g"] == 2.0
    assert list(study.only(["repaired"]).observers) == ["repaired"]
    with pytest.raises(InputError, match=r"machine\.R_q is not a known key"):
        study.changed({"machine.R_q": 1})
    with pytest.raises(InputError, match="is not in the study; choose from"):
        study.only(["nobody"])


def test_the_baseline_s_gains_are_what_the_comment_says():
    """k = 495.39 / (gamma + alpha) from the sum that all pairs of Table II have in common."""
    study = Study.paper()
    machine, gains = study.machine, study.observers["baseline"].gains
    k = 495.39 / (machine.gamma + machine.alpha)
    assert gains["l_1"] == pytest.approx((k - 1) * (machine.gamma + machine.alpha), rel=1e-4)
    assert gains["l_3"] == pytest.approx(((k * k - 1) * machine.R_s / machine.sigma - gains["l_1"]) / machine.beta, rel=1e-3)


OWN = {"n_p": 2, "R_s": 7.5, "R_r": 5.6, "L_m": 0.42, "L_s": 0.445, "L_r": 0.445, "J": 0.003}


def test_another_machine_fits_into_the_study_with_all_its_scenarios():
    """A motor of 1.1 kW: a fifth of the inertia, seven times the inductance."""
    machine = InductionMachine.build(OWN)
    study = Study.from_data({**Study.paper().data, "machine": OWN})
    for name in study.scenarios:
        assert study.scenario(name).machine.alpha == machine.alpha
    assert study.scenario("real").mechanics.resonance(machine.J) == pytest.approx((500 * (1 / 0.0015 + 1 / 0.0015)) ** 0.5)


def test_what_is_no_study_is_told_where_to_begin():
    with pytest.raises(InputError, match=r"reference is missing; .*drive is missing; .*whole study: imo study --init FILE"):
        Study.from_data({"machine": OWN, "simulation": {"duration": 1.0}}, "motor.toml")


def test_a_loop_on_an_observer_without_a_flux_estimate_is_refused():
    paper = Study.paper()
    closed = {"drive.feedback": "repaired", "observers.repaired.initial": {"alpha_hat": 0.0}}
    with pytest.raises(InputError, match=r"observers.repaired.initial.alpha_hat = 0 1/s must be above 0 .* 9.935 1/s"):
        paper.changed(closed)
    paper.changed({**closed, "drive.feedback": "baseline"})
    paper.changed({**closed, "observers.repaired.initial": {"alpha_hat": 0.0, "omega_hat": 30.0}})


def test_machine_from_a_file_beside_the_study(tmp_path):
    machine = Study.paper().machine.with_values(R_s=0.5)
    (tmp_path / "machine.toml").write_text(machine.to_toml())
    (tmp_path / "study.toml").write_text(paper_text().replace('preset = "table-iii-printed-alpha"', 'file = "machine.toml"'))
    study = Study.load(tmp_path / "study.toml")
    assert study.machine.R_s == 0.5
    assert Study.from_toml(study.to_toml()).machine == study.machine, "the text stands without the machine's file"


keys = st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=8)
scalars = st.one_of(st.booleans(), st.integers(-(2**60), 2**60), st.floats(allow_nan=False),
                    st.text(st.characters(exclude_categories=("Cs",)), max_size=12))
trees = st.recursive(st.one_of(scalars, st.lists(scalars, max_size=3)),
                     lambda inner: st.one_of(st.dictionaries(keys, inner, max_size=3),
                                             st.lists(st.dictionaries(keys, scalars, max_size=2), min_size=1, max_size=2)),
                     max_leaves=8)


@settings(max_examples=60, deadline=None)
@given(st.dictionaries(keys, trees, max_size=4))
def test_toml_is_written_as_it_is_read(data):
    assert tomllib.loads(toml_text(data)) == data


def test_merging_leaves_both_alone():
    base, over = {"a": {"b": 1, "c": [1, 2]}}, {"a": {"c": [3]}, "d": math.pi}
    assert merged(base, over) == {"a": {"b": 1, "c": [3]}, "d": math.pi}
    assert base == {"a": {"b": 1, "c": [1, 2]}}


CURVE = {"flux": [0.3, 0.6, 0.9], "current": [5.0, 10.5, 19.0]}


def test_of_two_magnetising_curves_the_overlay_has_the_last_word():
    """A measured table in a study from ``imo study --init``, whose scenario ``real`` has a knee."""
    machine = Study.paper().machine
    table = {**CURVE, "current": [psi / machine.L_s * (1 + (psi / 0.8) ** 6) for psi in CURVE["flux"]]}
    lines = "\n".join(f"{key} = {value}" for key, value in table.items())
    study = Study.from_toml(f"{paper_text()}\n[saturation]\n{lines}\n")
    assert study.saturation.flux == tuple(table["flux"]) and study.saturation.knee == 0
    real = study.scenario("real")
    assert real.saturation.knee > 0 and real.saturation.flux == () == real.saturation.current
    back = real.changed({f"saturation.{key}": value for key, value in table.items()})
    assert back.saturation.flux == tuple(table["flux"]) and back.saturation.knee == 0
    assert not study.changed({"saturation.knee": 0.0}).saturation.on
    with pytest.raises(InputError, match="were both given"):
        Study.paper().changed({"saturation": {"knee": 0.7, **table}})
