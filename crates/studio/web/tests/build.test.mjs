// The page builds: its text, its forms and its file, with the program behind it. Every control is clicked in a browser, and what it does is
// read in the text and carried out by `run`.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { axed, downloaded, launch, poorContrast, settled, shots } from "./browser.mjs";
import { absent, changing, endAll, folder, open, program, quiet, scenario, sessionText, studio } from "./program.mjs";


let browser;
before(async () => (browser = await launch()));
after(async () => {
  endAll();
  await browser?.close();
});

/** Does something that changes the text of the session; returns the lines that went (-) and came (+). */
async function difference(page, act) {
  const before = await sessionText(page);
  await changing(page, act);
  const came = (await sessionText(page)).split("\n");
  const lines = [];
  for (const line of before.split("\n")) {
    const at = came.indexOf(line);
    if (at >= 0) came.splice(at, 1);
    else lines.push(`-${line}`);
  }
  return [...lines, ...came.map((line) => `+${line}`)].filter((line) => line.length > 1);
}

/** Chooses a point of a branch, at a fraction of its length. */
const choosePoint = (page, branch, part) =>
  page.evaluate(
    ([name, part]) => {
      const { store, hands } = window.wireloom;
      hands.choose({ is: "point", branch: name, s: part * store.scene.branches.find((each) => each.name === name).length });
    },
    [branch, part],
  );
const chooseConstraint = (page, name) => page.evaluate((name) => window.wireloom.hands.choose({ is: "constraint", name }), name);

/** Types into a field of the forms, and leaves it. */
async function fill(page, label, value) {
  const field = page.locator("#build").getByLabel(label, { exact: true });
  await field.fill(value);
  await field.blur();
}
const press = (page, words) => page.locator("#build").getByRole("button", { name: words, exact: true }).click();
const openBuild = (page) => page.evaluate(() => document.querySelectorAll("#panels details").forEach((each) => (each.open = each.contains(document.getElementById("build")) || each.id.startsWith("build"))));

/** Types a line before all others of the text. */
async function typeFirst(page, words) {
  await page.keyboard.press("Control+Home");
  await page.keyboard.type(words);
  await page.keyboard.press("Enter");
}

/** `run` carries out the text of the session, and ends where the page does. */
async function runs(page, name) {
  const file = join(folder, `${name}.toml`);
  writeFileSync(file, await sessionText(page));
  const out = join(folder, `${name}.out`);
  const run = spawnSync(program, ["run", file, "--out", out, "--quiet"], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stdout + run.stderr);
  const last = JSON.parse(readFileSync(join(out, "result.json"), "utf8")).steps.at(-1);
  const shown = await page.evaluate(() => {
    const { store } = window.wireloom;
    let node = 0;
    return Object.fromEntries(store.scene.branches.map((branch) => [branch.name, Array.from({ length: branch.nodes }, () => [0, 1, 2].map((axis) => store.shown.nodes[window.wireloom.floats * node + axis]).concat(node++)).map((p) => p.slice(0, 3))]));
  });
  for (const [branch, { position }] of Object.entries(last.branches)) {
    assert.equal(position.length, shown[branch].length, branch);
    position.forEach((p, i) => assert.ok(Math.hypot(...p.map((x, k) => x - shown[branch][i][k])) < 1e-6, `${branch}, node ${i}: ${p} and ${shown[branch][i]}`));
  }
}

