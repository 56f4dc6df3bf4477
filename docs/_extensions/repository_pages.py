"""Bring files of the repository that lie outside of docs/ into the site.

The changelog, the contributing guide and the examples become pages below ``generated/``. Links to
them in the pages of docs/ are relative paths, as the web site of the repository needs them, and are
turned into links to these pages; a link to any other file outside of docs/ becomes plain text.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from sphinx.util import logging

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
GENERATED = "generated"
#: Pages of the repository that the site has as they are.
COPIED = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
_LANGUAGES = {".toml": "toml", ".py": "python", ".csv": "text", ".drop": "text", ".j2": "text"}
_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
_logger = logging.getLogger(__name__)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("source-read", rewrite_links)
    return {"parallel_read_safe": True}


def write_pages(app: Sphinx) -> None:
    """Write the pages below ``generated/``; one that has not changed keeps its time."""
    folder = Path(app.srcdir) / GENERATED
    folder.mkdir(exist_ok=True)
    for source, name in COPIED.items():
        text = (ROOT / source).read_text(encoding="utf-8").replace("](docs/", "](../")
        for other, page in COPIED.items():
            text = text.replace(f"]({other}", f"]({page}")
        _write(folder / name, text)
    _write(folder / "examples.md", examples_page())


def _write(path: Path, text: str) -> None:
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def examples_page() -> str:
    """Return a page with all files of ``examples/``."""
    parts = [
        "# Examples",
        "Complete files, as they are in the folder `examples` of the repository; "
        "`grainfit run` calibrates each.",
    ]
    for example in sorted(path for path in (ROOT / "examples").iterdir() if path.is_dir()):
        parts.append(f"## {example.name}")
        for path in sorted(example.rglob("*")):
            if path.is_file() and path.suffix in _LANGUAGES:
                code = path.read_text(encoding="utf-8").rstrip()
                parts.append(f"`{path.relative_to(ROOT).as_posix()}`")
                parts.append(f"````{_LANGUAGES[path.suffix]}\n{code}\n````")
    return "\n\n".join(parts) + "\n"


def rewrite_links(app: Sphinx, name: str, source: list[str]) -> None:
    """Point links that lead out of docs/ to the generated pages."""
    if not name.startswith(f"{GENERATED}/"):
        source[0] = _LINK.sub(lambda link: _rewritten(link, name), source[0])


def _rewritten(link: re.Match[str], name: str) -> str:
    image, text, target = link.groups()
    if ":" in target or target.startswith(("#", "/")) or image:
        return link[0]
    path, _, anchor = target.partition("#")
    inside = _normalised(PurePosixPath("docs", name).parent / path)
    if inside.parts[0] == "docs":
        return link[0]
    if not (ROOT / inside).exists():
        _logger.warning("%s: no such file in the repository: %s", name, target)
        return link[0]
    if str(inside) in COPIED:
        page, anchor = COPIED[str(inside)], f"#{anchor}" if anchor else ""
    elif inside.parts[0] == "examples":
        page, anchor = "examples.md", f"#{inside.parts[1]}" if len(inside.parts) > 1 else ""
    else:
        return text
    return f"[{text}](/{GENERATED}/{page}{anchor})"


def _normalised(path: PurePosixPath) -> PurePosixPath:
    parts: list[str] = []
    for part in path.parts:
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return PurePosixPath(*parts)
