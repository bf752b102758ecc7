// Why a task is as it is: its purpose, method, waits, and the cause of its failure down
// to the first cause; and the source of its RAP.

/** Return what the page knows of a choice of a method, by the index of its event; or null. */
function methodOf(app, chosen) {
  const event = chosen < 0 ? null : app.run.events[chosen];
  const rap = event && Object.hasOwn(app.raps, asText(event.rap)) && app.raps[asText(event.rap)];
  const name = event && asText(event.method);
  return rap && Object.hasOwn(rap.methods, name) ? rap.methods[name] : null;
}

/** Return a place of a file, `FILE:LINE`, as a link if its source is there. */
function placeLink(app, place) {
  const text = asText(place);
  if (!text) return "";
  const short = lastPart(text);
  if (!sourceAt(app, text)) return el("span.dim", { title: visible(text) }, ` ${short}`);
  return [" ", link(short, () => app.showPlace(text), visible(text))];
}

/** Return the file and the line of a place in a source of the page; or null. */
function sourceAt(app, place) {
  const found = /^(.*?):([0-9]+)(?::[0-9]+)?$/.exec(place);
  if (!found) return null;
  const names = Object.keys(app.sources);
  const end = `/${found[1]}`;
  const name =
    names.find((one) => one === found[1]) ||
    names.find((one) => `/${one.replaceAll("\\", "/")}`.endsWith(end)) ||
    names.find((one) => end.endsWith(`/${one.replaceAll("\\", "/")}`));
  return name === undefined ? null : { file: name, row: Number(found[2]) };
}

/** Return the variables of bindings with their values. */
function bindingsLine(bindings) {
  const pairs = bindings && typeof bindings === "object" ? Object.entries(bindings) : [];
  if (!pairs.length) return "";
  return el("div.bindings", {}, pairs.slice(0, 100).map(([name, value]) =>
    [el("span", {}, el("span.dim", {}, name), ` ${asText(value)}`), " "]).flat());
}

/** Return a fact that can be selected, with the source of its last change. */
function factLine(app, fact, before, age) {
  const { run } = app;
  const changes = run.facts.get(fact) || [];
  const at = Run.next(changes, before + 1, -1);
  const told = [link(fact, () => app.chooseFact(fact), "Select this fact")];
  if (Number.isFinite(age)) told.push(el("span.dim", {}, `, ${readable(age)} old`));
  if (at >= 0) {
    const source = run.sourceOf(at);
    const verb = run.events[at].event === "fact-erased" ? "erased" : "asserted";
    told.push(
      el("span.dim", {}, ` ${verb} at `),
      link(readable(run.timeOf(at)), () => app.go(at, { fact }), "Go to this moment"),
      el("span.dim", {}, ` by ${source.text}`),
      ...[placeLink(app, source.place)].flat(),
    );
  }
  return el("div.code", {}, told);
}

/** Return the lines of one cause, without the cause below it. */
function causeLines(app, cause, before, depth = 0) {
  if (!cause || typeof cause !== "object" || depth > 20) return [];
  const lines = [el("div", {}, asText(cause.clause), ...[placeLink(app, cause.place)].flat())];
  if (cause.part) lines.push(el("code.part", {}, asText(cause.part)));
  const facts = asList(cause.facts).slice(0, 20);
  const note = asText(cause.note) || (cause.part ? "does not hold" : "");
  if (note || facts.length)
    lines.push(el("div.dim", {}, note + (facts.length ? "; memory has:" : "")));
  for (const fact of facts)
    if (fact && typeof fact === "object")
      lines.push(factLine(app, asText(fact.fact), before, fact.age));
  lines.push(bindingsLine(cause.bindings));
  const task = app.run.tasks.get(cause.task);
  if (task) lines.push(link(`[${task.number}] ${task.goal}`, () => app.choose(task, true)));
  const inside = (list) => asList(list).slice(0, 20).map((one) =>
    el("div.inside", {}, causeLines(app, one, before, depth + 1)));
  lines.push(...inside(cause.inside));
  const methods = inside(cause.methods);
  if (methods.length)
    lines.push(el("details", { open: depth === 0 },
      el("summary", {}, `methods that were excluded: ${methods.length}`), methods));
  return lines;
}

