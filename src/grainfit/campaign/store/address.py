"""Addresses of run stores: read them, and show them without passwords."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote, quote_plus

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
#: What grainfit is tested with, by the beginning of an address.
_DRIVERS = {
    "postgresql": "postgresql+psycopg",
    "postgresql+psycopg": "postgresql+psycopg",
    "sqlite": "sqlite",
    "sqlite+pysqlite": "sqlite",
}


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
        """Read an address: a text is that of a user, and a URL is used as it is.

        Raises
        ------
        StoreError
            It is not the address of a store that several processes can have.
        """
        if isinstance(address, sql.URL):
            url, shown = address, _location(address, "")
            return cls(url, shown, tuple(_hidden_parts(url, shown)))
        try:
            url = sql.make_url(address)
            remedy = _fault_of(url, address)
        except (ArgumentError, ValueError):
            # The cause would quote parts of the address.
            remedy = _fault_of_unreadable(address)
        if remedy:
            text = messages.NO_ADDRESS(address=safe_address(address), remedy=remedy)
            raise StoreError(text) from None
        shown = _location(url, address)
        known = url.set(drivername=_DRIVERS[url.drivername])
        return cls(known, shown, tuple(_hidden_parts(url, shown)))

    @property
    def file(self) -> Path | None:
        """File of a SQLite database; None of a server's, and of one in memory."""
        is_file = self.url.drivername == "sqlite" and self.url.database
        return Path(str(self.url.database)) if is_file else None

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
        return str(url.database or "sqlite://")
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


def _fault_of(url: sql.URL, address: str) -> str:
    """Return what is wrong with the address of a user, in words of what to do; "" if nothing."""
    if url.drivername not in _DRIVERS:
        return _other_beginning(url.drivername)
    if _DRIVERS[url.drivername] != "sqlite":
        return ""
    # Without a = it would be dropped in silence.
    if "?" in address:
        return messages.NO_SQLITE_OPTIONS()
    is_path = url.database not in (None, "", ":memory:")
    is_alone = (url.host, url.username, url.password) == (None, None, None)
    return "" if is_path and is_alone else messages.NO_SQLITE_PATH()


def _fault_of_unreadable(address: str) -> str:
    scheme = _SCHEME.match(address)
    if scheme is None:
        return messages.GIVE_AN_ADDRESS()
    return messages.PARTS_OF_ADDRESS() if scheme[0] in _DRIVERS else _other_beginning(scheme[0])


def _other_beginning(given: str) -> str:
    for system, right in (("postgres", "postgresql+psycopg"), ("sqlite", "sqlite")):
        if given.startswith(system):
            return messages.OTHER_BEGINNING(given=given, right=right)
    return messages.OTHER_SYSTEM()
