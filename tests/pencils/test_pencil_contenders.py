"""Everybody in the benchmark of the poles finds the same poles."""

import os

import numpy as np
import pytest

from benchmarks import c_code, poles


@pytest.mark.skipif(c_code.compiler() is None and os.environ.get("CI") != "true", reason="no C compiler (CC, cc, gcc, clang)")
def test_the_closed_form_in_c_is_ours() -> None:
    omega = np.linspace(-150.0, 150.0, 30_001)
    ours, theirs = (contender(omega, np.empty((4, len(omega)))) for contender in (poles.ours, poles.InC()))
    # sqrt of the condition at the near-double roots of the sweep is left of the rounding
    assert np.abs(ours - theirs).max() < 1e-11 * np.abs(ours).max()
    assert np.median(np.abs(ours - theirs)) < 1e-15 * np.abs(ours).max()


@pytest.mark.parametrize(("name", "kind", "flux"), [
    (poles.NAME, "frozen", None), ("printed_7", "frozen", None), (poles.NAME, "full", 0.5307)])
def test_python_control_has_the_poles_of_the_batch(name: str, kind: str, flux: float | None) -> None:
    omega = np.array([-140.0, 7.0, 60.0])
    whole = poles.control_loop(name, omega, kind, flux, 2.0)
    for all_of_them, moving in zip(whole, poles.batch(name, omega, kind, flux, 2.0), strict=True):
        assert all(np.abs(all_of_them - pole).min() < 1e-6 * np.abs(moving).max() for pole in moving)
