"""The induction machine: SI parameters, the derived ones of Table I, circuit forms, presets with their sources, TOML."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator

from imo_analysis.equations import parameters
from imo_analysis.errors import InputError, unknown_key
from imo_analysis.notation import symbol
from imo_analysis.quantity import si_value, with_unit

# name -> (lowest, highest) value that a rotating machine can have; outside it a unit was mistaken
_BOUNDS = {
    "R_s": (1e-6, 1e4),
    "R_r": (1e-6, 1e4),
    "L_m": (1e-7, 1e3),
    "L_s": (1e-7, 1e3),
    "L_r": (1e-7, 1e3),
    "J": (1e-12, 1e6),
}


class InductionMachine(BaseModel):
    """An induction machine in the T form, referred to the stator, amplitude-invariant two-phase scaling.

    Parameters
    ----------
    n_p : int
        Pole pairs, at least 1.
    R_s : float
        Stator resistance in ohm.
    R_r : float
        Rotor resistance in ohm, referred to the stator.
    L_m : float
        Mutual inductance in H, with L_m^2 < L_s L_r.
    L_s : float
        Stator inductance in H: mutual and leakage.
    L_r : float
        Rotor inductance in H, referred to the stator: mutual and leakage.
    J : float
        Inertia of rotor and load in kg m^2.
    B : float
        Viscous friction in N m s.
    name : str
        What it is.
    source : str
        Where its numbers come from.

    Raises
    ------
    InputError
        From `InductionMachine.build` and `load`, for values that no machine can have.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", ignored_types=(cached_property,))

    n_p: int = Field(ge=1, le=200)
    R_s: float
    R_r: float
    L_m: float
    L_s: float
    L_r: float
    J: float
    B: float = 0.0
    name: str = "unnamed"
    source: str = ""

    @model_validator(mode="after")
    def _physical(self) -> Self:
        for field, (lowest, highest) in _BOUNDS.items():
            value = getattr(self, field)
            unit = symbol(field).unit
            if not math.isfinite(value):
                raise ValueError(f"{field} = {value} must be a finite number in {unit}")
            if value <= 0:
                raise ValueError(f"{field} = {value:g} {unit} must be above 0 {unit}")
            if not lowest <= value <= highest:
                raise ValueError(f"{field} = {value:g} {unit} must lie in {lowest:g} .. {highest:g} {unit}; is the unit right?")
        if not (math.isfinite(self.B) and self.B >= 0):
            raise ValueError(f"B = {self.B:g} N m s must be 0 or above")
        bound = math.sqrt(self.L_s * self.L_r)
        if self.L_m >= bound:
            raise ValueError(f"L_m = {self.L_m:g} H must be below sqrt(L_s L_r) = {bound:.4g} H")
        return self

    @classmethod
    def build(cls, values: dict[str, Any], where: str = "machine") -> Self:
        """Build from a mapping; text with units is allowed. ``where`` names the place in error texts.

        The mapping holds either all parameters, or ``preset`` with the ones that differ from it.

        Parameters
        ----------
        values : dict
            Numbers in SI units or text with a unit, by attribute; all of them, or ``preset`` and what differs.
        where : str
            Names the place in error texts.
        """
        from pydantic import ValidationError

        values = dict(values)
        if "preset" in values:
            values = {**preset(values.pop("preset"), where).model_dump(), **values}
        for field in (*_BOUNDS, "B"):
            if field in values:
                values[field] = si_value(values[field], symbol(field).unit, f"{where}.{field}")
        try:
            return cls(**values)
        except ValidationError as error:
            raise InputError(readable(error, where, cls)) from None

    @cached_property
    def sigma(self) -> float:
        """Total leakage inductance in H, (L_s L_r - L_m^2) / L_r."""
        return parameters.leakage(self.L_s, self.L_m, self.L_r)

    @cached_property
    def alpha(self) -> float:
        """R_r / L_r in 1/s."""
        return parameters.rotor_rate(self.R_r, self.L_r)

    @cached_property
    def beta(self) -> float:
        """L_m / (sigma L_r) in 1/H."""
        return parameters.coupling(self.L_m, self.sigma, self.L_r)

    @cached_property
    def gamma(self) -> float:
        """R_s / sigma + alpha beta L_m in 1/s."""
        return parameters.current_decay(self.R_s, self.L_m, self.sigma, self.alpha, self.beta)

    @cached_property
    def mu(self) -> float:
        """3 n_p^2 L_m / (2 J L_r) in 1/(kg m^2); the paper's Table I leaves out n_p^2 and J."""
        return parameters.torque_gain(self.n_p, self.L_m, self.L_r, self.J)

    @property
    def plant_parameters(self) -> tuple[float, float, float, float, float, float, float, float]:
        """``(R_s, L_m, sigma, beta, alpha, mu, n_p, J)``, as `equations.plant` takes them."""
        return (self.R_s, self.L_m, self.sigma, self.beta, self.alpha, self.mu, float(self.n_p), self.J)

    @property
    def observer_parameters(self) -> tuple[float, float, float, float, float]:
        """``(R_s, L_m, sigma, beta, alpha)``, as the observers take them."""
        return (self.R_s, self.L_m, self.sigma, self.beta, self.alpha)

    def with_values(self, **values: Any) -> Self:
        """A copy with some parameters replaced, checked anew.

        Parameters
        ----------
        **values : float
            Parameters by name, in SI units or text with a unit.
        """
        return type(self).build({**self.model_dump(), **values}, self.name)

    # Circuit forms -------------------------------------------------------------------------------------------------
    def inverse_gamma(self) -> dict[str, float]:
        """Inverse-Gamma form: all leakage on the stator side. Keys R_s, R_R (ohm), L_sgm, L_M (H)."""
        k = self.L_m / self.L_r
        return {"R_s": self.R_s, "R_R": k * k * self.R_r, "L_sgm": self.sigma, "L_M": k * self.L_m}

    def gamma_form(self) -> dict[str, float]:
        """Gamma form: all leakage on the rotor side. Keys R_s, R_r (ohm), L_s, L_ell (H)."""
        k = self.L_s / self.L_m
        return {"R_s": self.R_s, "R_r": k * k * self.R_r, "L_s": self.L_s, "L_ell": k * k * self.L_r - self.L_s}

    @classmethod
    def from_inverse_gamma(cls, *, n_p: int, R_s: float, R_R: float, L_sgm: float, L_M: float, J: float, **more: Any) -> Self:
        """Build from inverse-Gamma parameters, with rotor flux and inductance as that form sees them (L_r = L_m = L_M).

        Parameters
        ----------
        n_p : int
            Pole pairs.
        R_s, R_R : float
            Stator and rotor resistance in ohm.
        L_sgm, L_M : float
            Leakage and magnetising inductance in H.
        J : float
            Inertia in kg m^2.
        **more : float or str
            B, name, source.
        """
        return cls.build({"n_p": n_p, "R_s": R_s, "R_r": R_R, "L_m": L_M, "L_r": L_M, "L_s": L_M + L_sgm, "J": J, **more})

    # Files ---------------------------------------------------------------------------------------------------------
    @classmethod
    def load(cls, path: str) -> Self:
        """Read a machine from a TOML file, either its table ``[machine]`` or the whole file.

        Parameters
        ----------
        path : str
            The file.
        """
        from imo_analysis.files import read_toml

        data = read_toml(path)
        check_tables(data, path)
        inner = data.get("machine", data)
        if not isinstance(inner, dict):
            raise InputError(f"{path}: machine must be a table, [machine]")
        if "nameplate" in data and not inner.keys() >= {*_BOUNDS, "n_p"}:
            raise InputError(f"{path} has a [nameplate] and not all of [machine]; make a study of it, imo study --init "
                             f"study.toml --machine {path}, and give that file here: its [machine] is whole")
        return cls.build(inner, f"{path}: machine")

    def to_toml(self) -> str:
        """The machine as a TOML table ``[machine]`` with units in comments."""
        lines = ["[machine]", f"name = {_quoted(self.name)}", f"source = {_quoted(self.source)}"]
        for field in ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J", "B"):
            entry = symbol(field)
            unit = "" if entry.unit == "1" else f"{entry.unit}: "
            lines.append(f"{field} = {getattr(self, field)!r}  # {unit}{entry.meaning}")
        return "\n".join(lines) + "\n"


