"""The tables of a study file: their keys, units and bounds. Numbers may be text with a unit, such as ``"100 us"``."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, model_validator

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.own import is_file, located
from imo_analysis.notation import symbol
from imo_analysis.quantity import si_value


def _si(unit: str) -> Callable[[Any, ValidationInfo], float]:
    def convert(value: Any, info: ValidationInfo) -> float:
        return si_value(value, unit, info.field_name or "value")

    convert.unit = unit  # type: ignore[attr-defined]  # for messages
    return convert


Seconds = Annotated[float, BeforeValidator(_si("s"))]
Speed = Annotated[float, BeforeValidator(_si("rad/s"))]
Rate = Annotated[float, BeforeValidator(_si("1/s"))]
Torque = Annotated[float, BeforeValidator(_si("N m"))]
Current = Annotated[float, BeforeValidator(_si("A"))]
Voltage = Annotated[float, BeforeValidator(_si("V"))]
Flux = Annotated[float, BeforeValidator(_si("Wb"))]
Number = Annotated[float, BeforeValidator(_si("1"))]
Damping = Annotated[float, BeforeValidator(_si("N m s"))]


class Table(BaseModel):
    """A table of a study: frozen, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=False)


class Simulation(Table):
    """``[simulation]``: time grid and integrator.

    Attributes
    ----------
    duration : float
        Length of the run in s.
    sample_time : float
        Sampling period of the drive in s; the voltage is held over it.
    substeps : int
        Runge-Kutta steps in one sampling period: the knob of accuracy.
    order : int
        4, the classical Runge-Kutta step, or 5, that of Dormand and Prince: half as dear again, and 30 to 900 times as exact
        in the paper's scenarios at one step a sample. Sweeps make runs of order 5 one by one; the map of what an observer can
        drive, and the observers of a replay, have 4.
    record_every : int
        One record in so many sampling periods.
    seed : int
        Seed of all noise.
    """

    duration: Seconds = Field(gt=0, le=1e7)
    sample_time: Seconds = Field(default=1e-4, gt=0, le=1.0)
    substeps: int = Field(default=1, ge=1, le=10_000)
    order: Literal[4, 5] = 4
    record_every: int = Field(default=1, ge=1)
    seed: int = Field(default=0, ge=0, lt=2**63)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.samples < 1:
            raise ValueError(f"duration = {self.duration:g} s must be at least one sample_time = {self.sample_time:g} s")
        if self.record_every > self.samples:
            raise ValueError(f"record_every = {self.record_every} must be at most the {self.samples} samples of the run")
        return self

    @property
    def samples(self) -> int:
        """Number of sampling periods in the run."""
        return round(self.duration / self.sample_time)


class Initial(Table):
    """``[initial]``: state of the machine at time 0."""

    i_ds: Current = 0.0
    i_qs: Current = 0.0
    phi_dr: Flux = 0.0
    phi_qr: Flux = 0.0
    omega: Speed = 0.0


def _profile(time: tuple[float, ...], values: tuple[float, ...], name: str) -> None:
    if not time:
        raise ValueError(f"time = [] must have at least one entry, time = [0.0]; {name} has {len(values)}")
    if len(time) != len(values):
        raise ValueError(f"time has {len(time)} entries and {name} has {len(values)}; they must be as many")
    if time[0] != 0:
        raise ValueError(f"time must start at 0, not at {time[0]:g} s; say what {name} is from the start")
    for before, after in pairwise(time):
        if after <= before:
            raise ValueError(f"time must increase, but {after:g} s follows {before:g} s")


class Reference(Table):
    """``[reference]``: electrical speed over time.

    Attributes
    ----------
    shape : str
        ``steps``: held from each time to the next; ``linear``: joined by lines.
    time : tuple of float
        In s, from 0 on, rising.
    omega : tuple of float
        Electrical speed at each time in rad/s.
    """

    shape: Literal["steps", "linear"] = "steps"
    time: tuple[Seconds, ...]
    omega: tuple[Speed, ...]

    @model_validator(mode="after")
    def _table(self) -> Self:
        _profile(self.time, self.omega, "omega")
        return self


class Load(Table):
    """``[load]``: load torque on the shaft over time. It acts as written in both directions of rotation.

    Attributes
    ----------
    shape : str
        ``steps`` or ``linear``, as in ``[reference]``.
    time : tuple of float
        In s, from 0 on, rising, as in ``[reference]``.
    T_l : tuple of float
        Load torque at each time in N m.
    """

    shape: Literal["steps", "linear"] = "steps"
    time: tuple[Seconds, ...] = (0.0,)
    T_l: tuple[Torque, ...] = (0.0,)

    @model_validator(mode="after")
    def _table(self) -> Self:
        _profile(self.time, self.T_l, "T_l")
        return self


