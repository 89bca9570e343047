"""Files are written whole or not at all, and read with one clear refusal."""

import os
import stat

import pytest

from skinviz._files import existing_file, whole_file
from skinviz.errors import DataError, MeshError, SkinvizError


class BrokenError(Exception):
    """What a library may raise in the middle of writing."""


def names(folder):
    return sorted(entry.name for entry in folder.iterdir())


def test_a_whole_file_takes_its_name_at_the_end(tmp_path):
    target = tmp_path / "a.txt"
    with whole_file(target) as partial:
        partial.write_text("new")
        assert not target.exists()
        assert partial.parent == tmp_path
    assert target.read_text() == "new"
    assert names(tmp_path) == ["a.txt"]


def test_the_old_file_stays_until_the_new_one_is_whole(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with whole_file(str(target)) as partial:
        partial.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"


@pytest.mark.parametrize("error", [BrokenError, ValueError, KeyboardInterrupt])
@pytest.mark.parametrize("existed", [True, False])
def test_an_error_in_the_block_leaves_everything_as_it_was(tmp_path, error, existed):
    target = tmp_path / "a.txt"
    if existed:
        target.write_text("old")

    def write():
        with whole_file(target) as partial:
            partial.write_text("half")
            raise error

    with pytest.raises(error):
        write()
    assert names(tmp_path) == (["a.txt"] if existed else [])
    assert not existed or target.read_text() == "old"


def test_an_error_of_the_disk_is_told_with_the_files_name(tmp_path):
    def write():
        with whole_file(tmp_path / "a.txt") as partial:
            partial.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(SkinvizError, match=r"cannot write .*a\.txt.*No space left"):
        write()
    assert names(tmp_path) == []


def test_a_library_that_has_removed_the_partial_file_is_told(tmp_path):
    def write():
        with whole_file(tmp_path / "a.txt") as partial:
            partial.unlink()

    with pytest.raises(SkinvizError, match="cannot write"):
        write()
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    "name", ["a.png", "a.tar.gz", "noSuffix", "ünï cødé.ply", "a" * 150]
)
def test_the_suffix_is_kept_and_the_name_is_new(tmp_path, name):
    target = tmp_path / name
    with whole_file(target) as partial:
        assert partial.suffix == target.suffix
        assert partial.name != target.name
        partial.write_bytes(b"x")
    assert names(tmp_path) == [name]


def test_folders_on_the_way_are_made(tmp_path):
    with whole_file(tmp_path / "new" / "newer" / "a.txt") as partial:
        partial.write_text("x")
    assert names(tmp_path / "new" / "newer") == ["a.txt"]


def test_two_writers_of_one_file_do_not_meet(tmp_path):
    target = tmp_path / "a.txt"
    with whole_file(target) as first, whole_file(target) as second:
        assert first != second
        first.write_text("first")
        second.write_text("second")
    assert target.read_text() == "first"  # its block ended last
    assert names(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_the_file_has_the_mode_that_the_user_wants(tmp_path, mask):
    before = os.umask(mask)
    try:
        with whole_file(tmp_path / "a.txt") as partial:
            partial.write_text("x")
        assert os.umask(mask) == mask  # left as it was
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o666 & ~mask


def test_a_file_in_the_place_of_the_folder_is_told(tmp_path):
    (tmp_path / "file").write_text("x")
    target = tmp_path / "file" / "a.txt"
    with (
        pytest.raises(SkinvizError, match=r"cannot write .*a\.txt: "),
        whole_file(target),
    ):
        pytest.fail("the block must not be entered")
    assert (tmp_path / "file").read_text() == "x"


def test_a_folder_that_cannot_be_written_is_told():
    # Nobody, root included, can make files there.
    target = "/proc/skinviz/a.txt"
    message = r"cannot write /proc/skinviz/a\.txt: "
    with pytest.raises(SkinvizError, match=message), whole_file(target):
        pytest.fail("the block must not be entered")


def test_a_folder_of_the_files_name_is_told_and_left(tmp_path):
    (tmp_path / "a.txt").mkdir()

    def write():
        with whole_file(tmp_path / "a.txt") as partial:
            partial.write_text("x")

    with pytest.raises(SkinvizError, match=r"cannot write .*a\.txt"):
        write()
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").is_dir()


def test_a_name_too_long_for_the_disk_is_told(tmp_path):
    target = tmp_path / ("a" * 300)
    with pytest.raises(SkinvizError, match="cannot write"), whole_file(target):
        pytest.fail("the block must not be entered")
    assert names(tmp_path) == []


@pytest.mark.parametrize("error", [DataError, MeshError])
def test_existing_files_come_back_and_others_are_told(tmp_path, error):
    file = tmp_path / "a.txt"
    with pytest.raises(error, match=r"a\.txt: no such file; check the path"):
        existing_file(file, error)
    file.touch()
    with pytest.raises(error, match=r"a\.txt: the file is empty"):
        existing_file(file, error)
    with pytest.raises(error, match="is a folder, a file is expected"):
        existing_file(tmp_path, error)
    file.write_text("x")
    assert existing_file(str(file), error) == file


def test_a_link_to_nothing_is_no_file(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    with pytest.raises(DataError, match="link: no such file"):
        existing_file(tmp_path / "link", DataError)
