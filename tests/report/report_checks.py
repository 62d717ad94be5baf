"""What a picture has to satisfy to be printed."""

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def _words(text, renderer):
    # An annotation's extent includes its arrow; what may not be covered is the words.
    return Text.get_window_extent(text, renderer)


def visible_boxes(figure):
    """Bounding boxes in pixels of all words to be seen, without tick labels beyond the axis."""
    figure.set_dpi(200)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    ticks, kept = set(), set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            every = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
            ticks |= {label for tick in every for label in (tick.label1, tick.label2)}
            if axes.axison:
                drawn = axis._update_ticks()
                kept |= {label for tick in drawn for label in (tick.label1, tick.label2)}
    found = []
    for text in figure.findobj(Text):
        if not text.get_visible() or not text.get_text().strip():
            continue
        if text in ticks and text not in kept:
            continue
        found.append((text.get_text(), _words(text, renderer)))
    return found


def overlaps(figure) -> list[tuple[str, str]]:
    """Pairs of words that cover each other."""
    return [
        (first, second)
        for (first, a), (second, b) in combinations(visible_boxes(figure), 2)
        # Half a pixel of rounding is no overlap.
        if min(a.x1, b.x1) - max(a.x0, b.x0) > 0.5 and min(a.y1, b.y1) - max(a.y0, b.y0) > 0.5
    ]


def outside(figure) -> list[str]:
    """Words that leave the page."""
    page = figure.bbox
    return [
        words
        for words, box in visible_boxes(figure)
        if box.x0 < page.x0 - 0.5
        or box.y0 < page.y0 - 0.5
        or box.x1 > page.x1 + 0.5
        or box.y1 > page.y1 + 0.5
    ]


def assert_printable(figure) -> None:
    """Words neither cover each other nor leave the page, and none is too small to read."""
    assert overlaps(figure) == []
    assert outside(figure) == []
    words = [t for t in figure.findobj(Text) if t.get_text().strip()]
    assert words
    assert min(t.get_fontsize() for t in words) >= 7


def axis_labels(figure) -> list[str]:
    """Labels of all axes that are drawn and have ticks."""
    return [
        label
        for axes in figure.axes
        if axes.axison
        for label in (axes.get_xlabel(), axes.get_ylabel())
        if label
    ]
