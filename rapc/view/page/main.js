// The page: reads the data, holds the moment, and shows the panels.

/** The page with its runs and the present moment. */
class App {
  /**
   * @param runs the runs, one or two
   * @param mores what is known beside each trace
   * @param comparison the comparison of two runs; or null
   */
  constructor(runs, mores, comparison) {
    this.runs = runs;
    this.mores = mores;
    this.comparison = comparison;
    this.names = mores.map((more, index) => asText(more.name) || `run ${index + 1}`);
    this.pictures = runs.map((run, index) => new Pictures(changesOf(run, mores[index])));
    this.moments = runs.map((run) => run.last);
    this.current = 0;
    this.task = null;
    this.fact = "";
    this.place = "";
    this.drawing = new Drawing();
    this.colours = coloursOf(document.body);
    const end = Math.max(...runs.map((run) => run.timeOf(run.last)), 1e-9);
    const start = Math.min(...runs.map((run) => run.timeOf(0)));
    this.whole = { from: start, to: end > start ? end : start + 1 };
    this.view = { ...this.whole };
    this.timelines = runs.map((run, index) => new Timeline(this, index, this.view));
    byId("timeline").replaceChildren(...this.timelines.map((one) => one.element));
  }

  get run() {
    return this.runs[this.current];
  }

  get at() {
    return this.moments[this.current];
  }

  get more() {
    return this.mores[this.current];
  }

  get sources() {
    return this.more.sources || {};
  }

  get raps() {
    return this.more.raps || {};
  }

  get uses() {
    return this.mores[this.current].uses || {};
  }

  momentOf(index) {
    return this.moments[index];
  }

  // --- moving -----------------------------------------------------------------------

  /** Go to a moment of a run; the other run goes to the same time. */
  go(at, { task, fact, run = this.current } = {}) {
    if (this.current !== run || !byId("verdict").childElementCount) {
      this.current = run;
      byId("verdict").replaceChildren(...verdictOf(this));
      const symptoms = asList(this.mores[run].symptoms)
        .map((line) => symptomLine(this, asText(line)));
      byId("symptoms").replaceChildren(...symptoms);
      byId("symptoms").hidden = !symptoms.length;
    }
    this.moments[run] = Math.min(Math.max(at, 0), this.run.last);
    const time = this.run.timeOf(this.at);
    this.runs.forEach((one, index) => {
      if (index !== run) this.moments[index] = one.atTime(time);
    });
    if (task !== undefined) this.task = this.run.tasks.get(task) || null;
    else if (this.task && this.run.tasks.get(this.task.number) !== this.task)
      this.task = this.run.tasks.get(this.task.number) || null;
    if (fact !== undefined) this.fact = fact;
    this.place = "";
    this._keepInView(time);
    this.show();
  }

  /** Select a task; with `atEnd`, also go to its end. */
  choose(task, atEnd = false) {
    const ended = atEnd && task.ended >= 0;
    this.go(ended ? task.ended : Math.max(this.at, task.made), { task: task.number });
  }

  chooseFact(fact) {
    this.fact = fact;
    this.show();
  }

  showPlace(place) {
    this.place = place;
    showSource(this);
    byId("p-source").scrollIntoView({ block: "nearest" });
  }

  nextFailure(step) {
    const at = Run.next(this.run.failures, this.at, step);
    if (at >= 0) this.go(at, { task: this.run.events[at].task });
  }

  nextChange(step) {
    const at = Run.next(this.run.facts.get(this.fact) || [], this.at, step);
    if (at >= 0) this.go(at);
  }

  nextWrong(step) {
    const starts = [...new Set(this.run.beliefs.map((one) => one.n))].sort((a, b) => a - b);
    const at = Run.next(starts, this.at, step);
    if (at >= 0) this.go(at);
  }

  zoom(factor, middle = this.run.timeOf(this.at)) {
    const { from, to } = this.view;
    const least = (this.whole.to - this.whole.from) / 100000;
    const width = Math.min(Math.max((to - from) * factor, least), this.whole.to - this.whole.from);
    const part = (middle - from) / (to - from);
    const start = Math.min(Math.max(middle - part * width, this.whole.from), this.whole.to - width);
    Object.assign(this.view, { from: start, to: start + width });
    this.drawTimelines();
  }