def check_tables(data: dict[str, Any], where: str) -> None:
    """Refuse a table of a machine file whose name is nearly that of one which is read.

    Raises
    ------
    InputError
        If there is one.
    """
    import difflib

    for name, value in data.items():
        plain = "".join(letter for letter in name.lower() if letter.isalpha())
        near = difflib.get_close_matches(plain, ("nameplate", "machine"), 1, 0.7)
        if isinstance(value, dict) and near and name not in ("nameplate", "machine"):
            raise InputError(f"{where}: [{name}] is not a table of a machine file; did you mean [{near[0]}]?")


def _quoted(text: str) -> str:
    import json

    return json.dumps(text, ensure_ascii=False)


_BOUND = {"greater_than": ("gt", "above {}"), "greater_than_equal": ("ge", "{} or above"),
          "less_than": ("lt", "below {}"), "less_than_equal": ("le", "{} or below")}
_KIND = {"literal_error": "be {expected}", "dict_type": "be a table", "tuple_type": "be a list", "string_type": "be text",
         **dict.fromkeys(("int_type", "int_from_float", "int_parsing"), "be a whole number"),
         "too_short": "have {min_length} or more entries", "too_long": "have {max_length} or fewer entries"}


def readable(error: Any, where: str, model: Any = None) -> str:
    """All faults that pydantic found, each as ``where.field = value unit must be ...``, without its web addresses.

    Parameters
    ----------
    error : pydantic.ValidationError
    where : str
        Names the place.
    model : type, optional
        The model that was built: it has units and known keys.
    """
    faults = []
    for fault in error.errors(include_url=False):
        place = ".".join([where, *(str(part) for part in fault["loc"])])
        text = fault["msg"].removeprefix("Value error, ")
        known, unit = _field(model, fault["loc"])
        if fault["type"] == "missing":
            faults.append(f"{place} is missing")
        elif fault["type"] == "extra_forbidden":
            faults.append(unknown_key(place.rpartition(".")[0], str(fault["loc"][-1]), known))
        elif fault["type"] == "value_error":
            faults.append(f"{text} ({place})")
        elif fault["type"] in _BOUND:
            name, words = _BOUND[fault["type"]]
            value, bound = (with_unit(number, unit) for number in (fault["input"], fault["ctx"][name]))
            faults.append(f"{place} = {value} must be {words.format(bound)}")
        elif fault["type"] in _KIND:
            faults.append(f"{place} = {fault['input']!r} must {_KIND[fault['type']].format(**fault.get('ctx', {}))}")
        else:
            faults.append(f"{place} = {fault['input']!r}: {text[0].lower()}{text[1:]}")
    return "; ".join(faults)


