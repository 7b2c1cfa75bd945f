"""What a Gram matrix says, in words: lost directions by the names of the states, and a verdict in a sentence or two."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from imo_analysis.excitation.conditions import CONDITIONS

Array = NDArray[np.float64]
MOST_STRETCHES = 1000  # in plain data
_WEIGHT = 0.02  # share of a lost direction below which a state is not named


@dataclass(frozen=True)
class Lost:
    """Directions that were lost alike over some of the windows.

    Attributes
    ----------
    text : str
        In the names of the states.
    share : float
        Fraction of the windows with a value in which they are lost.
    dimensions : int
        How many.
    slopes : tuple of float
        Lowest, median and highest omega part of (1, slope) where one direction mixes alpha_hat and omega_hat; else empty.
    """

    text: str
    share: float
    dimensions: int
    slopes: tuple[float, ...] = ()


def lost_directions(result: xr.Dataset, condition: str) -> list[Lost]:
    """The lost directions of a condition, the most frequent first.

    Parameters
    ----------
    result : xarray.Dataset
        From `imo_analysis.excitation.trajectory.excitation`.
    condition : str
        A name in `CONDITIONS` that the data set holds.
    """
    values = result[f"{condition}_eigenvalue"].values
    defined = np.isfinite(values[:, 0])
    values, vectors = values[defined], result[f"{condition}_vector"].values[defined]
    factor, states = result[f"{condition}_factor"].values, CONDITIONS[condition].states
    counts = (values <= result.attrs["threshold"] * values[:, -1:]).sum(axis=1)
    found: dict[tuple[str, int], list[float]] = {}
    for count in range(1, len(states) + 1):
        alike = vectors[counts == count][:, :, :count]
        if states[0] == "xi_1_hat":
            parts = _without_structural(alike, found)
        else:
            parts = [alike]
        for rest in parts:
            _name(rest, factor, states, found)
    scale = _windows_a_row(result, condition, counts)
    return sorted((_summary(key, slopes, max(1.0, len(values)) / scale) for key, slopes in found.items()),
                  key=lambda one: -one.share)


def _windows_a_row(result: xr.Dataset, condition: str, counts: NDArray[Any]) -> float:
    """Share of the windows that lose something over that of the kept rows: below 1 where rows stand for their worst window."""
    holds = result[f"{condition}_holds"].attrs
    judged = holds["windows"] - holds["undefined"]
    kept = float((counts > 0).mean()) if len(counts) else 0.0
    return (judged - holds["holding"]) / judged / kept if kept and judged else 1.0


def _summary(key: tuple[str, int], slopes: list[float], count: float) -> Lost:
    text, dimensions = key
    known = [s for s in slopes if np.isfinite(s)]
    if not known:
        return Lost(text, len(slopes) / count, dimensions)
    low, middle, high = min(known), float(np.median(known)), max(known)
    if high - low > 0.02 * max(abs(low), abs(high)):
        along = f"(1, c), c = {low:.3g} to {high:.3g}, median {middle:.3g}"
    else:
        along = f"(1, {middle:.3g})"
    return Lost(f"{text} along {along}", len(slopes) / count, dimensions, (low, middle, high))


def _without_structural(lost: Array, found: dict[tuple[str, int], list[float]]) -> list[Array]:
    """Take the directions without alpha_hat and omega_hat out of lost subspaces of (19); the rest is orthogonal to them.

    ``lost`` has shape (windows, 6, k), orthonormal columns. Returns the rests, grouped by their dimension.
    """
    count = lost.shape[2]
    _, sizes, right = np.linalg.svd(lost[:, 4:, :])
    sizes = np.concatenate([sizes, np.zeros((len(lost), count))], axis=1)[:, :count]
    turned = lost @ np.swapaxes(right, 1, 2)
    inside = (sizes * sizes < _WEIGHT).sum(axis=1)
    for number, text in ((1, "xi_hat and z_hat along one direction of alpha xi_tilde = j omega z_tilde"),
                         (2, "xi_hat and z_hat along alpha xi_tilde = j omega z_tilde")):
        hits = int((np.minimum(inside, 2) == number).sum())
        if hits:
            found.setdefault((text, number), []).extend([np.nan] * hits)
    return [turned[inside == number][:, :, : count - number] for number in range(count)]


def _name(lost: Array, factor: Array, states: tuple[str, ...], found: dict[tuple[str, int], list[float]]) -> None:
    """Name subspaces of shape (windows, states, k), with the slope of a line in (alpha, omega); one entry a window."""
    dimensions = lost.shape[2]
    if not len(lost) or not dimensions:
        return
    heavy = (lost * lost).sum(axis=2) / dimensions > _WEIGHT
    patterns, which = np.unique(heavy, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        named = [state for state, in_it in zip(states, pattern, strict=True) if in_it]
        members = lost[which.ravel() == number]
        slopes = [np.nan] * len(members)
        if dimensions == 1 and named == ["alpha_hat", "omega_hat"]:
            text = "alpha_hat and omega_hat"
            slopes = (members[:, -1, 0] * factor[-1] / (members[:, -2, 0] * factor[-2])).tolist()
        elif dimensions == 1 and len(named) == 1:
            text = f"{named[0]} alone"
        else:
            text = f"{dimensions} directions in {_listed(named)}" if dimensions > 1 else f"one direction in {_listed(named)}"
        found.setdefault((text, dimensions), []).extend(slopes)


def _listed(names: list[str]) -> str:
    return ", ".join(names[:-1]) + " and " + names[-1] if len(names) > 1 else "".join(names)


def verdict(result: xr.Dataset) -> str:
    """What the conditions say along the run, in plain sentences."""
    lines = [f"{_subject(result)}, windows of {result.attrs['window']:g} s", *(f"  {text}" for text in standstill(result))]
    if "stretch" in result.dims:
        lines.append(f"  {stretches_text(result)}")
    for name in conditions_in(result):
        lines.append(f"  {CONDITIONS[name].title}: {_sentence(result, name)}")
        lines += [f"    {text}" for text in (excited_text(result, name), level_text(result, name), instants_text(result, name))
                  if text]
    return "\n".join(lines)


def standstill(result: xr.Dataset) -> list[str]:
    """What must be said before any condition: that there is no flux, or that all signals stand still."""
    if result.attrs["flux_current"] == 0:
        lost = "omega_hat" if result.attrs["alpha_direction"] else "alpha_hat and omega_hat"
        return [f"there is no flux, z_hat = i_hat throughout: nothing tells of {lost} (nor is there a current to scale by; 1 A "
                "is taken)"]
    if result.attrs["still"]:
        return ["the signals stand still, as at zero stator frequency: a regressor of two rows that never changes shows two "
                "directions and no more"]
    return []


def level_text(result: xr.Dataset, name: str) -> str:
    """The shortest length T with which a condition holds in every window, of those looked at, and its level m; or nothing."""
    window, lowest = result[f"{name}_level_window"].values, result[f"{name}_level"].values
    holding = np.flatnonzero(result[f"{name}_level_holds"].values)
    if not len(holding):
        return ""
    first = holding[0]
    return (f"the shortest windows that hold throughout, of lengths that double: T = {window[first]:.3g} s, with m = "
            f"{lowest[first] * window[first]:.3g} s (scaled)")


def stretches_text(result: xr.Dataset) -> str:
    """Into how much of how many stretches the gaps leave windows."""
    time, judged = result["stretch_time"].values, result["stretch_judged"].values
    short = int((judged == 0).sum())
    text = (f"{len(time)} stretches between gaps, each judged on its own: {judged.sum():.4g} of their {time.sum():.4g} s are "
            "in windows")
    return text + (f"; {short} stretch{'es are' if short > 1 else ' is'} too short for one" if short else "")


def excited_text(result: xr.Dataset, name: str) -> str:
    """Which stretches between gaps are excited throughout, in part, or nowhere; empty without gaps."""
    if "stretch" not in result.dims:
        return ""
    judged, holding = result[f"{name}_judged"].values, result[f"{name}_holding"].values
    whole = np.flatnonzero((judged > 0) & (holding == judged))
    part, of = int(((holding > 0) & (holding < judged)).sum()), int((judged > 0).sum())
    text = f"of {of} stretch{'es' if of != 1 else ''} with a value it holds throughout in {len(whole)}"
    if len(whole):
        text += f", {result['stretch_judged'].values[whole].sum():.4g} s ({_spans(result, whole)})"
    return f"{text}, in part in {part}, nowhere in {of - len(whole) - part}"


def _spans(result: xr.Dataset, which: NDArray[np.intp]) -> str:
    start, time = result["stretch_start"].values, result["stretch_time"].values
    text = ", ".join(f"{start[k]:.4g} to {start[k] + time[k]:.4g} s" for k in which[:_SHOWN])
    return text + (f", and {len(which) - _SHOWN} more" if len(which) > _SHOWN else "")


_SHOWN = 6  # instants, or stretches, that a sentence lists


def instants_text(result: xr.Dataset, name: str) -> str:
    """When excitation appears and disappears, as ends of windows; empty where it never changes."""
    count = result[f"{name}_holds"].attrs["transitions"]
    if not count:
        return ""
    times, appears = result[f"{name}_instant"].values[:_SHOWN], result[f"{name}_appears"].values[:_SHOWN]
    text = ", ".join(f"{'appears' if there else 'disappears'} at {time:.4g} s"
                     for time, there in zip(times, appears, strict=True))
    return f"excitation {text}" + (f", and {count - len(times)} more" if count > len(times) else "")


def conditions_in(result: xr.Dataset) -> list[str]:
    """The conditions that a result holds."""
    return [name for name in CONDITIONS if f"{name}_eigenvalue" in result]


def _subject(result: xr.Dataset) -> str:
    if result.attrs["observer"] == "plant":
        return "the motion itself (true signals, as a converged observer would see them)"
    return f"observer {result.attrs['observer']} ({result.attrs['values']} alpha and omega in B*)"


def _sentence(result: xr.Dataset, name: str) -> str:
    holds = result[f"{name}_holds"].attrs
    judged = holds["windows"] - holds["undefined"]
    gaps = ""
    if holds["undefined"]:
        gaps = f" {holds['undefined']} of {holds['windows']} windows hold {_gaps(result)} and are left out."
    if not judged:
        return f"no verdict: every window holds {_gaps(result)}."
    share = holds["holding"] / judged
    if share == 1:
        return f"holds in every window, with level m = {holds['lowest'] * result.attrs['window']:.3g} s (scaled).{gaps}"
    text = "never holds" if share == 0 else f"holds in {_percent(share)} of the windows and so not for all t"
    if not result[f"{name}_level_holds"].values.any():
        reach = f"{float(result[f'{name}_level_window'][-1]):.4g} s"
        text += f", nor do all windows of any length up to {reach if 'stretch' in result.dims else f'the {reach} of the run'}"
    lost = [f"{one.text} ({_percent(one.share)} of the windows)" for one in lost_directions(result, name)[:3]]
    return f"{text}; lost: {'; '.join(lost)}.{gaps}"


def _gaps(result: xr.Dataset) -> str:
    words = {"NaN": result.attrs["nan"], "infinite values": result.attrs["infinite"]}
    return " or ".join(word for word, there in words.items() if there)


def _percent(share: float) -> str:
    return "all" if share == 1 else f"{100 * share:.3g} %"


def summary(result: xr.Dataset) -> dict[str, Any]:
    """The result in plain data, for JSON."""
    data: dict[str, Any] = {key: result.attrs[key] for key in
                            ("observer", "values", "window", "every", "threshold", "scaling", "samples")}
    data["verdict"] = verdict(result)
    data["standstill"] = standstill(result)
    if "stretch" in result.dims:
        judged = result["stretch_judged"].values
        data |= {"stretches": len(judged), "stretches_too_short": int((judged == 0).sum()),
                 "time": float(result["stretch_time"].sum()), "time_judged": float(judged.sum())}
    data["conditions"] = {}
    for name in conditions_in(result):
        values = result[f"{name}_eigenvalue"].values
        data["conditions"][name] = {
            "title": CONDITIONS[name].title, "states": list(CONDITIONS[name].states),
            **{key: result[f"{name}_holds"].attrs[key] for key in ("windows", "holding", "undefined", "transitions")},
            "level": [{"window": float(w), "smallest_eigenvalue": float(v), "holds": bool(h)} for w, v, h in
                      zip(*(result[f"{name}_{one}"].values for one in ("level_window", "level", "level_holds")), strict=True)],
            "shortest": level_text(result, name), "changes": instants_text(result, name),
            "rank": {"lowest": int(result[f"{name}_rank"].min()), "highest": int(result[f"{name}_rank"].max())},
            "largest_eigenvalue": float(np.nanmax(values)) if np.isfinite(values).any() else None,
            "lost": [vars(one) for one in lost_directions(result, name)],
            "instants": [{"time": float(t), "appears": bool(a)} for t, a in
                         zip(result[f"{name}_instant"].values, result[f"{name}_appears"].values, strict=True)],
            **_by_stretch(result, name),
        }
    return data


def _by_stretch(result: xr.Dataset, name: str) -> dict[str, Any]:
    """The first stretches that hold windows, with how many; nothing without gaps."""
    if "stretch" not in result.dims:
        return {}
    first = np.flatnonzero(result["stretch_judged"].values > 0)[:MOST_STRETCHES]
    columns = (result[key].values[first] for key in ("stretch_start", "stretch_time", f"{name}_judged", f"{name}_holding"))
    return {"excited": excited_text(result, name),
            "stretches": [{"start": float(start), "time": float(time), "windows": int(judged), "holding": int(holding)}
                          for start, time, judged, holding in zip(*columns, strict=True)]}