  _keepInView(time) {
    const { from, to } = this.view;
    if (time >= from && time <= to) return;
    const width = to - from;
    const start = Math.min(Math.max(time - width / 2, this.whole.from), this.whole.to - width);
    Object.assign(this.view, { from: start, to: start + width });
  }

  // --- showing ----------------------------------------------------------------------

  drawTimelines() {
    for (const one of this.timelines) one.draw();
  }

  /** Show the moment in all panels. */
  show() {
    const begun = performance.now();
    const { run, at } = this;
    const event = run.events[at];
    byId("where").replaceChildren(
      el("span", {}, "time ", el("b", {}, readable(event.time)), 
        ` · cycle ${readable(event.cycle)} · event ${at}`));
    byId("previous").disabled = at === 0;
    byId("following").disabled = at === run.last;
    byId("next-failure").disabled = Run.next(run.failures, at, 1) < 0;
    byId("next-change").disabled = Run.next(run.facts.get(this.fact) || [], at, 1) < 0;
    this.timelines.forEach((one, index) => one.mark(index === this.current ? this.task : null));
    this.drawTimelines();
    showTasks(this);
    showClaims(this);
    showWhy(this);
    showSource(this);
    showMemory(this);
    showBeliefs(this);
    showEvents(this);
    showMap(this);
    for (const [index, one] of [...byId("runs").children].entries())
      one.setAttribute("aria-pressed", String(index === this.current));
    this._writeAddress();
    const root = document.documentElement;
    settle();
    void root.offsetHeight; // the layout counts
    Object.assign(root.dataset, { moment: at, redraw: (performance.now() - begun).toFixed(1) });
  }

  _writeAddress() {
    const parts = new URLSearchParams({ n: this.at });
    if (this.task) parts.set("task", this.task.number);
    if (this.fact) parts.set("fact", this.fact);
    if (this.current) parts.set("run", this.current);
    clearTimeout(this._written);
    this._written = setTimeout(() => history.replaceState(null, "", `#${parts}`), 150);
  }

  /** Go to the moment that the address names, or else to the first failure or the end. */
  open(address = location.href) {
    const parts = new URLSearchParams(new URL(address).hash.slice(1));
    const run = Number(parts.get("run")) === 1 && this.runs[1] ? 1 : 0;
    const at = Number(parts.get("n"));
    const fact = parts.get("fact") || "";
    this.current = run;
    if (parts.has("n") && Number.isInteger(at))
      this.go(at, { task: Number(parts.get("task")), fact, run });
    else this._openFirst(asList(this.comparison && this.comparison.first)[0]);
  }

  /** Go to the first different decision, the first failed task, or the first symptom. */
  _openFirst(different) {
    const { run } = this;
    if (Number.isInteger(different)) {
      this.go(different, { task: run.events[different].task });
      return;
    }
    const failed = run.firstFailed();
    const foreground = run.families.filter((task) => !task.background);
    const last = foreground.sort((one, other) => other.ended - one.ended)[0];
    const [symptom] = asList(this.mores[this.current].symptoms);
    const [, number] = /\[([0-9]+)\]/.exec(asText(symptom)) || [];
    const named = run.tasks.get(Number(number));
    const end = run.lastLive;
    if (failed) this.go(failed.ended, { task: failed.number });
    else if (named)
      this.go(named.ended < 0 ? end : Math.min(named.ended, end), { task: named.number });
    else this.go(end, last ? { task: last.number } : {});
  }

  /** Show what does not change with the moment. */
  begin() {
    const { run } = this;
    const { spec } = run;
    const library = lastPart(asText(spec.library)).replace(/^[.]+$/, "") || "library";
    const name = `${library} in ${asText(spec.world) || "no world"}`;
    byId("title").textContent = visible(name);
    byId("title").title = visible(`${name}, seed ${asText(spec.seed)}`);
    document.title = visible(`${name} - rapc view`);
    const notes = this.mores.map((more) => asText(more.note)).filter(Boolean);
    byId("note").hidden = !notes.length;
    byId("note").textContent = visible(notes.join("; "));
    const wrong = this.runs.some((one) => one.beliefs.length);
    const pictures = this.runs.some((one, index) => hasPlaces(one, this.pictures[index]));
    byId("p-beliefs").hidden = byId("next-wrong").hidden = !wrong;
    byId("p-map").hidden = !pictures;
    byId("panels").classList.toggle("beliefs", wrong);
    byId("panels").classList.toggle("map", pictures);
    byId("legend").replaceChildren(...legendOf(this.colours, wrong));
    byId("runs").hidden = this.runs.length < 2;
    byId("runs").replaceChildren(...this.names.map((one, index) => {
      const act = () => this.go(this.moments[index], { run: index });
      return el("button", { type: "button", click: act }, one);
    }));
    byId("comparison").hidden = !this.comparison;
    if (this.comparison) byId("compared").replaceChildren(...comparisonOf(this));
    byId("drop").hidden = true;
    byId("main").hidden = false;
  }
}