/** Return the chain of causes of a failure; the first cause comes last, and on top. */
function causeChain(app, because, task, at) {
  const causes = causesOf(because);
  const rows = causes.map((cause) => {
    const left = Number.isInteger(cause.skipped) && cause.skipped > 0;
    return el("li", {}, causeLines(app, cause, at),
      left ? el("div.dim", {}, `${cause.skipped} causes left out`) : "");
  });
  const deepest = causes.reduceRight((found, one) => found || app.run.tasks.get(one.task), null);
  const bad = app.run.badRequest(deepest || task, at);
  const answer = () => ["the world answered ",
    link(`${bad.request} - ${bad.result}`, () => app.go(bad.stop, { task: bad.task })),
    el("span.dim", {}, ` at ${readable(app.run.timeOf(bad.stop))}`)];
  if (bad) rows.push(el("li", {}, answer()));
  if (!rows.length) return [];
  rows[rows.length - 1].classList.add("first");
  rows[rows.length - 1].prepend(el("div.label", {}, "first cause"));
  const last = causes[causes.length - 1];
  const short = bad ? answer()
    : [asText(last.clause), ...[placeLink(app, last.place)].flat(), " ",
      el("code", {}, asText(last.part)), ` ${asText(last.note) || "does not hold"}`];
  const summary = rows.length > 1 ? el("p.summary", {}, el("b", {}, "First cause: "), short) : "";
  return [summary, el("h3", {}, "Causes, the nearest first"), el("ol.chain", {}, rows)];
}

/** Return the description of the state of a task. */
function stateLines(app, task, state) {
  const { run, at } = app;
  const [, words] = SIGNS[state.kind];
  const until = task.ended >= 0 && task.ended <= at ? task.ended : -1;
  const time = (index) => readable(run.timeOf(index));
  const life = until < 0 ? `since ${time(task.made)}` : `${time(task.made)} to ${time(until)}`;
  const event = until < 0 ? {} : run.events[until];
  const told = new Set([words, asText(event.reason), asText(event.result || event.cause)]);
  const lines = [
    el("div.goal", {}, signOf(state.kind), ` ${task.goal} `,
      el("span.dim", {}, `[${task.number}]`)),
    el("div", {}, el(`b.${state.kind}`, {}, [...told].filter(Boolean).join(", ")),
      until < 0 && state.text ? `: ${state.text}` : "", el("span.dim", {}, ` · ${life}`)),
  ];
  if (until < 0 && task.ended >= 0) {
    const end = () => app.go(task.ended, { task: task.number });
    lines.push(el("div.dim", {}, "later: ", link(`${task.outcome} at ${time(task.ended)}`, end)));
  }
  return lines;
}

/** Show why the selected task is as it is. */
function showWhy(app) {
  const { run, at, task } = app;
  const body = byId("why");
  if (!task) {
    const told = "Select a task to see its purpose, method and causes.";
    fill(body, [el("p.dim", {}, told), ...runEnd(app)]);
    return;
  }
  const state = run.stateAt(task, at);
  const lines = stateLines(app, task, state);
  const above = run.ancestors(task);
  if (above.length) {
    const chain = above.flatMap((one, index) => [
      index ? " ← " : "",
      link(one.goal, () => app.choose(one), `task ${one.number}`),
    ]);
    const step = task.step ? `step ${task.step} of ` : "";
    lines.push(el("div", {}, el("span.dim", {}, `for ${step}`), chain), ...stepLines(app, task));
  }
  const end = task.ended >= 0 && task.ended <= at ? run.events[task.ended] : null;
  if (end && end.event === "task-failed") lines.push(...causeChain(app, end.because, task, at));
  lines.push(...wokenLines(app, task));
  if (state.method >= 0) {
    const event = run.events[state.method];
    lines.push(el("h3", {}, `Method ${asText(event.method)}`), bindingsLine(event.bindings));
  }
  lines.push(...planLines(app, task));
  if (state.wait >= 0) {
    const event = run.events[state.wait];
    const holder = run.tasks.get(event.holder) || run.tasks.get(event.by);
    const [since, now] = [run.timeOf(state.wait), run.timeOf(at)];
    lines.push(el("h3", {}, state.kind === "suspended" ? "Suspended" : "Waits"),
      el("div.code", {}, asText(event.on) || asText(event.for)),
      el("div.dim", {}, `since ${readable(since)}, ${readable(now - since)} time units`));
    if (holder) lines.push(el("div", {}, "held by ", taskLink(app, holder)));
  }
  lines.push(...triesLines(app, task));
  fill(body, lines.filter(Boolean));
}

/** Return a link that selects a task. */
function taskLink(app, task) {
  return link(`[${task.number}] ${task.goal}`, () => app.choose(task));
}

