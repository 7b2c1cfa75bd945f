"""Exercises of lesson 1: space vectors, torque, electrical speed, slip."""

from __future__ import annotations

import math

from imo_analysis.equations import plant, steady_state
from imo_analysis.exercises.exercise import Exercise, Formula, Number
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.machine import PRESETS

MACHINE = PRESETS["table-iii-printed-alpha"]
FLUX = 0.5307  # Wb, Table III


def _torque() -> float:
    return plant.torque((0.0, 10.0, FLUX, 0.0), MACHINE.n_p, MACHINE.L_m, MACHINE.L_r)


def _slip_setting() -> Setting:
    """With R_r as another name of alpha L_r."""
    rotor = {"R_r": Name("alpha") * Name("L_r")}
    return setting("slip", "constant flux on the d axis", rotor, ("phi_dr != 0", "L_m != 0", "n_p != 0"))


EXERCISES: tuple[Exercise, ...] = (
    Number(
        "1.1", lambda: steady_state.current_of_flux(FLUX, 0.0, 0.0, MACHINE.alpha, MACHINE.L_m)[0], "A",
        ((lambda i: i * MACHINE.L_m / MACHINE.L_r, "The row has the mutual inductance L_m, not a winding's own."),
         (lambda i: i * MACHINE.alpha, "alpha stands on both sides of the row, so it cancels."),
         (lambda i: 1.5 * i, "No 3/2 here: it belongs to power and torque, not to fluxes.")),
        "alpha cancelled: it says how fast the flux comes, not how much.", "Solve the third row for i_ds."),
    Number(
        "1.2", _torque, "N m",
        ((lambda t: t / 1.5, "The factor 3/2 is missing: the vectors are amplitude-invariant, three phases carry the power."),
         (lambda t: t * 2 / 3 / 1.5, "2/3 in place of 3/2: going into vectors it is 2/3, coming out of them 3/2."),
         (lambda t: t / MACHINE.n_p, "The pole pairs are missing: they gear the torque up as they gear the speed down."),
         (lambda t: t / 1.5 / MACHINE.n_p, "The factor 3/2 and the pole pairs are both missing."),
         (lambda t: t * MACHINE.L_r / MACHINE.L_m, "L_m / L_r is missing: only part of the rotor's flux links the stator.")),
        "", "Use the formula above with phi_qr = 0."),
    Number(
        "1.3", lambda: MACHINE.n_p * 1000 * math.pi / 30, "rad/s",
        ((lambda w: w / MACHINE.n_p, "That is the mechanical speed; the omega of (1) is electrical, pole pairs times as much."),
         (lambda w: w / MACHINE.n_p**2, "Divided by the pole pairs where it must be multiplied: the field sees every pole."),
         (lambda w: w / (2 * math.pi), "That is a frequency in Hz; a turn is 2 pi rad."),
         (lambda w: 60 * w, "A minute has 60 s.")),
        "", "rpm are turns of the shaft a minute."),
    Formula(
        "1.4",
        lambda: steady_state.slip_of_torque(*names("torque phi_dr n_p L_r alpha")),
        _slip_setting,
        (("alpha*L_m*i_qs/phi_dr", "That is the step before: eliminate i_qs with the torque."),
         ("alpha*L_r*torque/(n_p*phi_dr**2)", "The factor 3/2 of the torque is missing."),
         ("3*alpha*L_r*torque/(2*n_p*phi_dr**2)", "3/2 is upside down: solving the torque for the current it becomes 2/3."),
         ("2*alpha*L_r*torque/(3*phi_dr**2)", "The pole pairs of the torque are missing."),
         ("2*alpha*L_r*torque/(3*n_p*phi_dr)", "The flux comes twice: in the torque and in the slip's row."),
         ("2*alpha*L_m*torque/(3*n_p*phi_dr**2)", "L_m cancels, L_r stays.")),
        "Slip is the price of torque: doubled by doubled alpha, quartered by doubled flux.",
        "Solve the torque for i_qs and put it into the row of the slip."),
)
