"""Cases of a test: those that `make test` runs, and the others, which only a release needs."""

import pytest

release = pytest.mark.release


def quick(cases, *kept):
    """Cases for `parametrize` or a fixture, of which `make test` runs only those in `kept`, `make test-all` all.

    A case is a value, or a tuple of values. Raises ValueError for what is kept and no case.
    """
    cases = list(cases)
    unknown = [each for each in kept if not any(case is each or case == each for case in cases)]
    if unknown:
        raise ValueError(f"no such cases: {unknown}")
    return [case if any(case is each or case == each for each in kept)
            else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=release) for case in cases]
