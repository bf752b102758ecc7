// The timeline: a lane for each family of tasks. The kinds of time differ in height and
// pattern, not only in colour: acting is a full bar, sensing a half bar, waiting a thin
// bar, suspended is hatched, failures are crosses.

const LANE = 18;
const AXIS = 22;
/** The rows of the legend: kind, text. */
const LEGEND = [
  ["acting", "acting"],
  ["sensing", "sensing"],
  ["waiting", "waiting"],
  ["suspended", "suspended"],
  ["bad", "bad result"],
  ["failed", "failed"],
];

/** Return the colours of the page as the browser resolves them. */
function coloursOf(root) {
  const names = ["panel", "line", "text", "dim", "accent", "chosen", "acting",
    "sensing", "waiting", "suspended", "failed", "done"];
  const probes = names.map((name) => {
    const probe = el("span");
    probe.style.color = `var(--${name})`;
    return probe;
  });
  root.append(...probes);
  const found = names.map((name, index) => [name, getComputedStyle(probes[index]).color]);
  for (const probe of probes) probe.remove();
  return Object.fromEntries(found);
}

/** Prepare a canvas for drawing in CSS pixels; return its context. */
function contextOf(canvas, width, height) {
  const scale = window.devicePixelRatio || 1;
  const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

/** Return a hatched fill. */
function hatch(context, colour) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 5;
  const pen = tile.getContext("2d");
  pen.strokeStyle = colour;
  pen.lineWidth = 1.4;
  pen.beginPath();
  for (const x of [-5, 0, 5]) pen.moveTo(x, 5), pen.lineTo(x + 5, 0);
  pen.stroke();
  return context.createPattern(tile, "repeat");
}

/** Draw a bar of a kind of time between two positions in a lane that begins at `top`. */
function drawBar(context, colours, kind, from, to, top) {
  const width = Math.max(to - from, 1);
  switch (kind) {
    case "acting":
      context.fillStyle = colours.acting;
      context.fillRect(from, top + 3, width, 12);
      break;
    case "sensing":
      context.fillStyle = colours.sensing;
      context.fillRect(from, top + 9, width, 6);
      break;
    case "waiting":
      context.fillStyle = colours.waiting;
      context.fillRect(from, top + 8, width, 3);
      break;
    case "suspended":
      context.fillStyle = colours.hatch;
      context.fillRect(from, top + 4, width, 10);
      context.strokeStyle = colours.suspended;
      context.lineWidth = 1;
      if (width > 2) context.strokeRect(from + 0.5, top + 4.5, width - 1, 9);
      break;
    case "bad":
      context.fillStyle = colours.failed;
      context.fillRect(to - 1, top + 1, 2, 16);
      break;
    case "wrong":
      context.fillStyle = colours.hatchFailed;
      context.fillRect(from, top + 4, width, 10);
      context.fillStyle = colours.failed;
      context.fillRect(from, top + 13, width, 2);
      break;
    case "failed":
      drawCross(context, colours.failed, to, top + 9, 3.5);
      break;
  }
}

function drawCross(context, colour, x, y, size) {
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x - size, y - size);
  context.lineTo(x + size, y + size);
  context.moveTo(x - size, y + size);
  context.lineTo(x + size, y - size);
  context.stroke();
}

/** The least time between two labels of the axis, which have six decimals. */
const SHORTEST = 1e-6;

/** Return round times for an axis, about one for each 90 pixels. */
function ticksOf(from, to, width) {
  const rough = Math.max(((to - from) * 90) / Math.max(width, 1), SHORTEST);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough) || rough;
  const found = [];
  for (let tick = Math.ceil(from / step) * step; tick <= to && found.length < 100; tick += step)
    found.push(tick);
  return found;
}

/** Return the bars of a kind of time: the times of their starts and stops. */
function barsAt(run, kind, list, start, stop) {
  const now = (at) => run.timeOf(at === null || at === undefined || at < 0 ? run.last : at);
  const from = Float64Array.from(list, (one) => now(start(one)));
  return { kind, from, to: Float64Array.from(list, (one) => now(stop(one))) };
}

/** Return the bars of a family, in the order in which they are drawn. */
function barsOf(run, task) {
  const of = (kind, list, start) => barsAt(run, kind, list, start, (one) => one.stop);
  const begun = (one) => one.start;
  const seen = task.pieces.filter((one) => !one.background);
  const bad = seen.filter((one) => !["", "okay", "cancelled"].includes(one.result));
  return [
    ...["waiting", "suspended"].map((kind) =>
      of(kind, task.waits.filter((one) => one.kind === kind), begun)),
    ...["sensing", "acting"].map((kind) =>
      of(kind, seen.filter((one) => one.kind === kind), begun)),
    of("bad", bad, (one) => one.stop),
  ];
}

