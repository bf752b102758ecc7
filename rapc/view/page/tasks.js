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
    const made = el(
      "div.row",
      choosable("treeitem", task.number, selected, () => app.choose(task)),
      signOf(state.kind),
      oneLine(task.goal, el("span.dim", {}, ` [${task.number}] ${method}`),
        state.text ? el(`span.${state.kind === "failed" ? "failed" : "dim"}`, {}, ` ${state.text}`) : ""),
    );
    made.setAttribute("aria-level", depth + 1);
    made.style.paddingLeft = `${4 + depth * 14}px`;
    return made;
  });
  if (rows.length > MOST_TASKS)
    shown.push(el("p.dim", {}, `and ${rows.length - MOST_TASKS} more tasks`));
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

/** Show what is claimed and used, who waits for what, and what is under way. */
function showClaims(app) {
  const { run, at } = app;
  const now = run.timeOf(at);
  const since = (index) => el("span.age", {}, `since ${readable(run.timeOf(index))}`);
  const [held, waits, background] = [[], [], []];
  for (const { task } of run.treeAt(at, app.task)) {
    if (task.ended >= 0 && task.ended <= at) continue;
    const state = run.stateAt(task, at);
    const method = methodOf(app, state.method);
    for (const thing of asList(method && method.claims))
      held.push(taskRow(app, task, "active", asText(thing), since(state.method)));
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
    return taskRow(app, task, one.kind, one.request, since(one.start));
  });
  const heard = [];
  for (let index = run.startOfCycle(at); index <= at; index++) {
    const event = run.events[index];
    if (event.event === "signal" || event.event === "data-received")
      heard.push(eventRow(app, index, false));
  }
  const rows = [
    ...group("Claimed by methods", held),
    ...group("Waits for other tasks", waits),
    ...group("Requests and skills under way", acts),
    ...group("Signals and data of this cycle", heard),
    ...group("Other waits", background),
  ];
  if (!rows.length) rows.push(el("p.dim", {}, `nothing is held, awaited or under way at ${readable(now)}`));
  fill(byId("claims"), reachable(rows));
}