/** Return what woke a task last, if it was blocked before. */
function wokenLines(app, task) {
  const { run, at } = app;
  const woken = run.logOf(task, at).findLast((index) => run.events[index].event === "task-woken");
  if (woken === undefined) return [];
  const { on, holder } = run.events[woken];
  const held = run.tasks.get(holder);
  return [el("div", {}, el("span.dim", {}, "woken at "),
    link(readable(run.timeOf(woken)), () => app.go(woken, {}), "Go to this moment"),
    el("span.dim", {}, " by "), el("code", {}, asText(on)),
    held ? [", which ", taskLink(app, held), " held"] : "")];
}

/** Return the methods that a task has tried, with their ends. */
function triesLines(app, task) {
  const { run, at } = app;
  const tries = run.triesOf(task, at);
  if (!tries.length) return [];
  const rows = tries.slice(-30).map(({ chosen, ended }) => {
    const event = run.events[chosen];
    const end = ended < 0 ? null : run.events[ended];
    const result = end
      ? end.event === "method-suspended" ? `suspended by [${asText(end.by)}]` : asText(end.result)
      : "under way or ended with its task";
    return el("li", {},
      link(readable(run.timeOf(chosen)), () => app.go(chosen, {}), "Go to this moment"),
      ` ${asText(event.method)}: `,
      el(end && end.result !== "okay" ? "span.failed" : "span", {}, result),
      end && end.because ? el("div.inside", {}, causesOf(end.because).slice(0, 1).map((one) =>
        causeLines(app, one, ended))) : "");
  });
  return [el("h3", {}, `Methods tried: ${tries.length}`), el("ul", {}, rows)];
}

/** Return why the run ended, and what was left. */
function runEnd(app) {
  const { end } = app.run;
  const waiting = asList(end && end.waiting).slice(0, 50);
  if (!waiting.length) return [];
  return [el("h3", {}, "Left at the end"), el("ul", {}, waiting.map((one) =>
    el("li.code", {}, asText(one))))];
}

/** Show the source: of a chosen place, or of the RAP of the selected task. */
function showSource(app) {
  const { run, at, task } = app;
  const body = byId("source");
  const end = task && task.ended >= 0 && task.ended <= at ? run.events[task.ended] : {};
  const tries = task ? run.triesOf(task, at) : [];
  const chosen = tries.length ? tries[tries.length - 1].chosen : -1;
  const name = chosen >= 0 ? asText(run.events[chosen].rap) : task ? firstWord(task.goal) : "";
  const rap = Object.hasOwn(app.raps, name) ? app.raps[name] : null;
  const method = methodOf(app, chosen);
  let place = sourceAt(app, app.place || asText(end.because && end.because.place));
  const home = method && rap.file !== method.file ? method : rap;
  if (place && !app.place && !(home && inRows(place, home))) place = null;
  const shown = place && !(home && inRows(place, home))
    ? { file: place.file, rows: [Math.max(place.row - 15, 1), place.row + 15] } : home;
  if (!shown || !Object.hasOwn(app.sources, shown.file)) {
    const told = Object.keys(app.sources).length
      ? "Select a task to see the source of its RAP."
      : "The page has no source: make it with rapc view where the library is.";
    byId("source-of").textContent = "";
    fill(body, [el("p.dim", {}, told)]);
    return;
  }
  byId("source-of").textContent = visible(` ${lastPart(shown.file)}`);
  byId("source-of").title = visible(shown.file);
  const lines = asText(app.sources[shown.file]).split("\n");
  const steps = stepsUnderWay(app, method);
  const rows = [];
  const last = Math.min(shown.rows[1], lines.length, shown.rows[0] + 400);
  for (let row = shown.rows[0]; row <= last; row++) {
    const here = { file: shown.file, row };
    const marks = [];
    if (method && inRows(here, method)) marks.push("method");
    if (steps.some((one) => inRows(here, { file: method.file, rows: one }))) marks.push("step");
    if (place && row === place.row) marks.push("place");
    rows.push(el(["li", ...marks].join("."), marks.length ? { "aria-current": "true" } : {},
      el("span.n", {}, row), el("span", {}, lines[row - 1] || " ")));
  }
  const list = el("ol", {}, rows);
  body.replaceChildren(list);
  body.scrollTop = 0;
  const marked = [".place", ".step", ".method"].map((one) => list.querySelector(one));
  reveal(body, marked.find(Boolean));
}

function inRows(place, { file, rows }) {
  return place.file === file && place.row >= rows[0] && place.row <= rows[1];
}

/** Return the rows of the steps of the selected task's method that are under way. */
function stepsUnderWay(app, method) {
  const { run, at, task } = app;
  if (!method) return [];
  return run.treeAt(at, task)
    .filter((one) => one.task.parent === task && Object.hasOwn(method.steps, one.task.step))
    .map((one) => method.steps[one.task.step]);
}
