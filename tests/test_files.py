"""Files appear whole or not at all."""

import errno
import os
from pathlib import Path

import pytest

from imo_analysis.errors import InputError
from imo_analysis.files import check_place, folder, replacing, write_text


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


def test_places_that_take_no_file(tmp_path: Path) -> None:
    (tmp_path / "there.txt").write_text("before")
    os.mkfifo(tmp_path / "pipe")
    for place in ("there.txt", "new.txt"):
        check_place(tmp_path / place)
    for place, why in ((tmp_path, "it is a folder"), (tmp_path / "no" / "x.txt", "there is no folder"),
                       (tmp_path / "there.txt" / "x", "there is no folder"), (tmp_path / "pipe", "not a file"),
                       (tmp_path / ("x" * 300), "name too long"), ("", "without a name")):
        with pytest.raises(InputError, match=f"(?i){why}") as caught:
            check_place(place)
        assert "\n" not in str(caught.value)
    assert sorted(os.listdir(tmp_path)) == ["pipe", "there.txt"] and (tmp_path / "there.txt").read_text() == "before"


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
