"""Addresses of run stores: read them, and show them without passwords."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from urllib.parse import quote, quote_plus, unquote

import sqlalchemy as sql
from sqlalchemy.exc import ArgumentError, NoSuchModuleError

from grainfit.campaign import messages
from grainfit.errors import StoreError

_HIDDEN = "***"
_SCHEME = re.compile(r"[A-Za-z][\w+.-]*(?=://)")
#: Parts of an address that are shown: a password that was not quoted may have ended up in them.
_NAME = re.compile(r"[\w.~ +-]+|\*\*\*")
_HOST = re.compile(r"[\w.:/,~%-]+|\*\*\*")
_SHOWN_OPTIONS = ("host", "port", "service", "sslmode")
#: Texts that were meant as the address of a server, although they are none.
_MEANT = re.compile(
    r"[A-Za-z][\w+.-]+:/|(?![A-Za-z]:[/\\])[^/]*:.*@|.*\bpass\w*\s*=", re.IGNORECASE | re.DOTALL
)
_FORMS = "postgresql+psycopg://user@host/database or sqlite:////path/to/runs.sqlite"


@dataclass(frozen=True)
class StoreAddress:
    """Address of a run store, and its form for readers.

    Parameters
    ----------
    url : sqlalchemy.URL
        The address, password included.
    shown : str
        Location for messages, records and tables, without anything that may be secret.
    hidden : tuple of str
        Parts of the address that are not in `shown`.
    """

    url: sql.URL
    shown: str
    hidden: tuple[str, ...]

    @classmethod
    def read(cls, address: str | sql.URL) -> StoreAddress:
        """Read an address.

        Raises
        ------
        StoreError
            It is not the address of a database.
        """
        try:
            url = sql.make_url(address)
            url.get_dialect()
        except (ArgumentError, NoSuchModuleError, ValueError):
            # The cause would quote parts of the address.
            shown, remedy = safe_address(address), _advice(address)
            raise StoreError(messages.NO_ADDRESS(address=shown, remedy=remedy)) from None
        shown = _location(url, address if isinstance(address, str) else "")
        return cls(url, shown, tuple(_hidden_parts(url, shown)))

    def without_secrets(self, text: str) -> str:
        """Return a text, such as a driver's message, without the hidden parts of the address."""
        for part in sorted(self.hidden, key=len, reverse=True):
            text = _word(part).sub(_HIDDEN, text)
        return text


def safe_address(address: object) -> str:
    """Return the address of a store, or the path of a work folder, without a password.

    Only parts that cannot hold a password are shown. Of an address that cannot be read, that is
    the name of the database system alone. A path is returned as it is.

    Examples
    --------
    >>> safe_address("postgresql://user:secret@host/runs?password=secret&sslmode=require")
    'postgresql://user:***@host/runs?sslmode=require'
    >>> safe_address("postgresql://user:secret@host:port/runs")
    'postgresql://***'
    >>> safe_address("beads.grainfit")
    'beads.grainfit'
    """
    if isinstance(address, sql.URL):
        return _location(address, "")
    text = str(address)
    if "://" not in text:
        return _HIDDEN if _MEANT.match(text) else text
    try:
        url = sql.make_url(text)
        url.get_dialect()
        return _location(url, text)
    except (ArgumentError, NoSuchModuleError, ValueError):
        scheme = _SCHEME.match(text)
        return f"{scheme[0] if scheme else _HIDDEN}://{_HIDDEN}"


def _location(url: sql.URL, text: str) -> str:
    """Return the location of a database that was read from a text, if it was a text."""
    if url.drivername.split("+")[0] == "sqlite":
        if (url.host, url.username, url.password) != (None, None, None):
            return f"{url.drivername}://{_HIDDEN}"
        place = str(url.database or "sqlite://")
        return unquote(place.removeprefix("file://")) if place.startswith("file://") else place
    # Of a password with an unquoted @, parts are taken for the host, the database or options.
    if text.count("@") > 1 or "@" in f"{url.host}{url.database}":
        return f"{url.drivername}://{_HIDDEN}"
    parts = [url.drivername, "://"]
    if url.username is not None or url.password is not None:
        parts += [_part(url.username, _NAME), f":{_HIDDEN}" if url.password else "", "@"]
    host = _part(url.host, _HOST)
    parts += [f"[{host}]" if ":" in host else host, f":{url.port}" if url.port else ""]
    parts += ["" if url.database is None else f"/{_part(url.database, _NAME)}"]
    options = "&".join(f"{name}={value}" for name, value in _shown_options(url))
    return "".join([*parts, f"?{options}" if options else ""])


def _part(text: str | None, form: re.Pattern[str]) -> str:
    return "" if not text else text if form.fullmatch(text) else _HIDDEN


def _shown_options(url: sql.URL) -> Iterator[tuple[str, str]]:
    for name, values in sorted(url.normalized_query.items()):
        if name in _SHOWN_OPTIONS:
            yield from ((name, _part(value, _HOST)) for value in values)


def _hidden_parts(url: sql.URL, shown: str) -> Iterator[str]:
    texts = {url.username, url.password, url.host, url.database}
    texts |= {value for values in url.normalized_query.values() for value in values}
    for text in filter(None, texts):
        if not _word(text).search(shown):
            yield from {text, quote(text), quote(text, safe=""), quote_plus(text)}


def _word(text: str) -> re.Pattern[str]:
    return re.compile(rf"(?<!\w){re.escape(text)}(?!\w)")


def _advice(address: str | sql.URL) -> str:
    text = str(address)
    if text.startswith("postgres://"):
        return (
            f"Its beginning is postgresql+psycopg://, not postgres://. Give one such as {_FORMS}."
        )
    if _SCHEME.match(text):
        return (
            f"Give one such as {_FORMS}; a port is a number, an IPv6 host stands in [ ], and "
            "special characters of a password are written as %XX."
        )
    return f"Give one such as {_FORMS}."
