// What the plots run over: frames, seconds, or millimetres of travel.
class Axis {
  /** `values` rise strictly, one a frame. */
  constructor(name, unit, values) { Object.assign(this, { name, unit, values }); }

  /** The value at a frame, which may lie between two or beyond the ends. */
  at(frame) {
    const { values } = this;
    if (values.length < 2) return (values[0] ?? 0) + frame;
    const i = Math.min(Math.max(Math.floor(frame), 0), values.length - 2);
    return values[i] + (frame - i) * (values[i + 1] - values[i]);
  }

  /** The frame at a value: the inverse. */
  frame(value) {
    const { values } = this;
    if (values.length < 2) return value - (values[0] ?? 0);
    let lo = 0, hi = values.length - 2;
    while (lo < hi) {
      const middle = (lo + hi + 1) >> 1;
      if (values[middle] <= value) lo = middle; else hi = middle - 1;
    }
    return lo + (value - values[lo]) / (values[lo + 1] - values[lo]);
  }
}

/** The axes that a page offers: those whose values rise from frame to frame. */
function axesOf(model) {
  const rises = (values) => values?.length > 1 && values.every((v, i) => v !== null && (!i || v > values[i - 1]));
  const all = [["Frames", "frame", Array.from({ length: model.frames }, (_, i) => i)], ["Seconds", "s", model.time_s], ["Travel", "mm of travel", model.travel_mm]];
  return all.filter(([, , values], k) => !k || rises(values)).map(([name, unit, values]) => new Axis(name, unit, values));
}

/** Places between `left` and `right` [px] of the visible frames: of a frame, of a value of the axis, and back. */
function abscissa(view, left, right) {
  const { axis } = view;
  const a = axis.at(view.lo), perPx = (axis.at(view.hi) - a) / (right - left);
  const of = (value) => left + (value - a) / perPx;
  return { of, x: (frame) => of(axis.at(frame)), frame: (px) => axis.frame(a + (px - left) * perPx), range: [a, a + (right - left) * perPx] };
}

/** The frame under the mouse. */
function frameUnder(plot, event, view) {
  const px = event.clientX - plot.svg.getBoundingClientRect().left;
  return Math.min(Math.max(abscissa(view, plot.left, plot.right).frame(px), view.lo), view.hi);
}
