"""The verb ``cache``: compiled kernels that are kept for this user."""

from typing import Annotated

from cyclopts import Parameter

from skyverse.cli.option_types import FLAG, AsJson


def cache(
    *,
    clear: Annotated[bool, FLAG] = False,
    fill: Annotated[bool, Parameter(name="--compile"), FLAG] = False,
    as_json: AsJson = False,
) -> None:
    """Say where compiled kernels are kept and how large they are, remove them, or compile all.

    Kernels are compiled when they are first needed and kept in the user's cache folder, or in the folder that the
    environment variable SKYVERSE_CACHE names. Removing them is safe: they are compiled again.

    Examples: `skyverse cache`, `skyverse cache --clear`, `skyverse cache --compile`

    Parameters
    ----------
    clear
        Remove all of them.
    fill
        Compile all that any planner needs and that is not there yet, on all cores.
    as_json
        Print JSON.
    """
    from skyverse.cli.report import json_text
    from skyverse.cli.watch import compile_with_bar
    from skyverse.numerics.compiling.store import Contents, KernelStore, user_folder, why_nothing_is_kept

    folder = user_folder()
    store = KernelStore(folder) if folder else None
    contents = (store.clear() if clear else store.contents()) if store else Contents(0, 0)
    if fill:
        compile_with_bar(["all"])
        contents = store.contents() if store else contents
    refusal = why_nothing_is_kept()
    if as_json:
        row = {"folder": folder and str(folder), "files": contents.files, "bytes": contents.size_bytes}
        print(json_text(row | {"cleared": clear, "refusal": refusal}), end="")
        return
    if folder:
        print(f"{folder}: {contents.files} compiled kernels, {contents.size_bytes / 1e6:.1f} MB{', removed' * clear}")
    if refusal:
        print(f"not used: {refusal}; the environment variable SKYVERSE_CACHE can name another folder")
