// The tasks of a moment: the tree, and the claims, waits, requests and skills.

const MOST_TASKS = 600;

/** Return the name of the method that a task has under way, or an empty text. */
function methodName(run, state) {
  return state.method < 0 ? "" : asText(run.events[state.method].method);
}

/** Show the tree of tasks. */
function showTasks(app) {
  const { run, at, task: chosen } = app;
  const rows = run.treeAt(at, chosen);
  const shown = rows.slice(0, MOST_TASKS).map(({ task, depth }) => {
    const state = run.stateAt(task, at);
    const method = methodName(run, state);
    const selected = task === chosen;
    const told = ` ${state.text}`;
    const made = el(
      "div.row",
      choosable("treeitem", task.number, selected, () => app.choose(task)),
      signOf(state.kind),
      oneLine(task.goal, el("span.dim", {}, ` [${task.number}] ${method}`),
        state.text ? el(state.kind === "failed" ? "span.failed" : "span.dim", {}, told) : ""),
    );
    made.setAttribute("aria-level", depth + 1);
    made.style.paddingLeft = `${4 + depth * 14}px`;
    return made;
  });
  if (rows.length > MOST_TASKS)
    shown.push(el("p.dim", {}, `and ${plural(rows.length - MOST_TASKS, "more task")}`));
  if (!rows.length) shown.push(el("p.dim", {}, "no task at this moment"));
  const body = byId("tasks");
  fill(body, reachable(shown));
  reveal(body, body.querySelector('[aria-selected="true"]'));
}

/** Return a list of rows under a heading; nothing without rows. */
function group(title, rows) {
  return rows.length ? [el("h3", {}, title), ...rows] : [];
}

/** Return a row about a task that can be chosen. */
function taskRow(app, task, kind, text, more) {
  return el(
    "div.row",
    choosable("button", `${kind}${task.number}${text}`, false, () => app.choose(task)),
    signOf(kind),
    oneLine(text, el("span.dim", {}, ` [${task.number}] ${task.goal}`)),
    more,
  );
}

/** Return a text of the library with the values of its variables. */
function withValues(text, values) {
  const known = values && typeof values === "object" ? values : {};
  return text.replace(/\?[^\s()?]+/g, (name) =>
    Object.hasOwn(known, name) ? asText(known[name]) : name);
}

/** Return the things that a request or skill uses while it is under way. */
function usedBy(app, request) {
  const [name, ...given] = wordsOf(request) || [];
  const declared = Object.hasOwn(app.uses, name) ? app.uses[name] : { args: [], things: [] };
  const values = Object.fromEntries(declared.args.map((one, index) => [one, given[index]]));
  return declared.things.map((thing) => withValues(thing, values));
}

/** Show what is claimed and used, who waits for what, and what is under way. */
function showClaims(app) {
  const { run, at } = app;
  const now = run.timeOf(at);
  const since = (index) => el("span.age", {}, `since ${readable(run.timeOf(index))}`);
  const [held, waits, background] = [[], [], []];
  const claimRow = (thing, task, chosen) => {
    const other = taken.find((one) => one.for === thing && one.above.includes(task));
    const text = other ? `${thing}, taken by [${asText(other.by)}]` : thing;
    return taskRow(app, task, other ? "suspended" : "active", text, since(chosen));
  };
  const live = run.treeAt(at, app.task).map(({ task }) => task)
    .filter((task) => task.ended < 0 || task.ended > at);
  const taken = live.map((task) => [task, run.stateAt(task, at)])
    .filter(([, state]) => state.kind === "suspended")
    .map(([task, state]) => ({ above: run.ancestors(task), ...run.events[state.wait] }));
  for (const task of live) {
    const state = run.stateAt(task, at);
    const method = methodOf(app, state.method);
    const values = state.method < 0 ? {} : run.events[state.method].bindings;
    for (const thing of asList(method && method.claims))
      held.push(claimRow(withValues(asText(thing), values), task, state.method));
    if (state.wait < 0) continue;
    const event = run.events[state.wait];
    const holder = run.tasks.get(event.holder) || run.tasks.get(event.by);
    const what = asText(event.on) || `${asText(event.for)}, taken`;
    const text = holder ? `${what}, held by [${holder.number}] ${holder.goal}` : what;
    const row = taskRow(app, task, state.kind, text, since(state.wait));
    (holder ? waits : background).push(row);
  }
  const acts = run.underWay(at).map((one) => {
    const task = run.tasks.get(one.task);
    for (const thing of usedBy(app, one.request))
      held.push(taskRow(app, task, one.kind, `${thing}, used`, since(one.start)));
    return taskRow(app, task, one.kind, one.request, since(one.start));
  });
  const heard = [];
  for (let index = run.startOfCycle(at); index <= at; index++) {
    const event = run.events[index];
    if (event.event === "signal" || event.event === "data-received")
      heard.push(eventRow(app, index, false));
  }
  const rows = [
    ...group("Things that are claimed or used", held),
    ...group("Waits for other tasks", waits),
    ...group("Requests and skills under way", acts),
    ...group("Signals and data of this cycle",
      heard.length ? [listbox("Signals and data of this cycle", heard)] : []),
    ...group("Other waits", background),
  ];
  const none = `nothing is held, awaited or under way at ${readable(now)}`;
  if (!rows.length) rows.push(el("p.dim", {}, none));
  fill(byId("claims"), rows);
  reachable([...byId("claims").querySelectorAll("[data-key]")]);
}
