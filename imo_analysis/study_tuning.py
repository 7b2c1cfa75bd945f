"""The table ``[tuning]`` of a study: what is wished of the speed estimates, for ``imo tune``."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from imo_analysis.quantity import si_value
from imo_analysis.study_tables import Current, Number, Seconds, Speed, Table, Torque

_UNCERTAIN = ("R_s", "R_r", "L_m", "L_s", "L_r")


class Tuning(Table):
    """``[tuning]``: over which range, and what is wished there.

    Attributes
    ----------
    observers : tuple of str
        Observers of the study to tune; all that can be where left out.
    omega : tuple of two floats
        The range of abs(speed) in rad/s, electrical; above 0, for at zero stator frequency no estimate settles.
    directions : str
        ``both`` or ``forward``.
    torque : float, optional
        Largest load torque of either sign in N m; what three quarters of the magnetising current give where left out.
    settling_time : float
        In s: after a step of the speed its estimate is within 2 % of the step.
    recovery_time : float
        In s: four time constants of the slowest error, of the flux too.
    damping : float
        The speed estimate overshoots no more than a second-order system of this damping.
    speed_noise : float, optional
        Largest standard deviation of the speed estimate in rad/s, electrical; as little as the rest allows where left out.
    speed_error : float, optional
        Largest error of the speed at rest in rad/s that the uncertainty may cause; reported only where left out.
    lag : float
        Largest lag behind an even acceleration, in s (rad/s for 1 rad/s^2).
    current_noise : float, optional
        Standard deviation of each current sample in A; that of ``[sensors]`` where left out, and 0.1 A if that is zero.
    uncertainty : dict of str to float
        Relative errors, of either sign, of what the observers believe of R_s, R_r, L_m, L_s, L_r.
    runs : int
        Simulations with random errors that the gains are verified on.
    seed : int
        Of search and simulations.
    """

    observers: tuple[str, ...] = ()
    omega: tuple[Speed, Speed] = (20.0, 150.0)
    directions: Literal["both", "forward"] = "both"
    torque: Torque | None = None
    settling_time: Seconds = Field(default=0.015, gt=0, le=100)
    recovery_time: Seconds = Field(default=2.5, gt=0, le=1000)
    damping: Number = Field(default=0.5, gt=0, lt=1)
    speed_noise: Speed | None = Field(default=None, gt=0)
    speed_error: Speed | None = Field(default=None, gt=0)
    lag: Seconds = Field(default=0.001, gt=0)
    current_noise: Current | None = Field(default=None, gt=0)
    uncertainty: dict[str, float] = Field(default={"R_s": 0.05, "R_r": 0.2})
    runs: int = Field(default=64, ge=1, le=100_000)
    seed: int = Field(default=1, ge=0, lt=2**31)

    @model_validator(mode="before")
    @classmethod
    def _uncertain(cls, values: Any) -> Any:
        if not isinstance(values, dict) or not isinstance(given := values.get("uncertainty", {}), dict):
            return values
        found = {}
        for name, value in given.items():
            if name not in _UNCERTAIN:
                raise ValueError(f"uncertainty.{name} is not known; it has: {', '.join(_UNCERTAIN)}")
            found[name] = si_value(value, "1", f"uncertainty.{name}")
            if not 0 <= found[name] < 1:
                raise ValueError(f"uncertainty.{name} = {found[name]:g} must be at least 0 and below 1 (0.1 means +-10 %)")
        return {**values, "uncertainty": found} if "uncertainty" in values else values

    @model_validator(mode="after")
    def _range(self) -> Self:
        low, high = self.omega
        if not 0 < low < high:
            raise ValueError(f"omega = [{low:g}, {high:g}] rad/s must be two speeds, the first above 0: at zero stator "
                             "frequency nothing determines the speed; directions says whether both signs are meant")
        if self.torque is not None and not self.torque >= 0:
            raise ValueError(f"torque = {self.torque:g} N m must be 0 or above; either sign is meant")
        if self.settling_time > self.recovery_time:
            raise ValueError(f"settling_time = {self.settling_time:g} s must not be above recovery_time = "
                             f"{self.recovery_time:g} s")
        return self
