"""Names of files in every field of every file that a service is sent: it opens none but those sent."""

import os
import sys
from pathlib import Path
from random import Random

from fault_tools import Bench, Finding
from study_tools import ROOT

KEY = "a-key-that-nobody-is-told"
# Values drawn for a field that takes no text; one that does gets all.
DRAWN = 2


def named_files(_: Bench, draw: Random, place: Path) -> Finding:
    """Name planted files, the service's own and the system's, by all kinds of paths, in every field."""
    sys.path.append(str(ROOT / "tests"))
    from file_fields import fields, plant, tells, text_with, upwards
    from satellites.service.serving import Served

    finding, folder = Finding(), place.with_suffix("")
    folder.mkdir()
    (folder / "key").write_text(KEY)
    planted = plant(folder / "planted")
    os.mkfifo(folder / "pipe")  # a check that opens it waits, and is ended
    (folder / "link.csv").symlink_to(planted[0])
    service = Served(folder, "--key-file", str(folder / "key"))
    jobs = folder / "service"
    files = [*planted, folder / "key", folder / "pipe", folder / "link.csv", jobs / "jobs.sqlite"]
    files += map(Path, ("/proc/self/environ", "/etc/passwd", "/dev/zero", "/dev/stdin"))
    paths = [way(file) for file in files for way in (str, upwards, lambda file: f"file://{file}")]
    paths += [
        "../jobs.sqlite",
        "jobs.sqlite",
        ".",
        "..",
        "",
        "/",
        "~/.bashrc",
        "a\0.csv",
        "mine.toml",
    ]
    paths += ["x" * 5000, "x/" * 2000, "..\\..\\key", "C:\\key", "\\\\host\\key", "//etc/passwd"]
    paths += ["..%2f..%2fetc%2fpasswd", "\uff0e\uff0e\uff0fkey", "MINE.TOML", "mine.toml/../key"]
    own = ("root:", "PYTHONPATH", KEY, f"{service.folder}/service", str(ROOT))
    for kind, path, takes_text, names_file in fields():
        for value in paths if takes_text else draw.sample(paths, DRAWN):
            question = {"text": text_with(kind, path, value), "name": "mine.toml"}
            routes = ["files/check", *(["engines", "studies"] if names_file else [])]
            for route in routes:
                try:
                    status, _, body = service.ask(
                        f"/api/{route}", question, Authorization=f"Bearer {KEY}"
                    )
                except TimeoutError:
                    finding.hangs += 1
                    continue
                finding.inputs += 1
                answer = body.decode().replace(value, "")  # the name as sent is quoted
                told = tells(answer, *own)
                finding.lost += bool(told)
                finding.hangs += "cannot be checked" in answer
                finding.tracebacks += status >= 500
                if told or status >= 500 or "cannot be checked" in answer:
                    finding.says(
                        f"{route} {'.'.join(path)} = {value[:60]!r}: {told} {answer[:200]}"
                    )
    service.end()
    finding.tracebacks += "Traceback" in service.log.read_text()
    return finding
