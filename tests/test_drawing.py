"""A page drawn by two processes has the pictures that one would draw, whatever becomes of the second."""

import os

import pytest

from clearsweep.report import drawing
from clearsweep.report.picture import Picture

HERE = os.getpid()


def pictures(paint=lambda ax: None):
    """Return as many pictures as two processes draw, each with its number on it."""

    def painted(number):
        def draw(ax):
            paint(ax)
            ax.set_title(f"{number}")
            ax.set_axis_off()

        return draw

    return [Picture(f"{number}", "", f"{number}", painted(number)) for number in range(drawing.SEVERAL)]


def alone(monkeypatch, drawn):
    """Return what one process draws."""
    with monkeypatch.context() as patch:
        patch.setattr(drawing, "_can_copy", lambda: False)
        return drawing.svgs(drawn)


def fails(ax):
    """End the second process as a fault would."""
    if os.getpid() != HERE:
        os._exit(3)


def hangs(ax):
    """Make the second process wait for what never comes."""
    if os.getpid() != HERE:
        os.read(os.pipe()[0], 1)


@pytest.mark.skipif(not drawing._can_copy(), reason="needs Linux and two processors")
@pytest.mark.parametrize("paint", [lambda ax: None, fails, hangs])
def test_two_processes_draw_what_one_draws(monkeypatch, paint):
    monkeypatch.setattr(drawing, "AT_LEAST", 0.2)
    monkeypatch.setattr(drawing, "PATIENCE", 0.2 if paint is hangs else 10.0)
    drawn = pictures(paint)
    assert drawing.svgs(drawn) == alone(monkeypatch, drawn)
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)  # none is left


@pytest.mark.skipif(not drawing._can_copy(), reason="needs Linux and two processors")
def test_a_fault_of_a_picture_is_told_by_the_first_process():
    def broken(ax):
        raise ValueError("broken")

    drawn = [*pictures()[:-1], Picture("", "", "", broken)]
    with pytest.raises(ValueError, match="broken"):
        drawing.svgs(drawn)
