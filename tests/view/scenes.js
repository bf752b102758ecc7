// Prints the drawing that `page/map.js` makes of each line of standard input; run by
// `tests/view/test_scene.py` below the scripts of the page.

const lines = require("node:fs").readFileSync(0, "utf8").split("\n").filter(Boolean);
for (const line of lines) {
  const { picture, facts, now, before } = JSON.parse(line);
  console.log(JSON.stringify(sceneOf(picture, new Beliefs(facts, now), before)));
}
