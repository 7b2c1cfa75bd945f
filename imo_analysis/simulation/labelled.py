"""Labelled data before it is an `xarray.Dataset`: importing xarray takes longer than running a minute of motor time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

# dimensions, values, attributes
Variable = tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]


@dataclass(frozen=True)
class Labelled:
    """Variables and coordinates by name, as ``(dimensions, values, attributes)``, and the attributes of the whole."""

    variables: dict[str, Variable]
    coordinates: dict[str, Variable]
    attrs: dict[str, Any]

    @classmethod
    def of(cls, data: Labelled | xr.Dataset) -> Labelled:
        """The same from a data set; what is labelled already is returned as it is."""
        if isinstance(data, Labelled):
            return data
        variables, coordinates = (
            {str(name): (tuple(map(str, one.dims)), one.values, dict(one.attrs)) for name, one in part.items()}
            for part in (data.data_vars, data.coords)
        )
        return cls(variables, coordinates, {str(name): value for name, value in data.attrs.items()})

    def dataset(self) -> xr.Dataset:
        """The same as a data set."""
        import xarray as xr

        return xr.Dataset(self.variables, self.coordinates, self.attrs)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The values of a variable or coordinate."""
        return (self.variables.get(name) or self.coordinates[name])[1]