/** Return the first failed top-level tasks of a run, after a colon. */
function failuresOf(app) {
  const { run } = app;
  const failed = run.families.filter((task) => task.outcome === "failed");
  const parts = failed.slice(0, 3).flatMap((task, index) => {
    const result = asText(run.events[task.ended].result);
    const told = link(`${task.goal} (${result})`, () => app.choose(task, true));
    return [index ? ", " : ": ", told];
  });
  if (failed.length > 3) parts.push(`, and ${failed.length - 3} more`);
  return parts;
}

/** Return how the run ended and what failed, on one line. */
function verdictOf(app) {
  const { run } = app;
  const last = run.timeOf(run.last);
  const counts = new Map();
  for (const task of run.families)
    if (!task.background || task.outcome === "failed")
      counts.set(task.outcome || "unfinished", (counts.get(task.outcome || "unfinished") || 0) + 1);
  const parts = [];
  const reason = run.end ? asText(run.end.reason) : app.more.commands ? "under way" : "cut off";
  parts.push(el("b", {}, reason), ` at time ${readable(last)}`);
  if (run.end && run.end.because) parts.push(`: ${asText(run.end.because)}`);
  for (const kind of ["succeeded", "failed", "removed", "unfinished"]) {
    if (counts.get(kind)) parts.push(" · ", el(`span.${kind}`, {}, `${counts.get(kind)} ${kind}`));
    if (kind === "failed") parts.push(...failuresOf(app));
  }
  const bad = run.requests.filter((one) => one.result && one.result !== "okay").length;
  const requests = run.requests.filter((one) => !one.skill).length;
  const counted = [plural(run.events.length, "event")];
  if (requests) counted.unshift(`${plural(requests, "request")}, ${bad} not okay`);
  parts.push(el("span.dim", {}, ` · ${counted.join(" · ")}`));
  return parts;
}

/** Return a symptom of the run; its place and its tasks are links. */
function symptomLine(app, text) {
  const parts = text.split(/(\S+?:[0-9]+(?=[\s:,;]|$)|\[[0-9]+\])/);
  return el("p", {}, parts.map((part, index) => {
    if (index % 2 === 0) return part;
    const task = app.run.tasks.get(Number(part.slice(1, -1)));
    if (task) return link(part, () => app.choose(task, true), visible(task.goal));
    if (!sourceAt(app, part)) return part;
    return link(lastPart(part), () => app.showPlace(part), visible(part));
  }));
}

/** Return the comparison of the two runs: the first difference, and a table. */
function comparisonOf(app) {
  const { lines, notes, first } = app.comparison;
  const all = asList(app.comparison.rows).map(asList);
  const used = asList(app.comparison.columns).map((_, at) => all.some((row) => row[at]));
  const [columns, ...rows] = [asList(app.comparison.columns), ...all].map((row) =>
    row.filter((_, at) => used[at]));
  const shown = asList(lines).map((line) => el("div", {}, asText(line)));
  const links = asList(first).map((at, index) => Number.isInteger(at) && app.runs[index]
    ? el("button", {
      type: "button",
      click: () => app.go(at, { run: index, task: app.runs[index].events[at]?.task }),
    }, `Go to it in ${app.names[index]}`) : "");
  const cells = (name, row) => row.map((one, index) =>
    el(`${one ? name : "td"}${index > 1 ? ".num" : ""}`,
      name === "th" && one ? { scope: "col" } : {}, asText(one)));
  const table = rows.length
    ? el("table", {}, el("thead", {}, el("tr", {}, cells("th", columns))),
      el("tbody", {}, rows.map((row) => el("tr", {}, cells("td", row)))))
    : "";
  return [
    el("div", {}, el("div.code", {}, shown), el("p", {}, links)),
    el("div", {}, table, asList(notes).map((one) => el("p.dim", {}, asText(one)))),
  ];
}

