"""Units of the fields of a study: of every number, and as the tables of the manual have them."""

import pytest
from imo_manual.facts import study_tables

from imo_analysis.study_units import unit_of

KNOWN = {
    "inverter.dead_time": "s", "inverter.dc_link": "V", "mechanics.coulomb": "N m", "mechanics.coulomb_speed": "rad/s",
    "mechanics.stiffness": "N m", "mechanics.damping": "N m s", "mechanics.load_share": "1", "saturation.knee": "Wb",
    "saturation.flux.0": "Wb", "sensors.current_resolution": "A", "sensors.current_gain.0": "1", "simulation.sample_time": "s",
    "simulation.duration": "s", "reference.time.1": "s", "reference.omega.1": "rad/s", "load.T_l.0": "N m",
    "drive.flux_modulation": "Wb", "drive.errors.J": "1", "observers.mine.gains.g": "1/(A^2 s^2)",
    "observers.mine.initial.xi_1_hat": "A", "observers.mine.errors.R_s": "1", "machine.R_r": "ohm", "machine.n_p": "1",
    "poles.sweep.stop": "rad/s", "tuning.uncertainty.R_s": "1", "excitation.window": "s", "drive.feedback": "1",
}


@pytest.mark.parametrize("name", list(KNOWN))
def test_known_units(name: str) -> None:
    assert unit_of(name) == KNOWN[name]


def test_every_number_has_the_unit_of_its_declaration() -> None:
    seen = 0
    for table in study_tables():
        for field in table.fields:
            if table.heading[0] != "[" or "number" not in field.kind or "table" in field.kind:
                continue
            name = f"{table.heading.strip('[]').replace('NAME', 'mine')}.{field.name}{'.0' if 'list' in field.kind else ''}"
            assert unit_of(name) == (field.unit or "1"), name
            seen += 1
    assert seen > 60
