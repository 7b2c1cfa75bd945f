"""The part that settles: the same transfer functions, H2 by three routes, the speed loop, and the example of its docstring."""

import doctest
from typing import Any

import control
import numpy as np
import oracle_linearisation as oracle
import pytest
from pencil_case import EQUIVARIANT, GAINS, MACHINE, POINT, TRUE, gains

from imo_analysis.equations import lyapunov
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.pencils import settling
from imo_analysis.pencils.error import OperatingPoint, frozen_pencil, full_pencil
from imo_analysis.pencils.settling import settling_pencil, speed_loop

NOISE = ["i_ds_noise", "i_qs_noise"]
STABLE = [name for name in EQUIVARIANT if not name.endswith("printed_L")]


def _responses(system: Any, outputs: list[str], inputs: list[str]) -> np.ndarray:
    """Transfer functions at points off the axis, by plain linear algebra."""
    rows = [system.output_labels.index(label) for label in outputs]
    columns = [system.input_labels.index(label) for label in inputs]
    n = system.A.shape[0]
    return np.array([
        (system.C @ np.linalg.solve(s * np.eye(n) - system.A, system.B) + system.D)[np.ix_(rows, columns)]
        for s in (3.0 + 20.0j, 50.0 - 70.0j, 900.0 + 400.0j)])


@pytest.mark.parametrize("name", OBSERVERS)
@pytest.mark.parametrize("omega", [60.0, -20.0])
def test_frozen_transfer_functions_are_those_of_the_whole(name: str, omega: float) -> None:
    whole = frozen_pencil(MACHINE, name, gains(name), omega)
    part = settling_pencil(MACHINE, name, gains(name), OperatingPoint(omega, None), "frozen")
    outputs = [label for label in part.output_labels if label in whole.output_labels]
    assert {"i_ds_tilde", "phi_dr_tilde"} <= set(outputs) and len(part.poles()) == 4
    one, other = (_responses(system, outputs, whole.input_labels) for system in (whole, part))
    assert np.abs(one - other).max() < 1e-10 * np.abs(one).max()


@pytest.mark.parametrize("name", EQUIVARIANT)
@pytest.mark.parametrize("point", [POINT, OperatingPoint(-20.0, 0.4, 1.0), OperatingPoint(40.0, 0.5, 0.0)])
def test_full_transfer_functions_are_those_of_the_whole(name: str, point: OperatingPoint) -> None:
    whole = full_pencil(MACHINE, name, gains(name), point)
    part = settling_pencil(MACHINE, name, gains(name), point)
    outputs = [label for label in part.output_labels if label in whole.output_labels]
    assert {"omega_tilde", "phi_dr_tilde"} <= set(outputs) and len(part.poles()) == 5 + ("h_s" in gains(name))
    one, other = (_responses(system, outputs, [*NOISE, "u_ds_error", "u_qs_error"]) for system in (whole, part))
    assert np.abs(one - other).max() < 1e-10 * np.abs(one).max()
    if "g" in gains(name):  # alpha held is alpha adapted without gain
        whole = full_pencil(MACHINE, name, gains(name) | {"g": 0.0}, point)
        part = settling_pencil(MACHINE, name, gains(name), point, alpha="held")
        one = _responses(whole, outputs, [*NOISE, "u_ds_error", "omega_dot"])
        other = _responses(part, outputs, [*NOISE, "u_ds_error", "omega_dot"])
        assert np.abs(one - other).max() < 1e-10 * np.abs(one).max()
        steady = part["omega_tilde", "alpha_tilde"].dcgain()
        assert np.real(steady) == pytest.approx(-point.slip / MACHINE.alpha, abs=1e-9)


