"""The rule of thumb: gains from wished times, flux and machine by formulas alone, which `imo_analysis.tuning.formulas` holds.

Why. The speed error works on the current error along v_2 and back, a loop of second order: omega_n, with K_p b^2 = omega_n^2
and b = beta |phi|, and a = 2 zeta omega_n. The flux error w, which turns with the stator frequency omega_s in the frame of the
flux, is felt along v_2 too; the speed loop is fast and takes that part for speed, so that only the other part drives a current,
and w decays at half of D / a, D = alpha k_3 + kappa |omega|. So D = 2 a (4 / t_r) at the lowest speed, half of it constant,
which needs no direction of rotation, and half kappa |omega|: at higher speed all recovers sooner, and what parameters that are
off do to the flux with every change of speed and load is forgotten sooner. A speed error leaves D / omega_n^2 of itself in w;
that this stays below 2 % at the highest speed, with a quarter to spare, is the second bound on omega_n. And g: alpha_hat moves
with every change of speed (`imo_analysis.equations.drift`), by 2 % of alpha where the speed steps by 0.4 of its range.

The baseline: a and h as k_1 and K_p there; its flux error decays with the rotor's own alpha, whatever is asked. With X = a / 2
the frozen-speed poles of the flux turn at half the speed, as far from the axis as constant gains get them, and a speed error
leaves |omega| X / omega_n^2 = zeta |omega| / omega_n of itself. At a damping of 0.7 that is below 2 % at no speed loop which
10 kHz bear for 150 rad/s; so the damping is 0.55 here, whatever is asked, and the loop 22 times as fast as the machine turns.

Kubota's scheduled gain moves all four frozen poles k times as far out as the machine's, so that a = k (gamma + alpha): it has
no other means to damp the speed loop. Much more than k = 1 loses the speed where the machine brakes slowly, so that the
settling time is what the machine allows, about 8 / (gamma + alpha), with an overshoot of half the step and more.

The baseline that adapts the stator resistance has the baseline's gains, and h_s such that R_s is adapted a tenth as fast as the
rotor's flux decays: its law knows nothing of the flux error, and generating it is unstable at any h_s, the slower the smaller
it is (`imo derive resistance`). The one that turns that law round has, besides, the P_0 below which the law rests: 0.3 of the
power across the air gap at i_d = i_q and a stator frequency of alpha. Less of it acts on noise and on transients near no power,
more leaves R_s wrong where little power flows; three times and a third of it do as well within a few points of a map.

How far it is right: `REGION`, which `imo_analysis.tuning.check` measures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.tuning import formulas
from imo_analysis.tuning.loops import ADAPTS_R_S, RULED, Loops, gains_of, least_current

DAMPING = 0.7

# What holds, by `imo_analysis.tuning.check`: the tests hold it to these numbers.
WIDE, NARROW, SLOW = 1.5, 3.0, 0.25  # least stator frequency, of 4 / t_r (twice); largest speed, of a
RECOVERED = (0.93, 1.0)  # of t_r
NOISE, LAG = 1.2, 1.5  # over the formula's; of t_l
BASELINE_RECOVERED, BASELINE_NOISE = 16.0, 1.05  # rotor time constants; over the formula's
REGION = (
    f"The adaptive observers, right parameters, damping {DAMPING:g}: where the stator frequency, load included, nowhere falls "
    f"below {WIDE:g} times $4/t_r$, they recover in {RECOVERED[0]:g} to {RECOVERED[1]:g} times $t_r$ and their speed estimate "
    f"settles within $t_s$. Where it stays above {NARROW:g} times $4/t_r$, and the speed below {SLOW:g} times $a$, the noise "
    f"is that of the formula to within {100 * (NOISE - 1):.0f} %, and the lag at most {LAG:g} times $t_l$. The flux error "
    "cannot decay faster than it turns: $t_r$ must be above 4 over the least stator frequency.",
    "The baseline with constant gains, likewise: its speed estimate settles within $t_s$, with the noise that the first term "
    f"of the formula gives to within {100 * (BASELINE_NOISE - 1):.0f} %. Its flux recovers with the rotor, whatever is asked: "
    f"within {BASELINE_RECOVERED:g} time constants $1/\\alpha$ where the stator frequency nowhere falls below $\\alpha$.",
    "The baseline with Kubota's scheduled gain: no promise. Its only gain for the flux also sets the damping of the speed "
    "loop, and more of it loses the speed where the machine brakes slowly. With these gains it settles about as fast as the "
    "current decays by itself, and overshoots.",
    "The baselines that adapt $R_s$: no promise either. Generating, one has a pole to the right whatever its gains are; the "
    "one that turns its law round can have a pair there, near zero stator frequency.",
    "Parameter errors are in none of this: `imo tune` judges the rule's gains with them, and verifies them in simulation.",
)


@dataclass(frozen=True)
class Times:
    """What is asked of the rule.

    Attributes
    ----------
    settling, recovery : float
        t_s and t_r in s.
    omega_min, omega_max : float
        Lowest and largest abs(speed) in rad/s.
    damping : float
        zeta.
    lag : float
        t_l in s; infinite for any.
    speed_bandwidth : float
        Of the drive's speed loop in rad/s, for the share of alpha.
    fastest : float
        The largest omega_n in rad/s, where samples bear no more; the other wishes then yield. Infinite for any.
    """

    settling: float
    recovery: float
    omega_min: float
    omega_max: float
    damping: float = DAMPING
    lag: float = math.inf
    speed_bandwidth: float = 45.0
    fastest: float = math.inf

    def __post_init__(self) -> None:
        for name, unit in (("lag", "s"), ("fastest", "rad/s")):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} = {getattr(self, name):g} {unit} must be above 0")
        for name, unit in (("settling", "s"), ("recovery", "s"), ("omega_min", "rad/s"), ("omega_max", "rad/s"),
                           ("damping", ""), ("speed_bandwidth", "rad/s")):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value:g} {unit} must be above 0".replace("  ", " "))
        if self.omega_min > self.omega_max:
            raise InputError(f"omega_min = {self.omega_min:g} rad/s must not be above omega_max = {self.omega_max:g} rad/s")


def rule_loops(machine: InductionMachine, kind: str, times: Times) -> Loops:
    """The loops that the rule makes.

    Raises
    ------
    InputError
        If there is no rule for this kind.
    """
    if kind not in RULED:
        raise InputError(f"observer kind {kind!r} has no tuning rule; choose one of: {', '.join(RULED)}")
    a_0, t_s, t_r, t_l = least_current(machine, kind), times.settling, times.recovery, times.lag
    low, high = times.omega_min, times.omega_max
    if kind == "baseline_scheduled":
        omega_n, current = formulas.scheduled_loops(machine.gamma, machine.alpha, high)
        return Loops(min(omega_n, times.fastest), current, 0.0, 0.0)
    if kind in ("baseline", *ADAPTS_R_S):
        omega_n = min(formulas.baseline_speed(formulas.BASELINE_DAMPING, t_s, t_l, high, a_0), times.fastest)
        current = max(2 * formulas.BASELINE_DAMPING * omega_n, a_0)
        return Loops(omega_n, current, formulas.baseline_feedback(current, machine.alpha), 0.0)
    omega_n = min(formulas.adaptive_speed(times.damping, t_s, t_r, t_l, low, high, a_0), times.fastest)
    current = max(2 * times.damping * omega_n, a_0)
    if kind == "consistent_12":
        constant, k_2 = formulas.printed_feedback(current, t_r, high)
        return Loops(omega_n, current, constant, k_2 * high)
    return Loops(omega_n, current, *formulas.adaptive_feedback(current, t_r, low))


def rule_gains(machine: InductionMachine, kind: str, flux: float, times: Times) -> dict[str, float]:
    """Every gain of an observer by the rule; those that it says nothing of at their usual values.

    alpha_l and delta of the projection (10) are half and a tenth of the believed alpha; a supervisor forgets in 1 s and opens
    at a flux that swings by 6 % of itself within 1 / alpha.

    Parameters
    ----------
    machine : InductionMachine
        As the observer believes it.
    kind : str
        Of the observer, a name of the catalogue.
    flux : float
        Rotor flux in Wb.
    times : Times
        How fast its loops are to be.
    """
    if not (math.isfinite(flux) and flux > 0):
        raise InputError(f"flux = {flux:g} Wb must be above 0 Wb to choose gains")
    found = {name: float(value) for name, value in
             gains_of(machine, kind, flux, rule_loops(machine, kind, times), times.omega_max).items()}
    return found | alpha_gains(machine, kind, flux, found.get("K_p", 0.0), times)


def alpha_gains(machine: InductionMachine, kind: str, flux: float, K_p: float, times: Times) -> dict[str, float]:
    """The gains of the adaptation of alpha: g from the drift that a speed step may cause, the others at their usual values."""
    if kind.startswith("baseline"):
        return {}
    step = formulas.ALPHA_STEP * times.omega_max
    g = formulas.alpha_gain(machine.alpha, flux, machine.L_m, machine.mu, K_p, step, times.speed_bandwidth)
    more = {"g": g, "alpha_l": machine.alpha / 2, "delta": machine.alpha / 10}
    if kind == "supervised":
        more |= {"eta": 1.0, "S_0": 4e-3 * (machine.beta * flux) ** 2}
    return more


def rule_noise(machine: InductionMachine, kind: str, flux: float, times: Times, omega: float) -> float:
    """What the rule says of the noise at a speed: deviation in rad/s for noise of density 1 A^2 s on the currents."""
    loops = rule_loops(machine, kind, times)
    # consistent_12 feeds k_2 omega^2 back where the others feed D_1 omega; the baselines' flux has no such term
    rising = loops.rising * (omega / times.omega_max if kind == "consistent_12" else 1.0)
    strength = math.inf if kind.startswith("baseline") else loops.constant + rising * omega
    return float(formulas.noise_density(loops.omega_n, loops.current, strength, omega, machine.beta, flux, machine.R_s,
                                        machine.sigma, machine.gamma, machine.alpha, math.sqrt))
