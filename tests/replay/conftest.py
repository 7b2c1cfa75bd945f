"""Records that the tests of replay share."""


import pytest
from replay_records import start_up, write


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("records")


@pytest.fixture(scope="module")
def started(folder):
    return write(folder / "start.csv", start_up())
