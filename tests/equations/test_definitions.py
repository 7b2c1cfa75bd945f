"""The definitions agree among themselves, at random exact rational points: (1) and (6) are the same machine, in any frame."""

from fractions import Fraction
from random import Random

from imo_analysis.equations import parameters, plant, projection, transformation
from imo_analysis.equations.catalogue import OBSERVERS, RUNNING_GRAM


def _rational(random: Random) -> Fraction:
    return Fraction(random.randint(-40, 40) or 7, random.randint(1, 9))


def test_plant_and_plant_z_agree_in_every_frame() -> None:
    random = Random(1)
    for _ in range(20):
        i_d, i_q, phi_d, phi_q, omega, omega_1, u_d, u_q, load = (_rational(random) for _ in range(9))
        R_s, L_m, alpha = (abs(_rational(random)) for _ in range(3))
        L_r = L_m + abs(_rational(random))
        L_s = L_m + abs(_rational(random))
        sigma = parameters.leakage(L_s, L_m, L_r)
        beta = parameters.coupling(L_m, sigma, L_r)
        p = (R_s, L_m, sigma, beta, alpha, Fraction(3), Fraction(2), Fraction(5))
        rates = plant.plant((i_d, i_q, phi_d, phi_q, omega), (u_d, u_q), omega_1, load, p)
        z = transformation.to_z(i_d, i_q, phi_d, phi_q, beta)
        z_rates = transformation.to_z(*rates[:4], beta)
        assert plant.plant_z((i_d, i_q, *z), (u_d, u_q), omega, omega_1, p) == (*rates[:2], *z_rates)
        assert transformation.from_z(i_d, i_q, *z, beta) == (phi_d, phi_q)


def test_projection_is_the_printed_one_case_by_case() -> None:
    random = Random(2)
    alpha_l, delta = Fraction(1, 2), Fraction(1, 10)
    for _ in range(200):
        rho, alpha_hat = _rational(random), Fraction(random.randint(1, 90), 100)
        p = (alpha_l**2 - alpha_hat**2) / (2 * delta * alpha_l - delta**2)
        printed = rho if p <= 0 or rho >= 0 else (1 - p) * rho
        assert projection.projection(rho, alpha_hat, alpha_l, delta) == printed


def test_every_observer_rests_on_the_true_state() -> None:
    """With the true state and parameters as estimates, every observer moves exactly as the machine does."""
    random = Random(3)
    for observer in OBSERVERS.values():
        i_d, i_q, phi_d, phi_q, omega, u_d, u_q = (_rational(random) for _ in range(7))
        R_s, L_m, sigma, beta, alpha = (abs(_rational(random)) for _ in range(5))
        p = (R_s, L_m, sigma, beta, alpha)
        z = transformation.to_z(i_d, i_q, phi_d, phi_q, beta)
        true = {"i_ds_hat": i_d, "i_qs_hat": i_q, "phi_dr_hat": phi_d, "phi_qr_hat": phi_q, "z_1_hat": z[0], "z_2_hat": z[1],
                "xi_1_hat": z[0], "xi_2_hat": z[1], "alpha_hat": alpha, "omega_hat": omega, "R_s_shift": Fraction(0)}
        true |= {name: _rational(random) for name in RUNNING_GRAM}  # a supervisor rests nowhere, and must not matter
        gains = {"alpha_l": alpha / 2, "delta": alpha / 4}
        rates = observer.rates(
            tuple(true[s] for s in observer.states), (i_d, i_q), (u_d, u_q), 1, p,
            tuple(gains.get(name, _rational(random)) for name in observer.gains))
        machine = plant.plant((i_d, i_q, phi_d, phi_q, omega), (u_d, u_q), 0, 0, (*p, 0, 0, 1))
        machine_z = transformation.to_z(*machine[:4], beta)
        expected = {"i_ds_hat": machine[0], "i_qs_hat": machine[1], "phi_dr_hat": machine[2], "phi_qr_hat": machine[3],
                    "z_1_hat": machine_z[0], "z_2_hat": machine_z[1], "xi_1_hat": machine_z[0], "xi_2_hat": machine_z[1],
                    "alpha_hat": 0, "omega_hat": 0, "R_s_shift": 0}
        found = dict(zip(observer.states, rates, strict=True))
        assert {s: rate for s, rate in found.items() if s not in RUNNING_GRAM} == {
            s: expected[s] for s in observer.states if s not in RUNNING_GRAM}, observer.name
        assert observer.flux(tuple(true[s] for s in observer.states), (i_d, i_q), beta) == (phi_d, phi_q)