test("every form changes the text as a person would, is undone by name, and is what run carries out", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  await openBuild(page);
  const names = await page.evaluate(() => ({ branches: window.wireloom.store.scene.branches.map(({ name }) => name), sections: Object.keys(window.wireloom.store.document.entries.sections), constraints: window.wireloom.store.scene.constraints.map(({ name }) => name) }));
  const [trunk, second] = names.branches;

  await choosePoint(page, second, 0.5);
  const length = await page.locator("#build").getByLabel("length", { exact: true }).inputValue();
  const longer = `${/mm/.test(length) ? Number.parseFloat(length) + 20 : 1000 * Number(length) + 20} mm`;
  assert.deepEqual((await difference(page, () => fill(page, "length", longer))).filter((line) => line.startsWith("+")), [`+length = "${longer}"`]);
  assert.equal(await page.locator("#undo").getAttribute("title"), `Undo: length of branches.${second} (Ctrl Z)`);
  await runs(page, "length");
  await difference(page, () => page.locator("#undo").click());
  assert.equal(await page.locator("#build").getByLabel("length", { exact: true }).inputValue(), length);

  const section = names.sections.find((name) => name !== undefined && name !== second);
  const before = await page.locator("#build").getByLabel("section", { exact: true }).inputValue();
  const other = names.sections.find((name) => name !== before) ?? section;
  if (other !== before) {
    const changed = await difference(page, () => page.locator("#build").getByLabel("section", { exact: true }).selectOption(other));
    assert.deepEqual(changed, [`-section = "${before}"`, `+section = "${other}"`]);
  }

  const renamed = await difference(page, () => fill(page, "name of the branch", "long arm"));
  assert.ok(renamed.includes('+name = "long arm"') && renamed.some((line) => line.includes('branch = "long arm"')), renamed.join("\n"));
  await choosePoint(page, "long arm", 0.4);

  const own = await page.locator("#build").getByLabel("section", { exact: true }).inputValue();
  const tube = names.sections.find((name) => name !== own);
  await page.locator("#build").getByLabel("section of a new part", { exact: true }).selectOption(tube);
  await fill(page, "new part from", "50 mm");
  await fill(page, "new part to", "120 mm");
  assert.deepEqual(await difference(page, () => press(page, "Add part")), [`+sections = [{ section = "${tube}", from = "50 mm", to = "120 mm" }]`]);
  const parts = await page.evaluate(() => window.wireloom.store.scene.branches.find(({ name }) => name === "long arm").sections.map(({ section, to }) => [section, Math.round(1000 * to)]));
  assert.deepEqual(parts.slice(0, 2), [[own, 50], [tube, 120]]);
  await runs(page, "part");
  await settled(page);
  await page.screenshot({ path: `${shots}build-part.png` });
  assert.deepEqual((await difference(page, () => fill(page, "part 1 to", "150 mm"))).slice(-1), [`+sections = [{ section = "${tube}", from = "50 mm", to = "150 mm" }]`]);
  assert.deepEqual(await difference(page, () => press(page, "Delete part 1")), [`-sections = [{ section = "${tube}", from = "50 mm", to = "150 mm" }]`]);
  await choosePoint(page, "long arm", 0.4);

  await page.locator("#build").getByLabel("kind of clip", { exact: true }).selectOption("edge-clip");
  await fill(page, "name of the clip", "edge 1");
  const clip = await difference(page, () => press(page, "Add clip"));
  assert.deepEqual(clip.slice(0, 3), ["+[[constraints]]", '+name = "edge 1"', '+kind = "edge-clip"']);
  await runs(page, "clip");

  await chooseConstraint(page, "edge 1");
  assert.deepEqual(await difference(page, () => page.locator("#build").getByLabel("kind", { exact: true }).selectOption("collar")), ['-kind = "edge-clip"', '+kind = "collar"']);
  assert.deepEqual(await difference(page, () => page.locator("#build").getByLabel("position", { exact: true }).and(page.locator("[type=checkbox]")).check()), ['+hold = ["position"]']);
  assert.deepEqual(await difference(page, () => page.locator("#build").getByLabel("tangent", { exact: true }).and(page.locator("[type=checkbox]")).check()), ['-hold = ["position"]', '+hold = ["position", "tangent"]']);
  assert.deepEqual(await difference(page, () => page.locator("#build").getByLabel("slides", { exact: true }).check()), ["+slide = true"]);
  assert.deepEqual(await difference(page, () => page.locator("#build").getByLabel("slides", { exact: true }).uncheck()), ["-slide = true"]);
  assert.deepEqual(await difference(page, () => fill(page, "pull-out force", "80 N")), ['+pull_out_force = "80 N"']);
  assert.deepEqual(await difference(page, () => fill(page, "name of the constraint", "tie")), ['-name = "edge 1"', '+name = "tie"']);
  await chooseConstraint(page, "tie");
  const gone = await difference(page, () => press(page, "Delete constraint"));
  assert.ok(gone.includes('-name = "tie"') && gone.every((line) => line.startsWith("-")), gone.join("\n"));

  await choosePoint(page, trunk, 0.5);
  await fill(page, "name of the new branch", "tap");
  await fill(page, "its length", "150 mm");
  const tap = await difference(page, () => press(page, "Add branch here"));
  assert.ok(tap.includes('+name = "tap"') && tap.includes('+length = "150 mm"') && tap.includes(`+name = "${trunk} joint"`), tap.join("\n"));
  await runs(page, "tap");
  await settled(page);
  await page.screenshot({ path: `${shots}build-branch.png` });
  await choosePoint(page, "tap", 0.5);
  const split = await difference(page, () => press(page, "Split here"));
  assert.ok(split.includes('+name = "tap 2"') && split.includes('+length = "75 mm"'), split.join("\n"));
  await choosePoint(page, "tap 2", 0.5);
  await difference(page, () => press(page, "Delete branch"));
  await runs(page, "deleted");
  assert.doesNotMatch(await sessionText(page), /tap 2|name = "tap joint"/, "its joint is an end again");

  for (const shape of ["box", "sphere", "cylinder"]) {
    const added = await difference(page, () => press(page, `Add ${shape}`));
    assert.deepEqual(added.slice(0, 3), ["+[[obstacles]]", `+name = "${shape}"`, `+shape = "${shape}"`]);
  }
  assert.ok(await page.evaluate(() => window.wireloom.store.shown.header.obstacles.every(({ contacts }) => contacts === 0)), "they stand beside the harness");
  assert.deepEqual(await difference(page, () => fill(page, "radius of sphere", "20 mm")), ['-radius = "50 mm"', '+radius = "20 mm"']);
  assert.deepEqual((await difference(page, () => fill(page, "position of sphere", "0.1, 0.4, -0.5"))).slice(-1), ["+position = [0.1, 0.4, -0.5]"]);
  assert.deepEqual(await difference(page, () => fill(page, "angles of box, °", "0, 0, 90")), ["+orientation = [0.7071068, 0, 0, 0.7071068]"]);
  assert.deepEqual(await difference(page, () => fill(page, "least clearance of box", "5 mm")), ['+min_clearance = "5 mm"']);
  assert.equal(await page.evaluate(() => window.wireloom.store.scene.obstacles.length), 3);
  await page.screenshot({ path: `${shots}build-obstacles.png` });
  await difference(page, () => fill(page, "name of box", "wall"));
  await difference(page, () => page.locator("#build-obstacles li", { hasText: "wall" }).getByRole("button", { name: "Delete obstacle" }).click());
  assert.doesNotMatch(await sessionText(page), /wall/);

  await chooseConstraint(page, names.constraints[0]);
  await fill(page, "name of the new requirement", "plug force");
  await page.locator("#build").getByLabel("its quantity", { exact: true }).selectOption("force");
  await page.locator("#build").getByLabel("bound", { exact: true }).selectOption("max");
  await fill(page, "its limit", "500 N");
  assert.deepEqual(await difference(page, () => press(page, "Add requirement")), ["+[[requirements]]", '+name = "plug force"', '+quantity = "force"', `+of = { constraint = "${names.constraints[0]}" }`, '+max = "500 N"']);
  assert.match(await page.locator("#sheet").textContent(), /plug force/);
  await difference(page, () => fill(page, "greatest value of plug force", "0.001 N"));
  await page.waitForFunction(() => document.getElementById("verdict").textContent.startsWith("FAIL"));
  await difference(page, () => page.locator("#build").getByLabel("severity of plug force", { exact: true }).selectOption("should"));
  await difference(page, () => page.locator("#build-requirements").getByRole("button", { name: "Delete requirement" }).click());
  await page.waitForFunction(() => !document.getElementById("sheet").textContent.includes("plug force"));

  // What is refused is told, and the field has the value of the text again.
  await choosePoint(page, trunk, 0.2);
  const kept = await page.locator("#build").getByLabel("length", { exact: true }).inputValue();
  const text = await sessionText(page);
  await fill(page, "length", "-3 mm");
  await page.locator("#messages", { hasText: "length" }).waitFor();
  assert.equal(await page.locator("#build").getByLabel("length", { exact: true }).inputValue(), kept);
  assert.equal(await sessionText(page), text);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("text is checked as it is typed, applied, merged with what hands do, and outlives the page", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  await page.locator("#text-on").click();
  const content = page.locator("#text .cm-content");
  await content.waitFor();
  // Typed in the editor itself: a fault is marked and listed at its place, and leads there.
  await content.click();
  await page.keyboard.press("Control+End");
  await page.keyboard.type("\n[minimisr]\n");
  // What stands there while it is being typed may be told before.
  const fault = page.locator("#text-faults li", { hasText: "minimiser" });
  await fault.waitFor();
  assert.match(await fault.innerText(), /^\d+:\d+: .*minimisr.*minimiser/s);
  // It is underlined.
  await page.locator("#text .cm-lintRange-error").first().waitFor();
  await settled(page);
  await page.screenshot({ path: `${shots}text-fault.png` });
  await page.locator("#text-faults button").first().click();
  assert.match(await page.evaluate(() => document.querySelector(".text-holder").shadowRoot.activeElement?.className ?? ""), /cm-content/);
  // What does not check is not applied.
  const before = await sessionText(page);
  await page.locator("#text-apply").click();
  await page.locator("#messages", { hasText: "minimisr" }).waitFor();
  assert.equal(await sessionText(page), before);
  await page.locator("#text-revert").click();
  await page.waitForFunction(() => !window.wireloom.text.dirty && document.querySelectorAll("#text-faults li").length === 0);

  // A length is changed in the text and applied with Ctrl Enter.
  await content.click();
  await typeFirst(page, "# seen by me");
  const applied = await difference(page, () => page.keyboard.press("Control+Enter"));
  assert.deepEqual(applied, ["+# seen by me"]);
  await page.waitForFunction(() => !window.wireloom.text.dirty);
  assert.equal(await page.locator("#undo").getAttribute("title"), "Undo: edit the text (Ctrl Z)");

  // Another line is edited here, while a form changes a length: both stay.
  await content.click();
  await typeFirst(page, "# not applied");
  await openBuild(page);
  const branch = await page.evaluate(() => window.wireloom.store.scene.branches[0].name);
  await choosePoint(page, branch, 0.5);
  await difference(page, () => fill(page, "length", "0.55"));
  const merged = await page.evaluate(() => window.wireloom.text.text);
  assert.match(merged, /^# not applied\n# seen by me\n/);
  assert.match(merged, /length = 0\.55/);
  assert.equal(await page.evaluate(() => window.wireloom.text.dirty), true);

  // The same line in both: asked.
  const asked = () => page.locator("#text .text-ask button").first().waitFor();
  await page.evaluate(() => window.wireloom.text.lookFor(window.wireloom.store.scene.branches[0].name));
  await page.keyboard.press("End");
  await page.keyboard.type(" # mine");
  await difference(page, () => fill(page, "name of the branch", "theirs"));
  await asked();
  await page.locator("#text-theirs").click();
  assert.equal(await page.evaluate(() => window.wireloom.text.text), await sessionText(page));
  await page.evaluate(() => window.wireloom.text.lookFor("theirs"));
  await page.keyboard.press("End");
  await page.keyboard.type(" # mine");
  await choosePoint(page, "theirs", 0.5);
  await difference(page, () => fill(page, "name of the branch", "again"));
  await asked();
  await page.locator("#text-mine").click();
  assert.match(await page.evaluate(() => window.wireloom.text.text), /"theirs" # mine/);
  await page.locator("#text-find").click();
  assert.equal(await page.locator("#text .cm-search").count(), 1);
  await page.locator("#text-on").click();
  assert.equal(await page.locator("#text").count(), 0);
  assert.deepEqual(found, []);
  page.on("dialog", (dialog) => dialog.accept());
  await page.close();
  assert.equal(await stop(), 0);
});

test("what was not applied is offered after a reload of the page", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  page.on("dialog", (dialog) => dialog.accept());
  await page.locator("#text-on").click();
  await page.locator("#text .cm-content").click();
  await typeFirst(page, "# a thought");
  await page.reload();
  await quiet(page);
  await page.keyboard.press("t");
  await page.locator("#text-restore").click();
  assert.match(await page.evaluate(() => window.wireloom.text.text), /^# a thought\n/);
  await difference(page, () => page.locator("#text-apply").click());
  await page.reload();
  await quiet(page);
  await page.keyboard.press("t");
  assert.equal(await page.locator("#text-restore").count(), 0, "it was applied");
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("an edit of another branch leaves the chosen one chosen, and measures where they are", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  await openBuild(page);
  const [first, ...others] = await page.evaluate(() => window.wireloom.store.scene.branches.map(({ name }) => name));
  const last = others.at(-1);
  const measured = () => page.locator("#measured").evaluate((list) => Object.fromEntries([...list.querySelectorAll("dt")].map((name) => [name.textContent, name.nextElementSibling.textContent])));
  await page.locator("#stage").focus();
  await page.keyboard.press("m");
  await choosePoint(page, last, 0.25);
  await choosePoint(page, last, 0.75);
  const before = await measured();
  assert.ok(before["arc length"] && before.to.startsWith(`${last} at `), JSON.stringify(before));
  // Another page splits the first branch: the second half comes behind it, and before all others.
  const chosen = await page.evaluate(() => window.wireloom.hands.chosen);
  const other = await open(browser, address);
  await openBuild(other.page);
  const split = async (branch) => {
    await quiet(other.page);
    await choosePoint(other.page, branch, 0.25);
    await press(other.page, "Split here");
  };
  await difference(page, () => split(first));
  assert.deepEqual(await page.evaluate(() => window.wireloom.hands.chosen), chosen);
  assert.equal(await page.locator("#build h3").first().innerText(), `Branch ${last}`);
  const after = await measured();
  assert.deepEqual([after.from, after.to, after["arc length"]], [before.from, before.to, before["arc length"]]);
  assert.equal(await page.getByLabel("Branch", { exact: true }).inputValue(), last);
  // Where there is no such place any more, nothing is chosen.
  await difference(page, () => split(last));
  assert.equal(await page.evaluate(() => window.wireloom.hands.chosen), null);
  assert.match((await measured()).to, /not there in this frame/);
  assert.deepEqual([...found, ...other.found], []);
  await other.page.close();
  await page.close();
  assert.equal(await stop(), 0);
});

test("a comment has no completions, and the check of a text that is reverted marks nothing", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  await page.locator("#text-on").click();
  const content = page.locator("#text .cm-content");
  await content.waitFor();
  await content.click();
  const completions = page.locator("#text .cm-tooltip-autocomplete");
  await page.keyboard.press("Control+Home");
  await page.keyboard.type("leng");
  await completions.waitFor();
  await page.keyboard.press("Escape");
  await page.keyboard.press("Control+Home");
  await page.keyboard.type("# leng");
  // As long as the list takes to open, several times.
  await page.waitForTimeout(500);
  assert.equal(await completions.count(), 0);
  await page.keyboard.press("Control+Space");
  await page.waitForTimeout(500);
  assert.equal(await completions.count(), 0);

  // The answer to a check comes after Revert.
  await page.evaluate(() => {
    const { store } = window.wireloom;
    const take = store.take.bind(store);
    const late = [];
    store.take = (notice) => (notice.is === "checked" ? late.push(notice) : take(notice));
    window.late = { count: () => late.length, come: () => late.forEach(take) };
  });
  await page.keyboard.press("Control+End");
  await page.keyboard.type("\n[minimisr]\n");
  await page.waitForFunction(() => window.late.count() > 0);
  await page.locator("#text-revert").click();
  await page.evaluate(() => window.late.come());
  assert.equal(await page.locator("#text-faults li").count(), 0);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("a text is too large by its bytes, not by its characters", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  await page.locator("#text-on").click();
  // 3,000,000 characters of two bytes: fewer characters than bytes are allowed.
  await page.evaluate(() => window.wireloom.text.propose(`# ${"ä".repeat(3_000_000)}`));
  await page.locator("#text-apply").click();
  assert.match(await page.locator("#text-faults li").first().innerText(), /the text has 6000002 bytes\s+at most 4194304 can be applied here/);
  assert.deepEqual(found, []);
  page.on("dialog", (dialog) => dialog.accept());
  await page.close();
  assert.equal(await stop(), 0);
});

test("a scenario that is dropped becomes the text; what cannot is told", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await open(browser, address);
  const drop = (name, bytes) =>
    page.evaluate(
      ([name, bytes]) => {
        const transfer = new DataTransfer();
        transfer.items.add(new File([typeof bytes === "number" ? new Uint8Array(bytes) : typeof bytes === "string" ? bytes : new Uint8Array(bytes)], name));
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
      },
      [name, bytes],
    );
  const said = (words) => page.locator("#messages", { hasText: words }).waitFor();
  const before = await sessionText(page);
  await drop("a.kbl", "<kbl/>");
  await said("wireloom import");
  await drop("a.png", "x");
  await said("a file that ends in .toml");
  await drop("a.toml", [0xff, 0xfe, 0x41]);
  await said("no UTF-8 text");
  await drop("huge.toml", 5 * 1024 * 1024);
  await said("at most 4194304");
  assert.equal(await page.locator("#text").count(), 0);
  await drop("broken.toml", "schema = 1\nname = ");
  await page.locator("#text-faults li").first().waitFor();
  assert.match(await page.locator("#text-faults li").first().innerText(), /^2:/);
  assert.equal(await sessionText(page), before);
  const other = before.replace(/name = "[^"]*"/, 'name = "dropped"');
  await drop("other.toml", other);
  await page.waitForFunction((text) => window.wireloom.text.text === text, other);
  await difference(page, () => page.locator("#text-apply").click());
  assert.equal(await sessionText(page), other);
  await page.waitForFunction(() => document.getElementById("name").textContent === "dropped");
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("save writes the file, and another program's changes are noticed and shown", { skip: absent }, async () => {
  const file = scenario("branches/y_cosserat.toml");
  const { address, stop } = await studio(file);
  const { page, found } = await open(browser, address);
  await openBuild(page);
  const branch = await page.evaluate(() => window.wireloom.store.scene.branches[0].name);
  await choosePoint(page, branch, 0.5);
  await difference(page, () => fill(page, "length", "0.55"));
  assert.equal(await page.locator("#save").innerText(), "Save •");
  await page.locator("#stage").focus();
  await page.keyboard.press("Control+s");
  await page.waitForFunction(() => document.getElementById("save").textContent === "Save");
  assert.equal(readFileSync(file, "utf8"), await sessionText(page));

  // Another program writes: noticed without a save.
  const theirs = readFileSync(file, "utf8").replace("length = 0.55", "length = 0.56");
  writeFileSync(file, theirs);
  await page.locator("#file", { hasText: "was changed by another program" }).waitFor({ timeout: 15_000 });
  await page.screenshot({ path: `${shots}file-changed.png` });
  await page.locator("#file-later").click();
  await difference(page, () => fill(page, "length", "0.57"));
  await page.locator("#save").click();
  await page.locator("#file", { hasText: "nothing has been saved" }).waitFor();
  assert.equal(readFileSync(file, "utf8"), theirs, "it is not replaced unasked");
  await difference(page, () => page.locator("#file-reload").click());
  assert.equal(await sessionText(page), theirs);
  await difference(page, () => page.locator("#undo").click());
  assert.match(await sessionText(page), /length = 0\.57/);
  await page.locator("#save").click();
  await page.waitForFunction(() => document.getElementById("save").textContent === "Save");
  assert.match(readFileSync(file, "utf8"), /length = 0\.57/);
  writeFileSync(file, theirs);
  await difference(page, () => fill(page, "length", "0.58"));
  await page.locator("#save").click();
  await page.locator("#file-overwrite").click();
  await page.waitForFunction(() => document.getElementById("save").textContent === "Save");
  assert.match(readFileSync(file, "utf8"), /length = 0\.58/);

  // Under another name, in the same folder only.
  const saveAs = async (name) => {
    await page.locator("#save-as").click();
    await page.locator("#file-name").fill(name);
    await page.locator("#name-dialog button[type=submit]").click();
  };
  await saveAs("../other.toml");
  await page.locator("#messages", { hasText: "is no name for the file of a scenario" }).waitFor();
  await saveAs("other.toml");
  await page.waitForFunction(() => window.wireloom.store.document.name === "other.toml");
  assert.match(readFileSync(join(dirname(file), "other.toml"), "utf8"), /length = 0\.58/);
  await difference(page, () => fill(page, "length", "0.59"));
  await page.locator("#save").click();
  await page.waitForFunction(() => document.getElementById("save").textContent === "Save");
  assert.match(readFileSync(file, "utf8"), /length = 0\.58/, "the first file stays as it is");
  await saveAs(file.split("/").pop());
  await page.locator("#file", { hasText: "There is a file" }).waitFor();
  await page.locator("#file-other").click();
  await page.locator("#name-dialog button", { hasText: "Cancel" }).click();
  assert.equal(basename(await downloaded(page, () => page.locator("#copy").click())), "other.toml");
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("the text and the forms are accessible, and fit from 1024 to 1920 pixels", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("assembly/workbench.toml"));
  for (const colorScheme of ["light", "dark"]) {
    const { page, found } = await open(browser, address, { colorScheme });
    await page.locator("#text-on").click();
    await openBuild(page);
    await choosePoint(page, "trunk", 0.5);
    for (const width of [1024, 1440, 1920]) {
      await page.setViewportSize({ width, height: Math.round((width * 9) / 16) });
      await settled(page);
      await page.screenshot({ path: `${shots}build-${colorScheme}-${width}.png` });
      const wide = await page.evaluate(() => [...document.querySelectorAll("header, header *, #text, #build, #build input, #build button")].filter((each) => each.checkVisibility() && each.getBoundingClientRect().right > window.innerWidth + 0.5).map((each) => each.id || each.textContent.slice(0, 30)));
      assert.deepEqual(wide, [], `${width} pixels`);
    }
    assert.deepEqual(await poorContrast(page), []);
    assert.deepEqual(await axed(page), []);
    await chooseConstraint(page, "plug-A");
    assert.deepEqual(await axed(page), []);
    assert.deepEqual(found, []);
    await page.close();
  }
  assert.equal(await stop(), 0);
});