function wrongBars(run) {
  return barsAt(run, "wrong", run.beliefs, (one) => one.n, (one) => one.end);
}

/** Return the lane of a family; `over` if further events do not change its bars. */
function laneOf(run, task) {
  const over = task.ended >= 0 && task.pieces.every((one) => one.stop >= 0);
  return { task, over, outcome: task.outcome, bars: barsOf(run, task) };
}

/** The lanes of one run. */
class Timeline {
  constructor(app, index, view) {
    this.app = app;
    this.index = index;
    this.run = app.runs[index];
    this.view = view;
    this.lanes = this.run.families.map((task) => laneOf(this.run, task));
    if (this.run.beliefs.length)
      this.lanes.unshift({ task: null, bars: [wrongBars(this.run)] });
    this.canvas = el("canvas", {
      role: "slider", tabindex: 0, "aria-label": "Time", "aria-orientation": "horizontal",
    });
    this.names = el("div.names", { role: "group", "aria-label": "Top-level tasks" });
    const name = app.runs.length > 1 ? app.names[index] : "tasks";
    this.names.append(el("div.run", {}, `${name} · time units →`));
    this.buttons = this.lanes.map((lane) => this._name(lane));
    this.names.append(...this.buttons);
    this.cursor = el("div.cursor", { "aria-hidden": "true" });
    const stage = el("div.stage", {}, el("div.drawing", {}, this.canvas, this.cursor));
    this.element = el("div.lanes", {}, this.names, stage);
    this._fit();
    /** The size of the drawing and the scroll position: read when they change. */
    this.size = { width: 0, height: 0, top: 0 };
    /** What the canvas shows: it is drawn again only if this changes. */
    this.drawn = "";
    /** The family whose lane is marked. */
    this.family = undefined;
    const measure = () => {
      this.size = {
        width: stage.clientWidth, height: this.element.clientHeight, top: this.element.scrollTop,
      };
      this.draw();
    };
    this.element.addEventListener("scroll", measure, { passive: true });
    new ResizeObserver(measure).observe(stage);
    new ResizeObserver(measure).observe(this.element);
    moveWithArrows(this.names, "button");
    this._listen();
  }

  _fit() {
    this.element.style.height = `${AXIS + this.lanes.length * LANE + 4}px`;
  }

  /** Show the events that a run without known beliefs has got since. */
  grow() {
    this.lanes = this.run.families.map((task, index) => {
      const known = this.lanes[index];
      if (known && known.over) return known;
      const lane = laneOf(this.run, task);
      if (known && known.outcome === lane.outcome) return lane;
      const button = this._name(lane);
      if (known) this.buttons[index].replaceWith(button);
      else this.names.append(button);
      this.buttons[index] = button;
      return lane;
    });
    this.drawn = "";
    this.family = undefined; // a new button is not marked
    this._fit();
  }

  _name(lane) {
    const { task } = lane;
    if (task === null)
      return el("button", { type: "button", click: () => this.app.nextWrong(1) },
        el("span.sign.failed", {}, "≠"), el("span.goal", {}, "belief differs from truth"));
    const kind = task.outcome || "unfinished";
    const act = () => this.app.go(task.ended < 0 ? this.run.last : task.ended, {
      task: task.number, run: this.index,
    });
    const [, words] = SIGNS[kind];
    return el(
      "button",
      { type: "button", click: act, title: `${visible(task.goal)} [${task.number}]: ${words}` },
      signOf(kind),
      el(`span.goal.${kind}`, {}, task.goal),
    );
  }

