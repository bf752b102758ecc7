// The plan of a task: its steps with their states, and the facts that link them.

/** Return the lines about the plan of a task; none without a plan. */
function planLines(app, task) {
  const plan = app.run.planOf(task, app.at);
  if (!plan) return [];
  const made = link(readable(app.run.timeOf(plan.made)), () => app.go(plan.made, {}),
    "Go to this moment");
  const rows = plan.steps.map((step) => {
    const state = step.task ? app.run.stateAt(step.task, app.at) : { kind: "new" };
    const goal = step.task ? link(step.goal, () => app.choose(step.task)) : step.goal;
    return el("li.planned", {}, signOf(state.kind), ` ${step.tag} `, goal,
      purposeLines(app, step));
  });
  return [el("h3", {}, "Plan, made at ", made), el("ul.plan", {}, rows)];
}

/** Return what a step of a plan is for. */
function purposeLines(app, step) {
  const lines = step.links.map((one) => el("div.inside", {},
    el("span.dim", {}, `for ${one.step || "the goal"}: `),
    app.run.facts.has(one.fact)
      ? link(one.fact, () => app.chooseFact(one.fact), "Select this fact")
      : one.fact));
  if (step.before.length)
    lines.push(el("div.inside.dim", {}, `before ${step.before.join(", ")}`));
  return lines;
}

/** Return what a task is for as a step of a plan; nothing for another task. */
function stepLines(app, task) {
  const plan = task.parent && app.run.planOf(task.parent, app.at);
  const step = plan && plan.steps.find((one) => one.task === task);
  return step ? purposeLines(app, step) : [];
}