class Drive(Table):
    """``[drive]``: field-oriented control, sampled once a ``sample_time`` with the voltage held in between.

    Attributes
    ----------
    flux : float
        Reference of the rotor flux magnitude in Wb.
    current_bandwidth : float
        Closed-loop bandwidth of the currents in rad/s.
    flux_bandwidth : float
        Closed-loop bandwidth of the rotor flux in rad/s.
    speed_bandwidth : float
        Closed-loop bandwidth of the speed in rad/s.
    voltage_limit : float
        Largest magnitude of the voltage in V, phase peak value.
    current_limit : float
        Largest magnitude of the current reference in A, phase peak value.
    feedback : str
        ``measured``: true speed, flux from the drive's own model; or the name of an observer: its speed and flux.
    errors : dict of str to float
        Relative errors of the machine parameters that the drive believes: 0.1 for 1.1 times the machine's value.
    flux_modulation : float
        Amplitude of the modulation of the flux reference in Wb; 0 for none.
    flux_modulation_frequency : float
        Its frequency in rad/s.
    flux_waveform : str
        ``sine``, ``triangle``, ``square``, or ``two_tone``: equal sines at the frequency and at three times it.
    flux_modulation_off : tuple of two floats
        The modulation pauses from the first time to the second, in s; the same time twice for no pause.
    """

    flux: Flux = Field(gt=0)
    current_bandwidth: Speed = Field(gt=0)
    flux_bandwidth: Speed = Field(gt=0)
    speed_bandwidth: Speed = Field(gt=0)
    voltage_limit: Voltage = Field(gt=0)
    current_limit: Current = Field(gt=0)
    feedback: str = "measured"
    errors: dict[str, float] = {}
    flux_modulation: Flux = Field(default=0.0, ge=0)
    flux_modulation_frequency: Speed = Field(default=0.0, ge=0)
    flux_waveform: Literal["sine", "triangle", "square", "two_tone"] = "sine"
    flux_modulation_off: tuple[Seconds, Seconds] = (0.0, 0.0)

    @model_validator(mode="before")
    @classmethod
    def _believed(cls, values: Any) -> Any:
        if not isinstance(values, dict) or "errors" not in values:
            return values
        if not isinstance(values["errors"], dict):
            raise ValueError(f"errors = {values['errors']!r} must be a table of names and numbers")
        return {**values, "errors": _relative_errors(values["errors"], (*_ERRORS, "J"), "the drive")}

    @model_validator(mode="after")
    def _modulation(self) -> Self:
        if self.flux_modulation >= self.flux:
            raise ValueError(f"flux_modulation = {self.flux_modulation:g} Wb must be below flux = {self.flux:g} Wb")
        if self.flux_modulation > 0 and self.flux_modulation_frequency == 0:
            raise ValueError("flux_modulation_frequency = 0 rad/s must be above 0 when flux_modulation is on")
        if self.flux_modulation_off[1] < self.flux_modulation_off[0]:
            raise ValueError(f"flux_modulation_off = {list(self.flux_modulation_off)} s must be a time and a later one")
        return self


class Sensors(Table):
    """``[sensors]``: what the drive and the observers see of the currents.

    Attributes
    ----------
    sampling : str
        ``continuous``: the observers see the currents at every stage of the integrator, with the sensor error of the
        sample; ``sampled``: they see the sample, held.
    current_noise : float
        Standard deviation of the noise of each current in A, one draw a sample.
    current_offset : tuple of two floats
        Offset of the d and the q current in A.
    current_gain : tuple of two floats
        Gain of the d and the q current; 1 is right.
    current_resolution : float
        Step in A to which each current is rounded, last of all; 0 for none.
    """

    sampling: Literal["continuous", "sampled"] = "continuous"
    current_noise: Current = Field(default=0.0, ge=0)
    current_offset: tuple[Current, Current] = (0.0, 0.0)
    current_gain: tuple[Number, Number] = (1.0, 1.0)
    current_resolution: Current = Field(default=0.0, ge=0)


_ERRORS = ("R_s", "R_r", "L_m", "L_s", "L_r")


def _relative_errors(given: dict[str, Any], known: tuple[str, ...], whose: str) -> dict[str, float]:
    """Relative parameter errors as numbers."""
    for name in given:
        if name not in known:
            raise ValueError(f"errors.{name} is not known for {whose}; it has: {', '.join(known)}")
    errors = {name: si_value(value, "1", f"errors.{name}") for name, value in given.items()}
    for name, error in errors.items():
        if error <= -1:
            raise ValueError(f"errors.{name} = {error:g} must be above -1 (0.1 means 10 % too large)")
    return errors


