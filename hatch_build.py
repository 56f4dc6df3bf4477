"""The description on the Python package index: the README with links that work there.

Links of the README are relative, as the web site of the repository needs them. With the address of
the repository in pyproject.toml they become absolute; without one, links to files become plain text
and pictures are left out, so that no link is dead.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_PICTURE = re.compile(r"(!)\[([^\[\]]*)\]\(([^)\s]+)\)")
_LINK = re.compile(r"((?<!!))\[((?:[^\[\]]|!\[[^\]]*\])*)\]\(([^)\s]+)\)")
_MARK = re.compile(r"<!--.*?-->\n?", re.DOTALL)


class Description(MetadataHookInterface):
    """Set the description, and the links of the project where it has an address."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add to the metadata of the project."""
        address = self.config.get("address", "").rstrip("/")
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        described = description(text, address)
        metadata["readme"] = {"content-type": "text/markdown", "text": described}
        if address:
            metadata["urls"] = {
                "Source": address,
                "Documentation": f"{address}/blob/main/docs/index.md",
                "Changelog": f"{address}/blob/main/CHANGELOG.md",
                "Issues": f"{address}/issues",
            }


def description(readme: str, address: str) -> str:
    """Return the README with links that work outside of the repository.

    Parameters
    ----------
    readme : str
        Its text, in Markdown.
    address : str
        Web address of the repository; "" where it has none.
    """

    def absolute(link: re.Match[str]) -> str:
        picture, text, target = link.groups()
        if ":" in target or target.startswith("#"):
            return link[0]
        if not address:
            return "" if picture else text
        return f"{picture}[{text}]({address}/{'raw' if picture else 'blob'}/main/{target})"

    # Code is left alone: a pair of brackets before parentheses may be Python there.
    parts = re.split(r"(```.*?```)", _MARK.sub("", readme), flags=re.DOTALL)
    parts[::2] = [_LINK.sub(absolute, _PICTURE.sub(absolute, part)) for part in parts[::2]]
    return "".join(parts)
