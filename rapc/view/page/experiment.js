// The results of an experiment: plots of all runs by point, and a panel for one run.

const WIDTH = 460, HEIGHT = 230, LEFT = 52, RIGHT = 12, UPPER = 8, LOWER = 36;
const SVG = "http://www.w3.org/2000/svg";

/** Return a new SVG element with attributes and children. */
function svgEl(tag, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** Return a number with few digits. */
function short(value) {
  const digits = Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
  return String(Number(value.toFixed(digits)));
}

/** Return round numbers from 0 or `low` to at least `high`. */
function ticksOf(low, high, most) {
  const raw = (high - low) / most || 1;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw);
  const found = [];
  for (let at = Math.floor(low / step); at * step < high + step * 0.999; at += 1)
    found.push(Number((at * step).toPrecision(12)));
  return found;
}

/** A number from 0 to 1 that depends only on the seed: the place of a dot in its column. */
function jitter(seed) {
  return ((seed * 2654435761) >>> 0) / 2 ** 32;
}

const severity = (run) => (run.end.startsWith("ended by") ? "lost" : run.end ? "some" : "");

/** The plots of a measure for the points of a part. */
class Plot {
  constructor(part, measure, choose) {
    this.part = part;
    this.measure = measure;
    this.choose = choose;
    this.dots = new Map();
    const { points, vary, unit, measures } = part;
    const values = points.flatMap((point) => [
      ...point.runs.map((run) => run.numbers[measure]).filter(Number.isFinite),
      ...(measure in point.reference ? [point.reference[measure]] : []),
    ]);
    const [least, most] = [Math.min(...values), Math.max(...values)];
    const close = least > most * 0.5 && least > 0 && least < most;
    const ticks = ticksOf(close ? least * 0.97 : Math.min(least, 0), most, 5);
    const [low, high] = [ticks[0], ticks.at(-1)];
    this.y = (value) => UPPER + ((high - value) / (high - low)) * (HEIGHT - UPPER - LOWER);
    this.step = (WIDTH - LEFT - RIGHT) / points.length;
    this.svg = svgEl("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group" });
    for (const tick of ticks) {
      const y = this.y(tick);
      const text = { x: LEFT - 6, y: y + 3, "text-anchor": "end" };
      this.svg.append(svgEl("line", { class: "axis", x1: LEFT, x2: WIDTH - RIGHT, y1: y, y2: y }));
      this.svg.append(svgEl("text", text, readable(tick)));
    }
    points.forEach((point, at) => this._draw(point, LEFT + this.step * (at + 0.5)));
    const name = vary ? `${vary}${unit ? ` (${unit})` : ""}` : "";
    const below = { x: (LEFT + WIDTH) / 2, y: HEIGHT - 4, "text-anchor": "middle" };
    this.svg.append(svgEl("text", below, visible(name)));
    const label = measures[measure];
    this.svg.setAttribute("aria-label", visible(`${label} by ${name || "point"}`));
    this.element = el("div.plot", {}, el("h3", {}, label), this.svg);
  }

  _draw(point, x) {
    const letters = Math.max(Math.floor(this.step / 5.6), 3);
    const { label } = point;
    const shown = label.length > letters ? `${label.slice(0, letters - 1)}…` : label;
    this.svg.append(svgEl("text", { x, y: HEIGHT - 20, "text-anchor": "middle" }, visible(shown)));
    const wide = Math.min(this.step * 0.6, 46);
    for (const run of point.runs) {
      const value = run.numbers[this.measure];
      if (Number.isFinite(value)) this._dot(point, run, x + (jitter(run.seed) - 0.5) * wide, value);
    }
    const spread = point.spreads[this.measure];
    if (spread) {
      const [mean, , tenth, ninetieth] = spread;
      const [upper, middle, lower] = [ninetieth, mean, tenth].map(this.y);
      const edge = x + wide / 2 + 5;
      const ends = `M${edge - 3} ${upper}h6M${edge - 3} ${lower}h6`;
      this.svg.append(
        svgEl("path", { class: "spread", d: `${ends}M${edge} ${upper}V${lower}` }),
        svgEl("path", { class: "mean", d: `M${edge - 5} ${middle}h10` }));
    }
    if (this.measure in point.reference) {
      const y = this.y(point.reference[this.measure]);
      const cross = `M${x - 4} ${y - 4}l8 8M${x - 4} ${y + 4}l8 -8`;
      this.svg.append(svgEl("path", { class: "theirs", d: cross }));
    }
  }

  _dot(point, run, x, value) {
    const kind = ["run", severity(run), run.page ? "paged" : ""].filter(Boolean).join(" ");
    const place = { cx: x.toFixed(1), cy: this.y(value).toFixed(1), r: run.page ? 4 : 3.2 };
    const dot = svgEl("circle", { class: kind, ...place });
    const parts = [`${point.label}: ${short(value)}`, run.end, run.page ? "has a page" : ""];
    const said = visible(`seed ${run.seed}, ${parts.filter(Boolean).join("; ")}`);
    const role = { role: "button", tabindex: run.page ? 0 : -1, "aria-label": said };
    const group = svgEl("g", { class: "dot", ...role }, svgEl("title", {}, said), dot);
    group.addEventListener("click", () => this.choose(this.part, point, run));
    group.addEventListener("dblclick", () => run.page && location.assign(run.page));
    group.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") {
        event.preventDefault();
        this.choose(this.part, point, run);
      }
    });
    this.dots.set(run, dot);
    this.svg.append(group);
  }
}

