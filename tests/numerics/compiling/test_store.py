"""The folder of compiled kernels: it belongs to the user alone, and nothing that is wrong with it is an error."""

import os
import threading
import time
from pathlib import Path

import pytest

from skyverse.cli import main
from skyverse.numerics.compiling.store import DAY_S, Contents, KernelStore, user_folder

POSIX = pytest.mark.skipif(os.name == "nt", reason="rights are POSIX ones")


@pytest.fixture
def store(tmp_path):
    return KernelStore(tmp_path / "a" / "kernels")


def test_what_is_kept_is_found_by_another_process(store):
    assert store.load("f-1") is None
    assert store.keep("f-1", b"code")
    assert KernelStore(store.folder).load("f-1") == store.load("f-1") == b"code"
    assert store.contents().files == 1
    assert store.clear().files == 1
    assert store.contents() == Contents(0, 0)
    assert store.load("f-1") is None


@pytest.mark.parametrize("damage", [b"", b"skyverse kernel 1\n", None])
def test_a_broken_file_is_not_found_and_is_removed(store, damage):
    store.keep("f-1", b"code" * 100)
    (path,) = store.folder.iterdir()
    path.write_bytes(path.read_bytes()[:-1] + b"!" if damage is None else damage)
    assert store.load("f-1") is None
    assert not path.exists()


@POSIX
def test_the_folder_is_made_for_the_user_alone(store):
    store.keep("f-1", b"code")
    assert store.folder.stat().st_mode & 0o777 == 0o700
    assert all(path.stat().st_mode & 0o077 == 0 for path in store.folder.iterdir())


@POSIX
@pytest.mark.parametrize("mode", [0o770, 0o701, 0o704])
def test_a_folder_that_is_open_to_others_is_not_used(store, mode):
    store.keep("f-1", b"code")
    store.folder.chmod(mode)
    other = KernelStore(store.folder)
    assert "chmod 700" in other.refusal
    assert other.load("f-1") is None
    assert not other.keep("f-2", b"code")


@POSIX
def test_a_folder_of_another_user_is_not_used(store, monkeypatch):
    store.keep("f-1", b"code")
    monkeypatch.setattr(os, "getuid", lambda: store.folder.stat().st_uid + 1)
    other = KernelStore(store.folder)
    assert "another user" in other.refusal
    assert other.load("f-1") is None
    assert not other.writable


def test_a_file_in_the_place_of_the_folder_is_no_error(tmp_path):
    (tmp_path / "kernels").write_text("")
    store = KernelStore(tmp_path / "kernels")
    assert store.load("f-1") is None
    assert not store.keep("f-1", b"code")
    assert not KernelStore(tmp_path / "kernels" / "below").keep("f-1", b"code")


def test_a_full_disk_is_no_error_and_leaves_nothing_behind(store, monkeypatch):
    store.keep("f-1", b"code")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    assert not store.keep("f-2", b"code")
    assert not store.writable
    assert store.contents().files == 1
    assert len(list(store.folder.iterdir())) == 1
    assert store.load("f-1") == b"code"


def test_what_is_not_used_for_long_is_removed(store):
    for name in ("old", "new"):
        store.keep(name, b"code")
    (folder_of_another,) = [store.folder.parent]
    (store.folder / "notes.txt").write_text("not ours")
    long_ago = time.time() - 100 * DAY_S
    for path in store.folder.glob("old*"):
        os.utime(path, (long_ago, long_ago))
    (store.folder / "left.tmp").write_bytes(b"")
    os.utime(store.folder / "left.tmp", (long_ago, long_ago))
    os.utime(store.folder / "notes.txt", (long_ago, long_ago))
    KernelStore(store.folder).keep("another", b"code")
    assert {path.name for path in store.folder.iterdir()} == {"new.kernel", "another.kernel", "notes.txt"}
    assert folder_of_another.exists()


def test_what_is_used_counts_as_new(store):
    store.keep("f-1", b"code")
    (path,) = store.folder.iterdir()
    os.utime(path, (time.time() - 50 * DAY_S,) * 2)
    store.load("f-1")
    assert time.time() - path.stat().st_mtime < DAY_S


def test_the_oldest_go_when_all_together_is_too_large(store, monkeypatch):
    import skyverse.numerics.compiling.store as module

    for age, name in enumerate(("new", "middle", "old")):
        store.keep(name, bytes(1000))
        os.utime(store.folder / f"{name}.kernel", (time.time() - age * 60.0,) * 2)
    monkeypatch.setattr(module, "MAX_TOTAL_BYTES", 2500)
    store.drop_old()
    assert {path.stem for path in store.folder.iterdir()} == {"new", "middle"}


def test_many_may_keep_and_load_at_once(store):
    found = []

    def work(i):
        mine = KernelStore(store.folder)
        for k in range(20):
            mine.keep(f"f-{k}", b"%d" % k * 1000)
            found.append(mine.load(f"f-{(k + i) % 20}"))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {body for body in found if body is not None} <= {b"%d" % k * 1000 for k in range(20)}
    assert store.contents().files == 20


def test_an_installed_folder_is_read_and_never_written_to(store):
    store.keep("f-1", b"code")
    installed = KernelStore(store.folder, read_only=True)
    assert installed.load("f-1") == b"code"
    assert not installed.keep("f-2", b"code")
    (path,) = store.folder.iterdir()
    path.write_bytes(b"broken")
    assert installed.load("f-1") is None
    assert path.exists()


def test_the_verb_tells_where_and_how_large_and_clears(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("SKYVERSE_CACHE", str(tmp_path))
    assert user_folder() == tmp_path / "kernels"
    KernelStore(user_folder()).keep("f-1", bytes(1_000_000))
    for words, expected in (
        ("cache", f"{tmp_path / 'kernels'}: 1 compiled kernels, 1.0 MB\n"),
        ("cache --clear", f"{tmp_path / 'kernels'}: 1 compiled kernels, 1.0 MB, removed\n"),
        ("cache", f"{tmp_path / 'kernels'}: 0 compiled kernels, 0.0 MB\n"),
    ):
        with pytest.raises(SystemExit):
            main(words.split())
        assert capsys.readouterr().out == expected


def test_a_user_without_a_home_has_no_folder(monkeypatch):
    import platformdirs

    def homeless(*_):
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("SKYVERSE_CACHE", raising=False)
    monkeypatch.setattr(platformdirs, "user_cache_path", homeless)
    assert user_folder() is None