@pytest.mark.parametrize("name", ["repaired", "quiet", "across"])
def test_what_is_left_out_stays_for_ever_and_q_walks(name: str) -> None:
    """A N = -j omega_s N for alpha xi_tilde = j omega z_tilde; q turns alone, but the noise drives it."""
    whole = full_pencil(MACHINE, name, gains(name), POINT)
    at = {label: n for n, label in enumerate(whole.state_labels)}
    z = np.array([0.3, -0.7])
    xi = POINT.omega / MACHINE.alpha * np.array([-z[1], z[0]])
    offset = np.zeros(len(at))
    offset[[at["z_1_tilde"], at["z_2_tilde"], at["xi_1_tilde"], at["xi_2_tilde"]]] = [*z, *xi]
    turned = np.zeros(len(at))
    turned[[at["z_1_tilde"], at["z_2_tilde"], at["xi_1_tilde"], at["xi_2_tilde"]]] = [z[1], -z[0], xi[1], -xi[0]]
    assert np.abs(whole.A @ offset - 63.0 * turned).max() < 1e-9
    q = np.zeros((2, len(at)))
    for k, label in enumerate(("z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde")):
        q[:, at[label]] = lyapunov.conserved(*np.eye(4)[k], GAINS["kappa"], GAINS["k_3"], 1.0)
    assert np.abs(q @ whole.A - 63.0 * np.array([q[1], -q[0]])).max() < 1e-9 * np.abs(whole.A).max()
    assert np.abs(q @ whole.B[:, :2]).max() > 1000


def _modal_h2(name: str, point: OperatingPoint, alpha: str) -> float:
    """H2 norm of current noise to omega_tilde from the complex-step matrices, mode by mode, those on the axis left out."""
    own = gains(name) | ({"g": 0.0} if alpha == "held" else {})
    at = oracle.truth(name, TRUE, own, point.omega, point.flux, point.slip)
    A = oracle.at_estimates(name, TRUE, own, at["x"], at["i"], at["u"], at["frame"], 1.0)
    B = np.empty((len(A), 2))
    for k in range(2):
        i = np.array(at["i"], dtype=complex)
        i[k] += oracle.STEP * 1j
        B[:, k] = -oracle.rates_in_frame(name, TRUE, own, at["x"], i, at["u"], at["frame"], 1.0).imag / oracle.STEP
    values, vectors = np.linalg.eig(A)
    c = vectors[OBSERVERS[name].states.index("omega_hat")]
    b = np.linalg.solve(vectors, B.astype(complex))
    residues = c[:, None] * b
    moving = values.real < -1e-6
    assert np.abs(residues[~moving]).max(initial=0.0) < 1e-6 * np.abs(residues).max()  # they do not reach omega_hat
    values, residues = values[moving], residues[moving]
    gram = residues @ residues.conj().T
    return float(np.sqrt(np.real(np.sum(-gram / (values[:, None] + values.conj()[None, :])))))


@pytest.mark.parametrize("name", STABLE)
@pytest.mark.parametrize("alpha", ["adapted", "held"])
def test_h2_norm_by_three_routes(name: str, alpha: Any) -> None:
    """python-control, scipy's Lyapunov equation, and the modes of the complex-step matrices."""
    from scipy.linalg import solve_continuous_lyapunov

    system = settling_pencil(MACHINE, name, gains(name), POINT, alpha=alpha)["omega_tilde", NOISE]
    found = control.norm(system, 2)
    gramian = solve_continuous_lyapunov(system.A, -system.B @ system.B.T)
    assert found == pytest.approx(float(np.sqrt((system.C @ gramian @ system.C.T).item())), rel=1e-9)
    assert control.system_norm(system, 2) == pytest.approx(found, rel=1e-12)
    assert found == pytest.approx(_modal_h2(name, POINT, alpha), rel=1e-7)


@pytest.mark.parametrize("name", ["baseline", "luenberger_consistent_12", "repaired", "quiet"])
def test_noise_of_a_simulation(name: str) -> None:
    """Variance of omega_hat over 1500 runs of the nonlinear definitions with held noise, and of the sampled linear system."""
    h, deviation, lanes, steps = 2e-4, 1e-3, 1500, 1000
    own = gains(name) | {"k_1": 100.0, "K_p": 10.0, "h": 10.0, "l_1": 300.0}
    own = {gain: own[gain] for gain in OBSERVERS[name].gains}
    system = settling_pencil(MACHINE, name, own, POINT)["omega_tilde", NOISE]
    sampled = control.sample_system(system, h)
    # from the truth on, after so many steps, and not yet at rest: the sum that the norm is, cut off
    state, variance = sampled.B, 0.0
    for _ in range(steps):
        variance += float(np.sum((sampled.C @ state) ** 2))
        state = sampled.A @ state
    expected = deviation * np.sqrt(variance)
    assert expected == pytest.approx(deviation * control.norm(sampled, 2), rel=0.35)
    at = oracle.truth(name, TRUE, own, POINT.omega, POINT.flux, POINT.slip)
    random = np.random.default_rng(1)
    x = np.repeat(np.array(at["x"])[:, None], lanes, axis=1)
    for _ in range(steps):
        i = np.array(at["i"])[:, None] + deviation * random.normal(size=(2, lanes))

        def rates(y: np.ndarray, i: np.ndarray = i) -> np.ndarray:
            return oracle.rates_in_frame(name, TRUE, own, y, i, at["u"], at["frame"], 1.0)

        a = rates(x)
        b = rates(x + h / 2 * a)
        c = rates(x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rates(x + h * c))
    found = np.std(x[-1])
    assert found == pytest.approx(expected, rel=4 / np.sqrt(2 * lanes))  # four standard errors