/** Return the changes of the picture from an event on: those of the trace, or beside it. */
function changesOf(run, more, from = 0) {
  const recorded = [];
  for (let at = from; at < run.events.length; at++)
    if (run.events[at].event === "pictured") recorded.push([at, run.events[at].changed]);
  return recorded.length ? recorded : asList(more.pictures);
}

/** Whether there is something to draw: a picture, or a place in memory. */
function hasPlaces(run, pictures) {
  return pictures.size > 0 || [...run.facts.keys()].some((fact) => fact.startsWith("(location "));
}

/** Show the picture of the moment, or what memory believes. */
function showMap(app) {
  const { run, at } = app;
  const before = app.pictures[app.current].upTo(at, PATH + 1);
  const picture = before.pop() || null;
  const facts = [...run.memoryAt(at)].map(([fact, since]) => [fact, run.timeOf(since)]);
  const drawing = app.drawing;
  try {
    const drawn = drawing.draw(picture, { facts, now: run.timeOf(at), before });
    if (!drawn) byId("map").replaceChildren("no place is known");
    else if (!drawing.svg.isConnected) byId("map").replaceChildren(drawing.svg);
    if (drawing.isWide) byId("panels").classList.add("wide"); // and stays: no panel jumps
  } catch (error) {
    byId("map").textContent = visible(`cannot draw the picture: ${error.message}`);
  }
}

// --- searching and keys ---------------------------------------------------------------

let app = null;

/** Show what the search has found. */
function showFound() {
  const text = byId("search").value.trim();
  const list = byId("found");
  const found = app && text ? app.run.find(text) : [];
  list.replaceChildren(...found.map((one, index) =>
    el("li", {
      role: "option", id: `found-${index}`, "aria-selected": String(index === 0),
      click: () => goFound(one),
    },
    el("span.kind", {}, one.kind),
    el("span.name", {}, one.name),
    el("span.dim", {}, readable(app.run.timeOf(one.at))))));
  if (text && !found.length) list.append(el("li.dim", {}, "nothing found"));
  list.found = found;
  list.hidden = !text;
  byId("search").setAttribute("aria-expanded", String(!list.hidden));
  chooseFound(0);
}

function chooseFound(index) {
  const rows = [...byId("found").querySelectorAll("[role=option]")];
  rows.forEach((row, at) => row.setAttribute("aria-selected", String(at === index)));
  if (!rows[index]) return byId("search").removeAttribute("aria-activedescendant");
  byId("search").setAttribute("aria-activedescendant", rows[index].id);
  reveal(byId("found"), rows[index]);
}

function goFound(one) {
  closeFound();
  byId("search").blur();
  const at = one.kind === "failed" ? one.task.ended : one.at;
  app.go(at, {
    ...(one.task ? { task: one.task.number } : {}),
    ...(one.kind === "fact" ? { fact: one.name } : {}),
  });
}

function closeFound() {
  byId("found").hidden = true;
  byId("search").setAttribute("aria-expanded", "false");
}

function searchKey(event) {
  const list = byId("found");
  const rows = list.found || [];
  const at = [...list.children].findIndex((row) => row.getAttribute("aria-selected") === "true");
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (step && rows.length) {
    event.preventDefault();
    chooseFound((at + step + rows.length) % rows.length);
  } else if (event.key === "Enter" && rows[at] && !list.hidden) {
    event.preventDefault();
    goFound(rows[at]);
  } else if (event.key === "Escape") {
    closeFound();
    byId("search").blur();
  }
}

/** The actions of the keys. */
const KEYS = {
  ArrowRight: () => app.go(app.run.cycleFrom(app.at, 1)),
  ArrowLeft: () => app.go(app.run.cycleFrom(app.at, -1)),
  Home: () => app.go(0),
  End: () => app.go(app.run.last),
  n: () => app.nextFailure(1),
  N: () => app.nextFailure(-1),
  c: () => app.nextChange(1),
  C: () => app.nextChange(-1),
  b: () => app.nextWrong(1),
  B: () => app.nextWrong(-1),
  "+": () => app.zoom(0.5),
  "=": () => app.zoom(0.5),
  "-": () => app.zoom(2),
  0: () => app.zoom(Infinity),
  "/": () => byId("search").focus(),
  "?": () => byId("help").showModal(),
};

