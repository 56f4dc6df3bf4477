"""YADE takes a second to start: one process is started, and a copy of it runs each script."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

#: Runs each script that it reads the path of in a copy of the process; says how it ended.
_SERVER = """\
import os, sys, traceback

temporary = os.path.dirname(O.tmpFilename())
for line in iter(sys.stdin.readline, ""):
    os.makedirs(temporary, exist_ok=True)
    child = os.fork()
    if child == 0:
        code = 0
        try:
            folder, script = os.path.split(line.rstrip())
            os.chdir(folder)
            exec(compile(open(script).read(), script, "exec"), globals())
        except SystemExit as end:
            code = end.code
        except BaseException:
            traceback.print_exc()
            code = 1
        os._exit(code)
    print("ended", os.waitpid(child, 0)[1], flush=True)
"""


@contextmanager
def started_yade(folder: Path) -> Iterator[Callable[[Path], None]]:
    """Start YADE in an empty folder; yield what runs a script in the script's own folder."""
    (folder / "server.py").write_text(_SERVER)
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    command = ["yade", "-n", "-x", "-j1", "server.py"]
    with subprocess.Popen(command, cwd=folder, text=True, **pipes) as process:

        def run(script: Path) -> None:
            process.stdin.write(f"{script}\n")
            process.stdin.flush()
            lines = iter(process.stdout.readline, "")
            assert next(line for line in lines if line.startswith("ended")) == "ended 0\n"

        yield run
        process.stdin.close()
