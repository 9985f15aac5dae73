"""Texts that are damaged rather than wrong, and constructs of YAML that could do harm."""

from __future__ import annotations

import random
from collections.abc import Iterator

from tests.refusals.case import BASES, Case, base, beside, dump

_LAUGHS = [
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 9)}]" for k in range(13)
]
_BOMB = f"{{a: &a [x, x, x, x, x, x, x, x, x], {', '.join(_LAUGHS)}}}"
# What may stand for a value in flow style.
RAW = {
    "alias bomb": _BOMB,
    "alias of itself": "&self [*self]",
    "alias in a key": "&self {? *self : 1}",
    "unknown alias": "*nobody",
    "deep list": "[" * 1000 + "]" * 1000,
    "deep mapping": "{a: " * 500 + "1" + "}" * 500,
    "deep beyond recursion": "[" * 200_000,
    "python object": "!!python/object/apply:os.system ['touch pwned']",
    "python name": "!!python/name:os.system ''",
    "own tag": "!evil x",
    "binary": "!!binary aGVsbG8=",
    "set": "!!set {a, b}",
    "wrong tag": "!!int x",
    "mapping as key": "{{a: b}: c}",
    "list as key": "{[a]: c}",
    "number as key": "{1: c}",
    "long key": "{" + "k" * 5000 + ": 1}",
    "long number": "9" * 100_000,
    "long exponent": "1e" + "9" * 300,
    "base 16": "0x" + "f" * 390,
    "merge of no mapping": "{<<: 3}",
    "twice": "{x: 1, x: 2}",
    "bad escape": '"\\q"',
    "open quote": "'open",
    "reserved": "@x",
}


def _raw() -> Iterator[Case]:
    """Every construct in several places."""
    spots = ("description", "horizon", "solver", "agents", "agents[0].radius", "agents[1].start")
    for number, (name, raw) in enumerate(RAW.items()):
        for spot in (spots[number % len(spots)], spots[(number + 3) % len(spots)]):
            tree = base("room")
            if spot.startswith("agents["):
                tree["agents"][int(spot[7])][spot[10:]] = "PLACE"
            else:
                tree[spot] = "PLACE"
            text = dump(tree, flow=True).replace(b"PLACE", raw.encode())
            # Of a text that cannot be read to its end nothing but the place is known.
            yield Case(f"{name} at {spot}", text)


def _damaged() -> Iterator[Case]:
    """Cut short, or with bytes that no text has."""
    for number, name in enumerate(BASES):
        whole = dump(base(name), flow=True)
        rng = random.Random(f"damage {number}")
        for cut in sorted(rng.sample(range(1, len(whole) - 3), 12)):
            yield Case(f"cut-{name}-{cut}", whole[:cut], beside(name))
        for byte in (b"\x00", b"\x07", b"\xff", b"\xc3\x28", b"\xed\xa0\x80", b"\x1b[31m"):
            at = rng.randrange(1, len(whole))
            yield Case(f"byte-{name}-{byte.hex()}", whole[:at] + byte + whole[at:], beside(name))


_FILES = {
    "empty": b"",
    "spaces": b"  \n\n",
    "comment": b"# nothing\n",
    "only a mark": b"\xef\xbb\xbf",
    "utf-16": "stplan: 1\n".encode("utf-16"),
    "utf-32": "stplan: 1\n".encode("utf-32"),
    "zip": b"PK\x03\x04" + bytes(200),
    "elf": b"\x7fELF" + bytes(range(256)),
    "json list": b"[1, 2, 3]",
    "number": b"17",
    "text": b"hello",
    "null": b"~",
    "two documents": b"stplan: 1\n---\nstplan: 1\n",
    "tabs": b"stplan: 1\nagents:\n\t- id: sam\n",
    "directive": b"%YAML 9.9\n---\nstplan: 1\n",
    "indentation": b"stplan: 1\n agents: []\n",
    "colons": b"a: b: c: d\n",
    "no agents": b"stplan: 1\nhorizon: 9\nagents: []\n",
    "too many agents": b"stplan: 1\nhorizon: 9\nagents: [" + b"{id: a}, " * 10_001 + b"]\n",
    "all in one place": b"stplan: 1\nhorizon: 9\nagents: ["
    + b", ".join(b"{id: a%d, start: [0, 0], goal: [1, 1]}" % k for k in range(2000))
    + b"]\n",
    "wide list": b"[" + b"1, " * 1_000_100 + b"]",
    "too large": b"#" * (16 * 2**20 + 1),
    "many faults": b"stplan: 1\nhorizon: 9\nagents: [" + b"{radius: x, q: 1}, " * 5000 + b"]\n",
}


_HEAD = b"id,start_x,start_y,goal_x,goal_y\n"
_TABLES = {
    "empty": b"",
    "head only": _HEAD,
    "other head": b"a,b,c\n1,2,3\n",
    "column twice": _HEAD[:-1] + b",id\na,1,1,2,2,b\n",
    "too few cells": _HEAD + b"a,1,1\n",
    "no number": _HEAD + b"a,one,1,2,2\n",
    "nan": _HEAD + b"a,nan,1,2,2\n",
    "huge": _HEAD + b"a,1e300,1,2,2\n",
    "no id": _HEAD + b",1,1,2,2\n",
    "bad id": _HEAD + b"'a b',1,1,2,2\n",
    "twice": _HEAD + b"a,1,1,2,2\na,5,5,6,6\n",
    "open quote": _HEAD + b'"a,1,1,2,2\n',
    "long cell": _HEAD + b"a" * 200_000 + b",1,1,2,2\n",
    "latin": _HEAD + b"caf\xe9,1,1,2,2\n",
    "nul": _HEAD + b"a\0b,1,1,2,2\n",
    "formula": _HEAD + b"=cmd(),1,1,2,2\n",
    "one place": _HEAD + b"a,1,1,2,2\nb,1,1,5,5\n",
    "20000 rows": _HEAD + b"".join(b"a%d,1,%d,2,%d\n" % (k, k, k) for k in range(20_000)),
    "100000 bad rows": _HEAD + b"a,x,1,2,2\n" * 100_000,
    "above 16 MiB": b"x" * (16 * 2**20 + 1),
}


def _tables() -> Iterator[Case]:
    text = b"stplan: 1\nhorizon: 20\nagents: [{file: people.csv}]\n"
    for name, table in _TABLES.items():
        yield Case(f"table: {name}", text, {"people.csv": table}, "agents")


def cases() -> Iterator[Case]:
    """All damaged texts and tables."""
    yield from _tables()
    yield from _raw()
    yield from _damaged()
    for name, text in _FILES.items():
        yield Case(name, text)
