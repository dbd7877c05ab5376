"""The examples of the docstrings give what they say; help is there at run time, with shapes and units."""

from __future__ import annotations

import doctest

import pytest

import seamtrack


@pytest.mark.parametrize("module", [seamtrack, seamtrack.calib, seamtrack.kalman, seamtrack.synth], ids=lambda m: m.__name__)
def test_the_examples_of_a_module_hold(module):
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize("native", [seamtrack.Config, seamtrack.Session], ids=lambda c: c.__name__)
def test_the_examples_of_a_class_hold(native):
    runner = doctest.DocTestRunner()
    found = doctest.DocTestFinder(recurse=False).find(native, native.__name__, module=False, globs={})
    for test in found:
        runner.run(test)
    assert runner.summarize().attempted > 1 and runner.summarize().failed == 0


def test_everything_public_is_documented():
    for name in seamtrack.__all__:
        thing = getattr(seamtrack, name)
        if name != "__version__":
            assert thing.__doc__, name
        if isinstance(thing, type):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or hasattr(value, "__get__")):
                    assert getattr(thing, member).__doc__, f"{name}.{member}"
    assert "shape (rows, columns)" in seamtrack.Session.step.__doc__
