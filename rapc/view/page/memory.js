// Memory of a moment, with ages and what has just changed; the history of a fact; belief
// beside truth.

/** The highest numbers of rows: of a group of facts, and of changes of a cycle. */
const MOST_FACTS = 300, MOST_CHANGES = 40;

/** The groups of facts that the reader has opened. */
const opened = new Set();

/** The predicate of each fact that has been shown. */
const predicates = new Map();

function predicateOf(fact) {
  let name = predicates.get(fact);
  if (name === undefined) predicates.set(fact, (name = firstWord(fact)));
  return name;
}

/** Return the row of a fact. */
function factRow(app, fact, since, change) {
  const { run, at } = app;
  const selected = fact === app.fact;
  const event = change === undefined ? null : run.events[change];
  const sign = !event ? "" : event.event === "fact-erased" ? "−"
    : erasedBefore(run, fact, change) ? "+" : "~";
  const words = { "+": "new", "~": "asserted again", "−": "erased" }[sign] || "";
  const now = run.timeOf(at);
  return el(
    sign === "−" ? "div.row.erased" : "div.row",
    {
      ...choosable("option", fact, selected, () => app.chooseFact(selected ? "" : fact)),
      title: words,
    },
    el("span.sign", { "aria-label": words }, sign),
    el("span.text", {}, fact),
    el("span.age", {}, since === undefined ? "" : ageText(now, run.timeOf(since))),
  );
}

/** Return whether a fact was absent from memory before one of its changes. */
function erasedBefore(run, fact, change) {
  const before = Run.next(run.facts.get(fact), change, -1);
  return before < 0 || run.events[before].event === "fact-erased";
}

/** Return the changes of the selected fact around the moment. */
function factHistory(app) {
  const { run, at, fact } = app;
  const changes = run.facts.get(fact);
  if (!fact || !changes) return [];
  const here = search(changes.length, (index) => changes[index] > at);
  const rows = changes.slice(Math.max(here - 6, 0), here + 4).map((change) => {
    const event = run.events[change];
    const source = run.sourceOf(change);
    return el("div.row", {
      ...choosable("option", `h${change}`, change === changes[here - 1], () => app.go(change, {})),
    },
    el("span.t", {}, readable(event.time)),
    oneLine(event.event === "fact-erased" ? "− erased" : "+ asserted",
      el("span.dim", {}, ` by ${source.text}`), ...[placeLink(app, source.place)].flat()));
  });
  const title = `${fact}: ${plural(changes.length, "change")}`;
  return [el("h3", {}, title), listbox(title, reachable(rows))];
}

/** Return the facts that have changed in the cycle of the moment. */
function changedRows(app, memory, changed) {
  if (!changed.length) return [];
  const title = "Changed in this cycle";
  const shown = changed.slice(0, MOST_CHANGES).map(([fact, change]) =>
    factRow(app, fact, memory.get(fact), change));
  const rows = [el("h3", {}, title), listbox(title, reachable(shown))];
  if (changed.length > MOST_CHANGES)
    rows.push(el("p.dim", {}, `and ${changed.length - MOST_CHANGES} more`));
  return rows;
}

/** Return facts by predicate; only those with a text, if there is one. */
function factGroups(memory, wanted) {
  const groups = new Map();
  for (const [fact, since] of memory) {
    if (wanted && !fact.toLowerCase().includes(wanted)) continue;
    const name = predicateOf(fact);
    const known = groups.get(name);
    if (known) known.push([fact, since]);
    else groups.set(name, [[fact, since]]);
  }
  return groups;
}

/**
 * Return the facts of a predicate as a group that can be opened.
 *
 * @param build returns the rows of the group; called when the reader opens it
 * @param always whether the group is open, and the reader's choice is not kept
 */
function factGroup(name, count, build, always) {
  const list = listbox(name, []);
  const show = () => list.replaceChildren(...reachable(build()));
  const toggle = (event) => {
    if (always) return;
    if (event.target.open) opened.add(name);
    else opened.delete(name);
    if (event.target.open && !list.childElementCount) show();
  };
  const open = always || opened.has(name);
  if (open) show();
  return el("details", { open, toggle },
    el("summary", { "data-key": `g${name}` }, name, el("span.count", {}, ` ${count}`)), list);
}

/** Show memory. */
function showMemory(app) {
  const { run, at } = app;
  const memory = run.memoryAt(at);
  const changed = run.changesAt(at);
  const wanted = byId("filter").value.toLowerCase();
  const now = [...changed].filter(([fact]) => fact.toLowerCase().includes(wanted));
  const groups = factGroups(memory, wanted);
  const found = [...groups.values()].reduce((sum, one) => sum + one.length, 0);
  const always = wanted && found <= MOST_FACTS;
  const details = [...groups.keys()].sort().map((name) => {
    const facts = groups.get(name);
    const build = () => {
      const made = facts.slice(0, MOST_FACTS).map(([fact, since]) =>
        factRow(app, fact, since, changed.get(fact)));
      if (facts.length > MOST_FACTS)
        made.push(el("p.dim", {}, `and ${facts.length - MOST_FACTS} more; use the filter`));
      return made;
    };
    return factGroup(name, facts.length, build, always);
  });
  const all = el("h3", {}, `All facts: ${memory.size}`);
  fill(byId("memory"), [
    ...factHistory(app), ...changedRows(app, memory, now), all, ...details,
  ]);
}

/** Show the wrong beliefs of the moment, and the next. */
function showBeliefs(app) {
  const { run, at } = app;
  if (!run.beliefs.length) return;
  const present = run.beliefs.filter((one) => one.n <= at && !(one.end !== null && one.end <= at));
  const rows = present.map((one) =>
    el("div", {},
      factLine(app, asText(one.fact), at, null),
      el("div.code", {}, el("span.dim", {}, "truth: "),
        asList(one.truth).map(asText).join(" or ") || "not so"),
      el("div.dim", {}, "wrong since ",
        link(readable(run.timeOf(one.n)), () => app.go(one.n, {})))));
  if (!rows.length) rows.push(el("p", {}, "Every compared belief is true at this moment."));
  const before = search(run.beliefs.length, (index) => run.beliefs[index].n > at);
  const first = Math.max(Math.min(before - 4, run.beliefs.length - 8), 0);
  const time = (index) => readable(run.timeOf(index));
  rows.push(el("h3", {}, `Wrong beliefs of the run: ${run.beliefs.length}`));
  const moments = run.beliefs.slice(first, first + 8).map((one) => el("div.row", {
    ...choosable("option", `w${one.n}${asText(one.fact)}`, present.includes(one), () =>
      app.go(one.n, { fact: asText(one.fact) })),
  },
  el("span.t", {}, time(one.n)), oneLine(asText(one.fact)),
  el("span.age", {}, one.end === null ? "until the end" : `until ${time(one.end)}`)));
  rows.push(listbox("Wrong beliefs of the run", reachable(moments)));
  fill(byId("beliefs"), rows);
}
