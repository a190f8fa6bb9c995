"""Hundreds of random small problems against brute force: `python -m tests.balancing.campaign --problems 300`.

For every objective and norm, problems of one to three planes with uneven and blocked holes, capacities in pieces and in
grams, and a small shared box; a sixth as many with pieces on the rotor, and as many that are hard on the numerics. Each
is asked everything that `against_brute_force` asks. Ends with status 1 where anything does not hold.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable

from service.balancing.selection.problem import SelectionProblem
from tests.support.numerics.against_brute_force import check_all
from tests.support.numerics.random_problems import KINDS, awkward_problem, fitted_problem, random_problem

Family = Callable[[str, int], SelectionProblem]
FAMILIES: dict[str, tuple[Family, int]] = {
    "plain": (random_problem, 1),
    "on the rotor": (fitted_problem, 6),
    "awkward": (awkward_problem, 6),
}
"""Problems, and of how many plain ones there is one."""


def campaign(problems: int, kinds: tuple[str, ...], families: tuple[str, ...], first: int = 0) -> list[str]:
    """Check `problems` plain problems of each kind and their share of the others; returns what does not hold."""
    failed = []
    for kind in kinds:
        for family in families:
            made, one_of = FAMILIES[family]
            seen: Counter[str] = Counter()
            begun = time.perf_counter()
            for seed in range(first, first + -(-problems // one_of)):
                problem = made(kind, seed)
                seen.update(_traits(problem))
                try:
                    seen.update(check_all(problem, seed))
                except (AssertionError, ArithmeticError, ValueError, Warning) as wrong:
                    failed.append(f"{kind}, {family}, seed {seed}: {type(wrong).__name__} {wrong}")
                    print(failed[-1], file=sys.stderr, flush=True)
            took = time.perf_counter() - begun
            print(f"{kind}, {family}: {', '.join(f'{n} {what}' for what, n in seen.items())}; {took:.0f} s", flush=True)
    return failed


def _traits(problem: SelectionProblem) -> list[str]:
    """What a problem is made of."""
    return ["problems", f"of {len(problem.planes)} planes"]


def main() -> int:
    """Run it as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=300, help="plain problems of each objective and norm")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--kind", choices=KINDS, action="append", help="only this objective or norm")
    parser.add_argument("--family", choices=tuple(FAMILIES), action="append", help="only problems of this family")
    asked = parser.parse_args()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        failed = campaign(asked.problems, tuple(asked.kind or KINDS), tuple(asked.family or FAMILIES), asked.first)
    print(f"{len(failed)} do not hold" if failed else "everything holds")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
