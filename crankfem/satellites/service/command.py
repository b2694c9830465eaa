"""The service of an API and a page."""

import os
import stat
import sys
from pathlib import Path
from typing import Annotated

import typer

from crankbase.errors import InputError, MissingLibraryError
from crankbase.input_file import not_a_file
from crankfem.cli.commands.options import Output, WorkersOption, with_output
from crankfem.cli.console import print_json, print_note


@with_output()
def serve(
    folder: Annotated[
        Path, typer.Option(metavar="FOLDER", help="Folder for jobs and their files.")
    ] = Path("crankfem-service"),
    models: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder of compliance models for look-ups."),
    ] = None,
    port: Annotated[int, typer.Option(help="Port; 0 for any free one.")] = 8765,
    host: Annotated[
        str, typer.Option(help="Address to listen at; any but this machine's own needs a key.")
    ] = "127.0.0.1",
    key_file: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File with the key that requests must carry."),
    ] = None,
    jobs: Annotated[int, typer.Option(help="Number of jobs that run at a time.")] = 1,
    workers: WorkersOption = 2,
    *,
    out: Output,
) -> None:
    """Serve an API and a page where sliders change a throw's dimensions.

    Only this machine is served, unless --host and --key-file are given.
    """
    from crankbase.choices import is_whole_within
    from crankfem.cli.interrupts import interrupts_raise
    from regression.runs.study import check_workers

    try:
        from crankfem.satellites.service.app import serve as serve_until_interrupted
        from crankfem.satellites.service.guard import Bounds, Settings
    except ModuleNotFoundError as error:
        raise MissingLibraryError(
            f"The service needs the package {error.name}; install it with: pip install 'crankfem[serve]'."
        ) from None
    check_workers(workers)
    if not is_whole_within(jobs, 1, 64):
        raise InputError(f"--jobs: given {jobs}; allowed is 1 to 64.")
    settings = Settings(
        folder, models, host, port, _read_key(key_file), Bounds(running=jobs, workers=workers)
    )

    def show_address(address: str) -> None:
        if out.json:
            print_json({"address": address, "folder": str(settings.folder), "who": settings.who})
            sys.stdout.flush()  # who reads it waits for no end
        elif not out.quiet:
            # On standard error, as the log: nothing here is a result.
            print_note(f"crankfem serves at {address} ({settings.who}).")
            print_note(
                f"Jobs are in {settings.folder}. Stop with Ctrl-C; running jobs continue at the next start."
            )

    with interrupts_raise():
        serve_until_interrupted(settings, show_address)


def _read_key(file: Path | None) -> str | None:
    if file is None:
        return None
    try:
        if (entry := not_a_file(file)) is not None:
            raise InputError(f"--key-file: given {file}, which {entry}.")
        if os.name == "posix" and file.stat().st_mode & (stat.S_IRWXG | stat.S_IRWXO):
            raise InputError(
                f"--key-file: given {file}, which others than its owner can use; allowed is one of its "
                f"owner's alone (chmod 600 {file}), because whoever reads the key can use the service."
            )
        return file.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"--key-file: given {file}, which cannot be read as ASCII ({error})."
        ) from None
