"""A formula of many rods as C, compiled once for a kind of rod and kept beside the rods derived from files.

NumPy sends every product of two arrays through memory; compiled, a formula runs on eight rods at a time in
the registers of the processor. Every operation is that of IEEE 754 (nothing contracted, nothing reordered),
so that the numbers depend neither on the rods beside nor on the width of the registers.

The compiler is $RODWNL_CC, or else $CC, or cc. Without one, or where it refuses, formulas run in NumPy.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.models import cache_folder
from rodwnl.recorded import PRELUDE, Recorded, Tape
from rodwnl.storage import replacing

# The last two keep GCC from contracting: it does so for pairs of stores even where it is told not to.
OPTIONS = (
    "-shared", "-fPIC", "-O3", "-fno-math-errno", "-fno-trapping-math",
    "-ffp-contract=off", "-fno-tree-slp-vectorize",
)  # fmt: skip
LONGEST = 120  # seconds that a compiler is given
Complex = NDArray[np.complexfloating[Any, Any]]
Kernel = Callable[[Sequence[Any], Complex], Complex]  # of columns (n,) and λ (points, n)

HEAD = """\
#define _GNU_SOURCE
#include <math.h>
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define LOOP __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"))) static void
#else
#define LOOP static void
#endif
enum { BLOCK = 256 };
"""
DRIVER = """\
void evaluate(long n, long points, const double *const *column, const double *lam, double *out)
{{
    double power[{powers}][BLOCK];
    for (long point = 0; point < points; point++)
        for (long start = 0; start < n; start += BLOCK) {{
            const long count = n - start < BLOCK ? n - start : BLOCK;
            const double *const z = lam + 2*(point*n + start);
            exponents({given});
            for (int k = 0; k < {powers}; k += 2)
                for (long i = 0; i < count; i++) {{
                    const double size = exp(power[k][i]), angle = power[k + 1][i];
                    power[k][i] = size*cos(angle);
                    power[k + 1][i] = size*sin(angle);
                }}
            results({given}, {out});
        }}
}}
"""


def source(tape: Tape, columns: Sequence[str], results: Sequence[Recorded]) -> str:
    """C for what was recorded from real columns of these names and from lam_re, lam_im.

    Two loops of arithmetic that a compiler can vectorise, with the exponentials between them.
    """
    powers = [f"power{k}_{part}" for k in range(len(tape.powers)) for part in ("re", "im")]
    given = {name: f"{name}_at[i]" for name in columns} | {"lam_re": "lam[2*i]", "lam_im": "lam[2*i + 1]"}
    pointers = [*(f"const double *restrict {name}_at" for name in columns), "const double *restrict lam"]

    def loop(name: str, given: dict[str, str], pointers: list[str], results: list[tuple[str, Any]]) -> str:
        lines, used = tape.needed(value for _, value in results)
        body = [f"const double {name} = {place};" for name, place in given.items() if name in used]
        body += [*lines, *(f"{place} = {value};" for place, value in results)]
        inside = "".join(f"        {line}\n" for line in body)
        head = f"LOOP {name}(long n, {', '.join(pointers)})"
        return f"{head}\n{{\n    for (long i = 0; i < n; i++) {{\n{inside}    }}\n}}\n"

    first = loop(
        "exponents", given, [*pointers, *(f"double *restrict {p}_at" for p in powers)],
        [(f"{p}_at[i]", x) for p, x in zip(powers, sum(tape.powers, ()), strict=True)],
    )  # fmt: skip
    second = loop(
        "results", given | {p: f"{p}_at[i]" for p in powers},
        [*pointers, *(f"const double *restrict {p}_at" for p in powers),
         *(f"double *restrict out{q}" for q in range(len(results)))],
        [(f"out{q}[2*i + {k}]", x) for q, z in enumerate(results) for k, x in enumerate((z.re, z.im))],
    )  # fmt: skip
    driver = DRIVER.format(
        powers=len(powers),
        given=", ".join([
            "count", *(f"column[{k}] + start" for k in range(len(columns))),
            "z", *(f"power[{k}]" for k in range(len(powers))),
        ]),
        out=", ".join(f"out + 2*(({q}*points + point)*n + start)" for q in range(len(results))),
    )  # fmt: skip
    return HEAD + PRELUDE + first + second + driver


def kernel(tape: Tape, columns: Sequence[str], results: Sequence[Recorded]) -> Kernel | None:
    """The function of columns (n,) and λ (points, n) that gives the results, (results, points, n).

    None where there is no compiler that takes it.
    """
    function = _loaded(source(tape, columns, results))
    if function is None:
        return None
    inputs, outputs = len(columns), len(results)

    def evaluate(given: Sequence[Any], lam: Complex) -> Complex:
        if len(given) != inputs:
            raise ValueError(f"{len(given)} columns for a formula of {inputs}")  # C would read anywhere
        points, n = lam.shape
        lam = np.ascontiguousarray(lam, dtype=complex)
        out = np.empty((outputs, points, n), dtype=complex)
        held = [
            np.ascontiguousarray(x if np.shape(x) == (n,) else np.broadcast_to(x, (n,)), dtype=float)
            for x in given
        ]
        pointers = (ctypes.c_void_p * len(held))(*(x.ctypes.data for x in held))
        function(n, points, pointers, lam.ctypes.data, out.ctypes.data)
        return out

    return evaluate


def _loaded(text: str) -> Any:
    """The compiled function, from the folder where such are kept or compiled now; None without a compiler."""
    command: list[str] = []
    with suppress(ValueError):  # a quotation that does not end
        command = shlex.split(os.environ.get("RODWNL_CC", os.environ.get("CC", "cc")))
    if not command:
        return None
    machine = f"{sys.platform}\0{platform.machine()}\0{' '.join((*command, *OPTIONS))}\0"
    kept = cache_folder() / "compiled" / f"{hashlib.sha256((machine + text).encode()).hexdigest()[:32]}.so"
    with suppress(OSError, AttributeError):  # there is none, or a damaged one
        return _function(kept)
    with tempfile.TemporaryDirectory() as folder:
        code, library = Path(folder) / "formula.c", Path(folder) / "formula.so"
        code.write_text(text, encoding="ascii")
        try:
            subprocess.run(
                [*command, *OPTIONS, "-o", library, code, "-lm"],
                check=True,
                capture_output=True,
                timeout=LONGEST,
            )
            found = _function(library)
        except (OSError, subprocess.SubprocessError, AttributeError):
            return None
        with suppress(OSError):  # then it is compiled again another time
            kept.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            with replacing(kept) as temporary:
                temporary.write_bytes(library.read_bytes())
    return found


def _function(library: Path) -> Any:
    function = ctypes.CDLL(str(library)).evaluate
    function.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    function.restype = None
    return function