function pressed(event) {
  if (!app || event.ctrlKey || event.metaKey || event.altKey) return;
  const { target } = event;
  if (event.key === "Escape" && target.matches("input, select")) target.blur();
  if (target.closest("input, select, dialog[open]") && target.type !== "checkbox") return;
  if (event.shiftKey && event.key.startsWith("Arrow")) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step) app.go(app.at + step);
    return;
  }
  if (!Object.hasOwn(KEYS, event.key)) return;
  event.preventDefault();
  KEYS[event.key]();
}

/** Show runs in the page. */
function start(runs, mores, comparison) {
  byId("panels").classList.remove("wide");
  app = new App(runs, mores, comparison);
  app.begin();
  app.open();
  const root = document.documentElement;
  root.dataset.events = app.run.events.length;
  root.dataset.ready = Math.round(performance.now());
}

/** Read a trace that the reader has chosen or dropped. */
async function readFile(file) {
  try {
    const text = await inflated(new Uint8Array(await file.arrayBuffer()));
    const { events, note } = readTrace(text);
    const more = { name: file.name, note, sensors: sensorsOf(events) };
    history.replaceState(null, "", location.pathname + location.search);
    start([new Run(events, more)], [more], null);
  } catch (error) {
    byId("wrong").textContent = visible(`cannot read ${file.name}: ${error.message}`);
  }
}

/** The sensors of each world, by its name. */
let worlds = {};

function sensorsOf(events) {
  const world = asText(events[0].spec && events[0].spec.world);
  return Object.hasOwn(worlds, world) ? worlds[world] : [];
}

function wire() {
  document.addEventListener("keydown", pressed);
  byId("previous").addEventListener("click", KEYS.ArrowLeft);
  byId("following").addEventListener("click", KEYS.ArrowRight);
  byId("next-failure").addEventListener("click", KEYS.n);
  byId("next-change").addEventListener("click", KEYS.c);
  byId("next-wrong").addEventListener("click", KEYS.b);
  byId("help-button").addEventListener("click", KEYS["?"]);
  byId("search").addEventListener("input", showFound);
  byId("search").addEventListener("focus", showFound);
  byId("search").addEventListener("keydown", searchKey);
  document.addEventListener("pointerdown", (event) => {
    if (!event.target.closest(".find")) closeFound();
  });
  byId("filter").addEventListener("input", () => showMemory(app));
  byId("own").addEventListener("change", () => showEvents(app));
  for (const id of ["tasks", "claims", "memory", "beliefs", "events"]) moveWithArrows(byId(id));
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const recolour = () => {
    if (!app) return;
    app.colours = coloursOf(document.body);
    const wrong = app.runs.some((one) => one.beliefs.length);
    byId("legend").replaceChildren(...legendOf(app.colours, wrong));
    app.drawTimelines();
  };
  byId("theme").addEventListener("click", () => {
    switchTheme();
    recolour();
  });
  dark.addEventListener("change", recolour);
  window.addEventListener("hashchange", (event) => app && app.open(event.newURL));
  byId("file").addEventListener("change", (event) => {
    const [file] = event.target.files;
    if (file) readFile(file).finally(() => (byId("file").value = "")); // the same file again
  });
  for (const kind of ["dragover", "dragleave", "drop"])
    document.addEventListener(kind, (event) => {
      if (byId("drop").dataset.always === undefined) return;
      event.preventDefault();
      document.body.classList.toggle("over", kind === "dragover");
      if (kind === "drop" && event.dataTransfer.files[0]) readFile(event.dataTransfer.files[0]);
    });
}

async function main() {
  wire();
  worlds = JSON.parse((await embedded("worlds")) || "{}");
  const live = await embedded("live");
  if (live !== null) {
    follow(JSON.parse(live));
    return;
  }
  const runs = [];
  const mores = [];
  let text;
  while ((text = await embedded(`trace-${runs.length}`)) !== null) {
    const more = JSON.parse((await embedded(`more-${runs.length}`)) || "{}");
    const { events, note } = readTrace(text);
    more.note = [more.note, note].filter(Boolean).join("; ");
    mores.push(more);
    runs.push(new Run(events, more));
  }
  if (runs.length) start(runs, mores, JSON.parse((await embedded("comparison")) || "null"));
  else {
    byId("drop").hidden = false;
    byId("drop").dataset.always = "";
    document.documentElement.dataset.ready = String(Math.round(performance.now()));
  }
}

main().catch((error) => {
  byId("drop").hidden = false;
  byId("wrong").textContent = visible(`cannot show the run: ${error.message}`);
});