def _field(model: Any, place: tuple[Any, ...]) -> tuple[tuple[str, ...], str]:
    """Keys of the table that ``place`` lies in, and the unit of its last part; empty where they are not known."""
    unit = ""
    known: tuple[str, ...] = ()
    for part in place:
        model = _table_in(model)
        if model is None or isinstance(part, int):
            continue
        fields = {info.alias or name: info for name, info in model.model_fields.items()}
        known = tuple(fields)
        if part not in fields:
            return known, unit
        model = fields[part].annotation
        marks = [*fields[part].metadata, *(mark for inner in get_args(model) for mark in getattr(inner, "__metadata__", ()))]
        unit = next((mark.func.unit for mark in marks if hasattr(getattr(mark, "func", None), "unit")), "")
    return known, unit


def _table_in(annotation: Any) -> Any:
    """The model in an annotation such as ``tuple[Window, ...]``; None where there is none."""
    if hasattr(annotation, "model_fields"):
        return annotation
    return next((found for inner in get_args(annotation) if (found := _table_in(inner)) is not None), None)


_PAPER = "You, Wu, Wang, An Adaptive Luenberger Observer, ACC 2018 (MERL TR2018-090), Table III"
_TABLE_III: dict[str, Any] = {
    "n_p": 2, "R_s": 0.439, "R_r": 0.41, "L_m": 60.1e-3, "L_s": 60.1e-3 + 1.4e-3, "L_r": 60.1e-3 + 1.8e-3, "J": 0.0163,
}

# Table III gives R_r = 0.41 ohm and L_r = 61.9 mH, so alpha = 6.6236 /s, and prints alpha = 9.9354 /s, 1.5 times that. The
# text starts alpha_hat at 6.6 and calls 9.9354 the nominal value: the simulated motor is the table's with +50 % rotor
# resistance, and the observers start from the table's own. Both readings are kept, under two names.
PRESETS: dict[str, InductionMachine] = {
    "table-iii": InductionMachine(
        **_TABLE_III, name="table-iii", source=f"{_PAPER}; alpha = R_r/L_r = 6.6236 /s"),
    "table-iii-printed-alpha": InductionMachine(
        **{**_TABLE_III, "R_r": 9.9354 * 61.9e-3}, name="table-iii-printed-alpha",
        source=f"{_PAPER}; R_r = 0.615 ohm so that alpha is the printed 9.9354 /s"),
    # Motors to try things on besides the paper's.
    "motulator-2.2-kw": InductionMachine.from_inverse_gamma(
        n_p=2, R_s=3.7, R_R=2.1, L_sgm=0.021, L_M=0.224, J=0.015, name="motulator-2.2-kw",
        source="2.2 kW, 400 V, 50 Hz, 5 A, 14.6 N m: the induction machine of the examples of Aalto-Electric-Drives/motulator"),
    "modelica-50-hp": InductionMachine(
        n_p=2, R_s=0.09961, R_r=0.05837, L_m=0.03039, L_s=0.031257, L_r=0.031257, J=0.4, name="modelica-50-hp",
        source="50 hp, 460 V, 60 Hz: record IM_50HP_460V_60Hz of the Modelica library lbl-srg/modelica-buildings"),
}
PAPER_PRESETS = ("table-iii", "table-iii-printed-alpha")


def preset(name: object, where: str = "machine") -> InductionMachine:
    """A built-in machine by name.

    Parameters
    ----------
    name : str
        One of `PRESETS`.
    where : str
        Names the place in error texts.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if not isinstance(name, str) or name not in PRESETS:
        raise InputError(f"{where}.preset = {name!r} is not known; choose one of: {', '.join(PRESETS)}")
    return PRESETS[name]
