"""The docstrings, of which the page of all names is made: each public name has its own."""

import inspect
import re

import pytest

import vn100

UNIT_OR_SHAPE = re.compile(r"\b(shape|units?|hertz|Hz|seconds?)\b")
NUMBERS = re.compile(r"\b(ArrayLike|NDArray|float)\b")


def members(owner):
    for name, thing in vars(owner).items():
        if not name.startswith("_") and (inspect.isfunction(thing) or isinstance(thing, property)):
            yield f"{owner.__name__}.{name}", thing


PUBLIC = {name: getattr(vn100, name) for name in vn100.__all__}
ALL = PUBLIC | {name: thing for owner in PUBLIC.values() if inspect.isclass(owner) for name, thing in members(owner)}


def said(thing):
    """Its docstring, with that of the function to which it refers."""
    text = thing.__doc__ or ""
    return text + "".join(PUBLIC[name].__doc__ for name in re.findall(r"[Aa]s :func:`(\w+)`", text))


@pytest.mark.parametrize("name", ALL)
def test_each_name_has_a_docstring_and_numbers_have_a_unit_or_a_shape(name):
    thing = ALL[name]
    # a dataclass without one is given its signature
    assert thing.__doc__ and not thing.__doc__.startswith(name + "("), name
    of = thing.fget if isinstance(thing, property) else thing
    types = str([getattr(part, "__annotations__", {}) for part in (of, of.__init__)])
    assert UNIT_OR_SHAPE.search(said(thing)) or not NUMBERS.search(types), name


@pytest.mark.parametrize("name", [name for name, thing in PUBLIC.items() if not inspect.isclass(thing)])
def test_each_function_says_what_it_raises(name):
    assert "Raises" in said(PUBLIC[name]), name
