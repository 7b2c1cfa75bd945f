"""Files appear whole or not at all."""

import errno
import os
from pathlib import Path

import pytest

from imo_analysis.errors import InputError
from imo_analysis.files import folder, replacing, write_text


def test_a_file_is_left_as_it_was_when_writing_fails(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("before")
    with pytest.raises(KeyboardInterrupt), replacing(file) as beside:
        beside.write_text("half")
        raise KeyboardInterrupt
    assert file.read_text() == "before"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_full_disk_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    with pytest.raises(InputError, match="cannot write") as caught, replacing(file):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert "space" in str(caught.value)
    assert os.listdir(tmp_path) == []


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "f").write_text("")
    with pytest.raises(InputError, match="cannot make the folder"):
        folder(tmp_path / "f" / "g")
    with pytest.raises(InputError, match="cannot write"):
        write_text(tmp_path / "no" / "x.txt", "")
    write_text(tmp_path / "x.txt", "ä")
    assert (tmp_path / "x.txt").stat().st_mode & 0o044 == 0o044 & ~_umask()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
