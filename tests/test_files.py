"""Files are written whole or not at all, and read with one clear refusal."""

import errno
import os
import resource
import stat
from pathlib import Path

import pytest

from skinviz._files import existing_file, whole_file, whole_files
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

    message = r"cannot write .*a\.txt: it is a folder; give the name of a file"
    with pytest.raises(SkinvizError, match=message):
        write()
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").is_dir()


def test_a_full_disk_is_told_with_what_to_do(tmp_path):
    """The system's own limit of a file's size stands for the end of the disk."""
    target = tmp_path / "a.txt"
    target.write_text("old")

    def write():
        with whole_file(target) as partial:
            partial.write_bytes(bytes(20_000))

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(SkinvizError, match=r"File too large; write to a disk"):
            write()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert target.read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


@pytest.mark.parametrize(
    ("number", "advice"),
    [
        (errno.ENOSPC, "free some space there or write to another disk"),
        (errno.EDQUOT, "free some space there"),
        (errno.EACCES, "write to a folder that you may write to"),
        (errno.EROFS, "write to a folder that you may write to"),
        (errno.EIO, "check the folder and its free space"),
        (None, "check the folder and its free space"),
    ],
)
def test_every_error_of_the_disk_says_what_to_do(tmp_path, number, advice):
    error = OSError("4 requested and 2 written")
    if number is not None:
        error = OSError(number, os.strerror(number))

    def write():
        with whole_file(tmp_path / "a.txt"):
            raise error

    with pytest.raises(SkinvizError) as told:
        write()
    what = error.strerror or "4 requested and 2 written"
    assert str(told.value).startswith(f"cannot write {tmp_path / 'a.txt'}: {what}; ")
    assert advice in str(told.value)


def test_a_name_too_long_for_the_disk_is_told(tmp_path):
    target = tmp_path / ("a" * 300)
    with pytest.raises(SkinvizError, match="cannot write"), whole_file(target):
        pytest.fail("the block must not be entered")
    assert names(tmp_path) == []


# --- files that belong together ------------------------------------------------


def pair(folder):
    return folder / "a.bip", folder / "a.hdr"


def contents(folder):
    return {entry.name: entry.read_text() for entry in folder.iterdir()}


OLD = {"a.bip": "old bip", "a.hdr": "old hdr"}


@pytest.fixture(params=[{}, OLD, {"a.bip": "old bip"}, {"a.hdr": "old hdr"}])
def before(request, tmp_path):
    """Return what is in the folder before two files are written there."""
    for name, text in request.param.items():
        (tmp_path / name).write_text(text)
    return request.param


def write_new(folder, fail=len):
    with whole_files(*pair(folder)) as partials:
        for partial in partials:
            partial.write_text(f"new {partial.suffix[1:]}")
        assert not any(path.name in ("a.bip", "a.hdr") for path in partials)
        fail(partials)


def test_a_pair_takes_its_names_together(tmp_path, before):
    write_new(tmp_path)
    assert contents(tmp_path) == {"a.bip": "new bip", "a.hdr": "new hdr"}


def test_an_error_between_two_files_leaves_both_as_they_were(tmp_path, before):
    def fail(partials):
        raise OSError(errno.ENOSPC, "No space left on device")

    message = r"cannot write .*a\.bip and .*a\.hdr: No space left on device; free"
    with pytest.raises(SkinvizError, match=message):
        write_new(tmp_path, fail)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("which", [0, 1])
def test_where_one_cannot_have_its_name_the_other_is_put_back(tmp_path, before, which):
    with pytest.raises(SkinvizError, match="cannot write"):
        write_new(tmp_path, lambda partials: partials[which].unlink())
    assert contents(tmp_path) == before


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
@pytest.mark.parametrize("which", ["a.bip", "a.hdr"])
def test_an_error_while_the_names_are_taken_undoes_them(
    tmp_path, before, monkeypatch, error, which
):
    replace = Path.replace

    def fails_once(self, target):
        if target.name == which:
            monkeypatch.setattr(Path, "replace", replace)
            raise error
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", fails_once)
    with pytest.raises(SkinvizError if error is OSError else error):
        write_new(tmp_path)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("which", ["a.bip", "a.hdr"])
def test_a_folder_of_one_name_is_told_before_the_work(tmp_path, which):
    (tmp_path / which).mkdir()
    with (
        pytest.raises(SkinvizError, match="it is a folder"),
        whole_files(*pair(tmp_path)),
    ):
        pytest.fail("the block must not be entered")
    assert names(tmp_path) == [which]


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


def test_an_error_of_many_files_names_the_first_two(tmp_path):
    paths = [tmp_path / "none" / name for name in "abcde"]
    (tmp_path / "none").write_text("x", "utf-8")
    with (
        pytest.raises(
            SkinvizError, match=r"none/a and .*none/b and 3 more: File exists"
        ),
        whole_files(*paths),
    ):
        pass