  _listen() {
    const { canvas } = this;
    let dragged = false;
    const timeAt = (event) => {
      const { from, to } = this.view;
      const box = canvas.getBoundingClientRect();
      const part = (event.clientX - box.left) / Math.max(box.width, 1);
      return from + Math.min(Math.max(part, 0), 1) * (to - from);
    };
    const laneAt = (event) => {
      const y = event.clientY - canvas.getBoundingClientRect().top - AXIS;
      return y < 0 ? null : this.lanes[Math.floor((y + this.element.scrollTop) / LANE)] || null;
    };
    const moved = (event, pick) => {
      const lane = laneAt(event);
      const to = { run: this.index };
      if (pick && lane && lane.task) to.task = this._taskNear(lane, timeAt(event));
      this.app.go(this.run.atTime(timeAt(event)), to);
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      dragged = true;
      canvas.setPointerCapture(event.pointerId);
      moved(event, true);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (dragged) moved(event, false);
      else this._tell(event, laneAt(event), timeAt(event));
    });
    for (const kind of ["pointerup", "pointercancel"])
      canvas.addEventListener(kind, () => (dragged = false));
    canvas.addEventListener("pointerleave", () => (byId("tip").hidden = true));
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey && !event.shiftKey) return;
        event.preventDefault();
        this.app.zoom(event.deltaY < 0 ? 0.8 : 1.25, timeAt(event));
      },
      { passive: false },
    );
  }

  /** Return the request of a lane at a time, or the nearest within six pixels. */
  _pieceNear(lane, time) {
    const near = (6 * (this.view.to - this.view.from)) / Math.max(this.canvas.clientWidth, 1);
    let best = null;
    let distance = near;
    for (const one of lane.task.pieces) {
      const start = this.run.timeOf(one.start);
      const stop = this.run.timeOf(one.stop < 0 ? this.run.last : one.stop);
      const away = time < start ? start - time : time > stop ? time - stop : 0;
      if (away < distance || (away === 0 && distance === 0)) [best, distance] = [one, away];
    }
    return best;
  }

  _taskNear(lane, time) {
    const piece = this._pieceNear(lane, time);
    return piece ? piece.task : lane.task.number;
  }

  _tell(event, lane, time) {
    const tip = byId("tip");
    const piece = lane && lane.task && this._pieceNear(lane, time);
    const text = (at) => readable(this.run.timeOf(at < 0 ? this.run.last : at));
    let told = `time ${readable(Number(time.toPrecision(6)))}`;
    if (piece) {
      told = `${piece.request} [${piece.task}], ${text(piece.start)} to ${text(piece.stop)}`;
      if (piece.result) told += `: ${piece.result}`;
    }
    tip.textContent = visible(told);
    tip.hidden = false;
    const right = event.clientX > window.innerWidth / 2;
    tip.style.left = right ? "auto" : `${event.clientX + 12}px`;
    tip.style.right = right ? `${window.innerWidth - event.clientX + 12}px` : "auto";
    tip.style.top = `${event.clientY + 14}px`;
  }

  /** Mark the lane of the selected task; if the lane is another one, scroll to it. */
  mark(task) {
    const own = task && this.run.tasks.get(task.number) === task;
    const family = own ? this.run.familyOf(task) : null;
    this.task = task || null;
    if (family === this.family) return;
    this.family = family;
    this.lanes.forEach((lane, index) => {
      const chosen = lane.task !== null && lane.task === family;
      this.buttons[index].setAttribute("aria-pressed", String(chosen));
      if (!chosen) return;
      const topOf = () => {
        const room = this.element.clientHeight - AXIS - LANE;
        const away = index * LANE - this.element.scrollTop;
        return away < 0 || away > room ? index * LANE - room / 2 : null;
      };
      whenWritten(topOf, (top) => {
        if (top !== null) this.element.scrollTop = top;
      });
    });
  }

  /** Show the moment, and draw the lanes if they look different now. */
  draw() {
    const { run, canvas } = this;
    const { width, height, top } = this.size;
    if (!width || !height) return;
    const { from, to } = this.view;
    const at = this.app.momentOf(this.index);
    const now = Math.round(((run.timeOf(at) - from) * width) / (to - from || 1));
    this.cursor.style.height = `${height}px`;
    this.cursor.style.transform = `translateX(${Math.min(Math.max(now, -6), width + 6)}px)`;
    canvas.setAttribute("aria-valuemin", run.timeOf(0));
    canvas.setAttribute("aria-valuemax", run.timeOf(run.last));
    canvas.setAttribute("aria-valuenow", run.timeOf(at));
    canvas.setAttribute("aria-valuetext", `time ${readable(run.timeOf(at))}`);
    const colours = this.app.colours;
    const scale = window.devicePixelRatio;
    const state = [width, height, top, from, to, scale, this.task?.number, colours.text];
    const drawn = JSON.stringify(state);
    if (this.drawn === drawn) return;
    this.drawn = drawn;
    this._lanes(width, height, top);
  }

  _lanes(width, height, top) {
    const { canvas } = this;
    canvas.style.height = `${height}px`;
    const context = contextOf(canvas, width, height);
    const { from, to } = this.view;
    const colours = this.app.colours;
    colours.hatch = colours.hatch || hatch(context, colours.suspended);
    colours.hatchFailed = colours.hatchFailed || hatch(context, colours.failed);
    const scale = width / (to - from || 1);
    const x = (time) => (time - from) * scale;
    this._axis(context, colours, x, width, height);
    context.save();
    context.beginPath();
    context.rect(0, AXIS, width, height - AXIS);
    context.clip();
    const first = Math.floor(top / LANE);
    const count = Math.ceil((height - AXIS) / LANE) + 1;
    this.lanes.slice(first, first + count).forEach((lane, index) => {
      this._lane(context, colours, lane, x, AXIS + (first + index) * LANE - top, width);
    });
    context.restore();
  }

  _axis(context, colours, x, width, height) {
    context.font = "11px system-ui, sans-serif";
    context.textBaseline = "middle";
    for (const tick of ticksOf(this.view.from, this.view.to, width)) {
      const at = Math.round(x(tick)) + 0.5;
      context.strokeStyle = colours.line;
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(at, AXIS - 5);
      context.lineTo(at, height);
      context.stroke();
      context.fillStyle = colours.dim;
      const text = readable(tick);
      const wide = context.measureText(text).width;
      context.fillText(text, Math.min(Math.max(at - wide / 2, 2), width - wide - 2), 9);
    }
  }

  _lane(context, colours, lane, x, top, width) {
    const { run } = this;
    const now = (at) => run.timeOf(at < 0 ? run.last : at);
    const { task, bars } = lane;
    if (task === null) {
      for (const one of bars) this._bars(context, colours, one, top, width);
      return;
    }
    if (this.task && run.familyOf(this.task) === task) {
      context.fillStyle = colours.chosen;
      context.fillRect(0, top, width, LANE);
      const [from, to] = [x(now(this.task.made)), x(now(this.task.ended))];
      context.fillStyle = colours.accent;
      context.fillRect(from, top + 16, Math.max(to - from, 2), 2);
    }
    context.fillStyle = colours.line;
    const [came, ended] = [x(now(task.made)), x(now(task.ended))];
    context.fillRect(came, top + 9, Math.max(ended - came, 1), 1);
    for (const one of bars) this._bars(context, colours, one, top, width);
    if (task.outcome === "failed")
      drawCross(context, colours.failed, x(now(task.ended)), top + 9, 5);
    if (task.outcome === "succeeded") {
      context.fillStyle = colours.done;
      context.beginPath();
      context.arc(x(now(task.ended)), top + 9, 4, 0, 7);
      context.fill();
    }
    for (const at of task.marks) {
      context.fillStyle = colours.failed;
      const middle = x(now(at));
      context.beginPath();
      context.moveTo(middle, top + 2);
      context.lineTo(middle + 4, top + 9);
      context.lineTo(middle, top + 16);
      context.lineTo(middle - 4, top + 9);
      context.fill();
    }
  }

  /** Draw bars of one kind; bars within a pixel that is drawn are left out. */
  _bars(context, colours, { kind, from, to }, top, width) {
    const begin = this.view.from;
    const scale = width / (this.view.to - begin || 1);
    let reached = -1;
    for (let index = 0; index < from.length; index++) {
      const right = (to[index] - begin) * scale;
      if (right < 0) continue;
      const left = (from[index] - begin) * scale;
      if (left > width || Math.max(right, left + 1) <= reached) continue;
      drawBar(context, colours, kind, Math.max(left, -2), Math.min(right, width + 2), top);
      reached = Math.floor(Math.max(right, left + 1));
    }
  }
}

/** Return the rows of the legend, each with a drawn sample. */
function legendOf(colours, withWrong) {
  const rows = withWrong ? [...LEGEND, ["wrong", "belief wrong"]] : LEGEND;
  return rows.map(([kind, text]) => {
    const canvas = el("canvas", { "aria-hidden": "true" });
    const context = contextOf(canvas, 22, 14);
    colours.hatch = colours.hatch || hatch(context, colours.suspended);
    colours.hatchFailed = colours.hatchFailed || hatch(context, colours.failed);
    drawBar(context, colours, kind, 2, kind === "failed" || kind === "bad" ? 11 : 20, -2);
    return el("li", {}, canvas, text);
  });
}
