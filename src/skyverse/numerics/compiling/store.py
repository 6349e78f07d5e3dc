"""Where machine code is kept: one file a kernel and signature, in a folder that belongs to the user alone."""

import contextlib
import hashlib
import os
import stat
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

HEADER = b"skyverse kernel 1\n"
SUFFIX = ".kernel"
DAY_S = 24 * 3600.0
MAX_UNUSED_S = 60 * DAY_S
MAX_TOTAL_BYTES = 1_000_000_000


class Contents(NamedTuple):
    """How much a store holds."""

    files: int
    size_bytes: int


class KernelStore:
    """Kept machine code, by name.

    Whatever goes wrong with the folder (it cannot be written to, the disk is full, a file is broken) means that
    nothing is found or kept, never an error. Several processes may use one folder at once: a file appears whole, and
    whoever keeps the same kernel again replaces it by the same code.

    Parameters
    ----------
    folder
        Where the files lie; it is made when the first kernel is kept.
    read_only
        Whether the folder was installed with the package: nothing is added to it or removed from it.
    """

    def __init__(self, folder: Path, *, read_only: bool = False) -> None:
        self.folder = folder
        self._read_only = read_only
        self._trusted: bool | None = None
        self._full = False

    @property
    def refusal(self) -> str:
        """Why the folder is not used; nothing if it is, or would be once it exists."""
        try:
            status = self.folder.stat()
        except FileNotFoundError:
            return ""
        except OSError as error:
            return f"{self.folder} cannot be read ({error.strerror})"
        if not stat.S_ISDIR(status.st_mode):
            return f"{self.folder} is not a folder"
        if os.name == "nt" or self._read_only:
            return ""
        if status.st_uid != os.getuid():
            return f"{self.folder} belongs to another user"
        if status.st_mode & 0o077:
            return f"{self.folder} is open to other users; delete it, or take their rights away: chmod 700"
        return ""

    @property
    def writable(self) -> bool:
        """Whether machine code can be kept; the folder is made if there is none."""
        if self._read_only or self._full:
            return False
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError:
            return False
        return not self.refusal and os.access(self.folder, os.W_OK)

    def holds(self, name: str) -> bool:
        """Tell whether something was kept under a name."""
        return self._is_trusted() and self._path(name).exists()

    def load(self, name: str) -> bytes | None:
        """Return what was kept under a name, None if there is nothing or the file is broken."""
        if not self._is_trusted():
            return None
        path = self._path(name)
        try:
            data = path.read_bytes()
        except OSError:
            return None
        body = data[len(HEADER) + 32 :]
        if data[: len(HEADER) + 32] != HEADER + hashlib.sha256(body).digest():
            self.drop(name)
            return None
        if not self._read_only:
            with contextlib.suppress(OSError):
                if time.time() - path.stat().st_mtime > DAY_S:
                    os.utime(path)  # the time of the last use, to the day
        return body

    def keep(self, name: str, body: bytes) -> bool:
        """Keep machine code under a name, if that is possible, and say whether it was."""
        if not self.writable:
            return False
        temporary = None
        try:
            with tempfile.NamedTemporaryFile(dir=self.folder, suffix=".tmp", delete=False) as file:
                temporary = Path(file.name)
                file.write(HEADER + hashlib.sha256(body).digest() + body)
            temporary.replace(self._path(name))
        except OSError:
            self._full = True  # asked no more in this process
            if temporary is not None:
                with contextlib.suppress(OSError):
                    temporary.unlink()
            return False
        if self._trusted is not True:  # the first one that this process keeps
            self._trusted = True
            self.drop_old()
        return True

    def drop(self, name: str) -> None:
        """Remove what was kept under a name."""
        if not self._read_only:
            with contextlib.suppress(OSError):
                self._path(name).unlink()

    def drop_old(self) -> None:
        """Remove what was not used for 60 days, and what was used longest ago where all together is above 1 GB."""
        total, now = 0, time.time()
        for age, size, path in sorted((now - status.st_mtime, status.st_size, path) for path, status in self._files()):
            total += size
            left_behind = path.suffix != SUFFIX and age > DAY_S  # by a process that was killed while it wrote
            if age > MAX_UNUSED_S or total > MAX_TOTAL_BYTES or left_behind:
                with contextlib.suppress(OSError):
                    path.unlink()

    def clear(self) -> Contents:
        """Remove everything that was kept, and return how much that was."""
        contents = self.contents()
        for path, _ in self._files():
            with contextlib.suppress(OSError):
                path.unlink()
        return contents

    def contents(self) -> Contents:
        """Return how many files are kept, and how large they are together."""
        sizes = [status.st_size for path, status in self._files() if path.suffix == SUFFIX]
        return Contents(len(sizes), sum(sizes))

    def _path(self, name: str) -> Path:
        return self.folder / f"{name}{SUFFIX}"

    def _is_trusted(self) -> bool:
        if self._trusted is None and self.folder.exists():
            self._trusted = not self.refusal
        return bool(self._trusted)

    def _files(self) -> Iterator[tuple[Path, os.stat_result]]:
        try:
            paths = [path for path in self.folder.iterdir() if path.suffix in (SUFFIX, ".tmp")]
        except OSError:
            return
        for path in paths:
            with contextlib.suppress(OSError):  # another process may have removed it
                yield path, path.stat()


def why_nothing_is_kept() -> str:
    """Return why machine code cannot be kept for this user; nothing where it can."""
    folder = user_folder()
    if folder is None:
        return "this user has no home folder"
    store = KernelStore(folder)
    return store.refusal or ("" if store.writable else f"{folder} cannot be made or written to")


def user_folder() -> Path | None:
    """Return the folder for this user's machine code: in SKYVERSE_CACHE if that is set; None without a home."""
    import platformdirs

    asked = os.environ.get("SKYVERSE_CACHE")
    try:
        return (Path(asked).expanduser() if asked else platformdirs.user_cache_path("skyverse", False)) / "kernels"
    except RuntimeError:
        return None
