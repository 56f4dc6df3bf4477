"""Prime seeds, which some random generators demand."""

from __future__ import annotations

from math import isqrt

#: Insertion in LIGGGHTS wants primes above this one.
SMALLEST_PRIME_SEED = 10_007
#: A prime below the largest seed that LAMMPS takes.
_RANGE = 899_809_343
#: The range over the golden ratio: multiples of it are spread evenly over the range (Knuth, The Art
#: of Computer Programming 3, section 6.4), farther apart than primes are.
_STEP = 556_112_757
#: Names under which a model gets its primes.
PRIME_SEEDS = ("prime_seed", "prime_seed_2", "prime_seed_3")


def prime_seeds(seed: int) -> dict[str, int]:
    """Return three different primes from 10,007 to 900,000,000 that belong to a seed.

    LIGGGHTS takes primes above 10,000 only, and different ones for the insertion, the particle
    distribution and the particle template. Up to a hundred thousand seeds in a row have different
    primes.

    Examples
    --------
    >>> prime_seeds(1)
    {'prime_seed': 556122797, 'prime_seed_2': 856055897, 'prime_seed_3': 256189699}
    """
    width = _RANGE - SMALLEST_PRIME_SEED
    first = seed * _STEP % width
    return {
        name: _prime_from(SMALLEST_PRIME_SEED + (first + number * width // 3) % width)
        for number, name in enumerate(PRIME_SEEDS)
    }


def _prime_from(candidate: int) -> int:
    while not _is_prime(candidate):
        candidate += 1
    return candidate


def _is_prime(number: int) -> bool:
    return number % 2 == 1 and all(number % divisor for divisor in range(3, isqrt(number) + 1, 2))