@pytest.mark.parametrize("name", STABLE)
@pytest.mark.parametrize("alpha", ["adapted", "held"])
def test_the_speed_loop_closes_to_the_system(name: str, alpha: Any) -> None:
    system = settling_pencil(MACHINE, name, gains(name), POINT, alpha=alpha)
    loop = speed_loop(system)
    closed = np.sort_complex(control.feedback(loop, 1).poles())
    assert np.abs(closed - np.sort_complex(system.poles())).max() < 1e-7 * np.abs(closed).max()
    gain, phase, *_ = control.stability_margins(loop, epsw=1e-3)
    assert gain > 1 and phase > 0
    # with the phase margin used up, a pole of the closed loop is on the axis
    crossings = control.stability_margins(loop, epsw=1e-3, returnall=True)[4]
    assert min(abs(1 + np.exp(-1j * np.radians(phase)) * loop(1j * w)) for w in crossings) < 1e-6


@pytest.mark.filterwarnings("ignore:System is unstable")
def test_instability_does_not_pass_for_settled() -> None:
    system = settling_pencil(MACHINE, "printed_L", gains("printed_L"), POINT)["omega_tilde", NOISE]
    assert system.poles().real.max() > 0 and control.norm(system, 2) == np.inf


@pytest.mark.parametrize("name", EQUIVARIANT)
def test_zero_stator_frequency_is_refused_for_it_leaves_a_pole_at_zero(name: str) -> None:
    point = OperatingPoint(20.0, 0.5, -20.0)
    with pytest.raises(InputError, match=r"omega = 20 rad/s and slip = -20 rad/s: the stator frequency is zero"):
        settling_pencil(MACHINE, name, gains(name), point)
    beside = [np.abs(settling_pencil(MACHINE, name, gains(name), OperatingPoint(20.0, 0.5, -20.0 + off)).poles()).min()
              for off in (1e-3, 1e-5)]
    assert beside[1] < 0.02 * beside[0] and beside[1] < 1e-4, "what is refused tends to a pole at zero"
    assert len(settling_pencil(MACHINE, name, gains(name), point, "frozen").poles()) == 4


@pytest.mark.parametrize("name", STABLE)
@pytest.mark.parametrize("alpha", ["adapted", "held"])
def test_a_gain_margin_is_one_or_it_is_rounding(name: str, alpha: Any) -> None:
    """Where the loop is above -180 degrees up to far beyond its poles, the margin is infinite or of the size of rounding."""
    loop = speed_loop(settling_pencil(MACHINE, name, gains(name), POINT, alpha=alpha))
    gain = control.stability_margins(loop, epsw=1e-3)[0]
    far = 1e3 * np.abs(loop.poles()).max()
    frequencies = np.geomspace(1e-3, far, 20_001)
    response = loop(1j * frequencies)
    crosses = bool(np.any((response.imag[:-1] * response.imag[1:] < 0) & (response.real[1:] < 0)))
    assert crosses == (gain < 1e12), gain


def test_the_example_of_the_docstring() -> None:
    import matplotlib

    matplotlib.use("Agg")
    result = doctest.testmod(settling)
    assert result.attempted > 10 and result.failed == 0


@pytest.mark.parametrize(("call", "message"), [
    (lambda: settling_pencil(MACHINE, "quiet", gains("quiet"), POINT, alpha="free"), "alpha = 'free' is not known"),  # type: ignore
    (lambda: settling_pencil(MACHINE, "quiet", gains("quiet") | {"K_p": 0.0}, POINT), "K_p = 0 holds omega_hat"),
    (lambda: settling_pencil(MACHINE, "printed_7", gains("printed_7"), POINT), "no time-invariant linearisation"),
    (lambda: speed_loop(settling_pencil(MACHINE, "quiet", gains("quiet"), POINT, "frozen")), "needs the state omega_tilde"),
])
def test_settling_refusals(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()