/** The plots that are shown. */
const plots = [];

/** Show a run in the panel, and mark it in all plots. */
function chooseRun(part, point, run) {
  for (const plot of plots)
    for (const [one, dot] of plot.dots) dot.classList.toggle("chosen", one === run);
  const where = part.vary ? `${part.vary} = ${point.label}` : part.name;
  const numbers = Object.entries(part.measures)
    .filter(([name]) => Number.isFinite(run.numbers[name]))
    .map(([name, label]) => [el("dt", {}, label), el("dd", {}, short(run.numbers[name]))]);
  byId("h-run").textContent = visible(`Seed ${run.seed}, ${where}`);
  byId("run-body").replaceChildren(
    el("p", {}, run.end || "all tasks completed"),
    run.page
      ? el("p", {}, el("a", { href: run.page }, "Open the page of this run"))
      : el("div", {}, el("p.dim", {}, "This command writes a page of the run:"),
        el("pre", {}, run.command)),
    el("dl", {}, numbers));
  byId("run").hidden = false;
}

/** Return the table of a part: a row for each point. */
function tableOf(part) {
  const names = Object.entries(part.measures);
  const cell = (spread) => (spread ? `${short(spread[0])} ± ${short(spread[1])}` : "");
  const rows = part.points.map((point) => {
    const lost = point.runs.filter((run) => severity(run) === "lost").length;
    const some = point.runs.filter((run) => severity(run) === "some").length;
    const reasons = Object.entries(point.reasons).map(([why, count]) => `${count} × ${why}`);
    return el("tr", { title: visible(reasons.join("; ")) },
      el("th", { scope: "row" }, point.label),
      el("td", {}, `${point.runs.length} of ${point.wanted}`),
      el("td", {}, String(some)), el("td", {}, String(lost)),
      names.map(([name]) => el("td", {}, cell(point.spreads[name]))));
  });
  const ends = ["not all completed", "ended by the world"];
  const heads = [part.vary || "point", "runs", ...ends, ...names.map(([, label]) => label)];
  return el("div.scroll", {}, el("table", {},
    el("thead", {}, el("tr", {}, heads.map((one) => el("th", { scope: "col" }, one)))),
    el("tbody", {}, rows)));
}

/** Return the reasons for failed tasks of a part, the most frequent first. */
function reasonsOf(part) {
  const counts = new Map();
  for (const point of part.points)
    for (const [why, count] of Object.entries(point.reasons))
      counts.set(why, (counts.get(why) || 0) + count);
  const rows = [...counts].sort((one, other) => other[1] - one[1]).slice(0, 8);
  return rows.length ? el("details", {}, el("summary", {}, "Reasons for failed tasks"),
    el("ul", {}, rows.map(([why, count]) => el("li", {}, `${count} × ${why}`)))) : "";
}

function partOf(part) {
  const own = Object.keys(part.measures).map((name) => new Plot(part, name, chooseRun));
  plots.push(...own);
  const key = ["a dot is a run; a dot with a ring has a page",
    "the bar goes from the 10th to the 90th percentile, with the mean",
    "orange: not all tasks completed; red: ended by the world",
    part.reference ? `×: ${part.reference}` : ""];
  return el("section", {},
    el("h2", {}, `${part.title || part.name}${part.title ? ` (${part.name})` : ""}`),
    el("div.key", {}, key.map((one) => one && el("span", {}, one))),
    el("div.plots", {}, own.map((plot) => plot.element)),
    tableOf(part), reasonsOf(part));
}

async function showExperiment() {
  const data = JSON.parse(await embedded("experiment"));
  const runs = data.parts.flatMap((part) => part.points.flatMap((point) => point.runs));
  const bad = runs.filter((run) => run.end).length;
  byId("title").textContent = visible(data.title);
  document.title = visible(`${data.title} - rapc view`);
  byId("verdict").textContent = bad
    ? `${runs.length} runs, ${bad} of them did not complete all tasks`
    : `${runs.length} runs completed all tasks`;
  byId("parts").replaceChildren(...data.parts.map(partOf));
  byId("theme").addEventListener("click", switchTheme);
  document.documentElement.dataset.ready = String(Math.round(performance.now()));
}

showExperiment();
