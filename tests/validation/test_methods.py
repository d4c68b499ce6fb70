import doctest

import pytest

from validation import methods, terminal
from validation.methods import MethodError, choose


def test_examples():
    for module in (methods, terminal):
        assert doctest.testmod(module).failed == 0


def test_each_method_once():
    assert [method.name for method in choose(["dis", "farneback", "dis"])] == ["dis", "farneback"]


@pytest.mark.parametrize("names", [("files:a/flow", "files:b/flow"), ("x.y:f", "x.y-f"), ("A:f", "a:f")])
def test_two_methods_in_one_file_are_refused(names):
    with pytest.raises(MethodError, match="would both be filed as"):
        choose(names)


@pytest.mark.parametrize("name", ["files:/", "files:..", "../../x:f", "a/b:c", ":", "files:"])
def test_a_slug_is_a_plain_file_name(name):
    slug = choose([name])[0].slug
    assert slug and "/" not in slug and not slug.startswith(".")
