"""What to do where there is no browser."""

import os

import pytest


def missing(what: str) -> None:
    """A user may lack a browser; CI may not."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what} is missing; CI installs it")
    pytest.skip(f"{what} is not installed")