class ObserverSettings(Table):
    """``[observers.NAME]``: one observer.

    Attributes
    ----------
    kind : str
        Its name in `imo_analysis.equations.catalogue.OBSERVERS`, NAME itself where it is left out; or a file of one's own,
        ``mine.py``, which is written out as its whole path and the hash of its text (`imo_analysis.equations.own`).
    gains : dict of str to float
        Every gain of that kind.
    initial : dict of str to float
        Estimates at time 0; zero where not given.
    errors : dict of str to float
        Relative errors of its machine parameters (R_s, R_r, L_m, L_s, L_r): 0.1 makes it believe 1.1 times the machine's
        value.
    direction : str
        Whence it has the direction of rotation, if it needs one: the ``true`` speed, the speed ``reference``, or its own
        ``estimate``.
    """

    kind: str
    gains: dict[str, float]
    initial: dict[str, float] = {}
    errors: dict[str, float] = {}
    direction: Literal["true", "reference", "estimate"] = "true"

    @model_validator(mode="before")
    @classmethod
    def _named(cls, values: Any) -> Any:
        if not isinstance(values, dict):
            return values
        kind = values.get("kind")
        if not isinstance(kind, str) or not (kind in OBSERVERS or is_file(kind)):
            raise ValueError(f"kind = {kind!r} is not a known observer; choose one of: {', '.join(OBSERVERS)}; or a file of "
                             "your own, mine.py")
        kind = located(kind)
        observer = OBSERVERS[kind]
        units: dict[str, dict[str, str]] = {
            "gains": {name: symbol(name).unit for name in observer.gains},
            "initial": {name: symbol(name).unit for name in observer.states},
        }
        values = {**values, "kind": kind}
        for table, known in units.items():
            given = values.get(table, {})
            if not isinstance(given, dict):
                raise ValueError(f"{table} = {given!r} must be a table of names and numbers")
            for name in given:
                if name not in known:
                    raise ValueError(f"{table}.{name} is not known for {observer.name}; it has: {', '.join(known)}")
            values[table] = {name: si_value(value, known[name], f"{table}.{name}") for name, value in given.items()}
        missing = [name for name in observer.gains if name not in values["gains"]]
        if missing:
            raise ValueError(f"gains of {observer.name} are missing: {', '.join(missing)}")
        if values["gains"].get("delta", 1.0) <= 0:
            raise ValueError(f"gains.delta = {values['gains']['delta']:g} 1/s must be above 0, the width of the layer in (10)")
        if values["gains"].get("k", 1.0) <= 0:
            raise ValueError(f"gains.k = {values['gains']['k']:g} must be above 0: it multiplies the machine's poles, and 1 is "
                             "no feedback")
        errors = values.get("errors", {})
        if not isinstance(errors, dict):
            raise ValueError(f"errors = {errors!r} must be a table of names and numbers")
        return {**values, "errors": _relative_errors(errors, _ERRORS, observer.name)}

    @property
    def gain_values(self) -> tuple[float, ...]:
        """The gains in the order of the catalogue."""
        return tuple(self.gains[name] for name in OBSERVERS[self.kind].gains)

    @property
    def initial_values(self) -> tuple[float, ...]:
        """The initial estimates in the order of the catalogue."""
        return tuple(self.initial.get(name, 0.0) for name in OBSERVERS[self.kind].states)


class Excitation(Table):
    """``[excitation]``: the windows of the Gram matrix (19).

    Attributes
    ----------
    window : float
        Length T of a window in s.
    every : float
        From the start of a window to that of the next, in s.
    """

    window: Seconds = Field(default=0.5, gt=0)
    every: Seconds = Field(default=0.1, gt=0)


class Sweep(Table):
    """Equally spaced speeds, both ends included.

    Attributes
    ----------
    start : float
        The first speed in rad/s.
    stop : float
        The last speed in rad/s.
    count : int
        How many.
    """

    start: Speed
    stop: Speed
    count: int

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.count < 1:
            raise ValueError(f"count = {self.count} makes an empty sweep; it must be 1 or more")
        if self.count > 1 and self.stop <= self.start:
            raise ValueError(f"stop = {self.stop:g} rad/s must be above start = {self.start:g} rad/s")
        return self


class Poles(Table):
    """``[poles]``: the speeds at which the frozen-speed poles are computed.

    Attributes
    ----------
    omega : tuple of float
        Speeds of the table in rad/s.
    sweep : Sweep
        Speeds of the figures.
    """

    omega: tuple[Speed, ...] = Field(default=(30.0, 60.0, 100.0), min_length=1)
    sweep: Sweep = Sweep(start=-150.0, stop=150.0, count=301)


class Window(Table):
    """``[[windows]]``: a stretch of the run shown larger.

    Attributes
    ----------
    title : str
        Heading of the figure.
    caption : str
        What is said below the figure.
    start : float
        Where the window begins, in s.
    stop : float
        Where it ends, in s.
    """

    title: str = "window"
    start: Seconds = Field(ge=0)
    stop: Seconds
    caption: str = ""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.stop <= self.start:
            raise ValueError(f"stop = {self.stop:g} s must be after start = {self.start:g} s")
        return self
