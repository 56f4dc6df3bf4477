"""Whether a process runs, from Linux itself."""

from pathlib import Path


def is_running(pid: int | str) -> bool:
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"
