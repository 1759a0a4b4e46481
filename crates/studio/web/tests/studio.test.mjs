// The page with the program behind it, in a browser: a harness that is loaded, taken hold of, saved, computed anew by `run`, whose joint
// model is swapped, and whose server goes and comes back. WIRELOOM names the program (else target/debug/wireloom).
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { downloaded, faults, launch, local, newPage, pixels, settled, shots } from "./browser.mjs";
import { absent, endAll, environment, folder, open, program, quiet, scenario, studio } from "./program.mjs";

let browser;

before(async () => (browser = await launch()));

after(async () => {
  endAll();
  await browser?.close();
});

const opened = (address) => open(browser, address);

const at = (page, name) => page.evaluate((name) => window.wireloom.toScreen(window.wireloom.hands.at(name).at.position), name);
const position = (page, name) => page.evaluate((name) => window.wireloom.hands.at(name).at.position, name);

/** Drags from one point of the screen to another in small moves. */
async function drag(page, from, by) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let k = 1; k <= 12; k++) {
    await page.mouse.move(from.x + (by[0] * k) / 12, from.y + (by[1] * k) / 12);
    await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(resolve)));
  }
  await page.mouse.up();
}

/** The newest shape: branch by branch, node positions. */
const shape = (page) =>
  page.evaluate(() => {
    const { store } = window.wireloom;
    const positions = {};
    let node = 0;
    for (const branch of store.scene.branches) {
      positions[branch.name] = [];
      for (let i = 0; i < branch.nodes; i++, node++) positions[branch.name].push([0, 1, 2].map((axis) => store.shown.nodes[window.wireloom.floats * node + axis]));
    }
    return positions;
  });

/** The greatest distance of nodes, m. */
function distance(a, b) {
  let greatest = 0;
  for (const branch of Object.keys(a)) {
    assert.equal(a[branch].length, b[branch].length);
    a[branch].forEach((p, i) => (greatest = Math.max(greatest, Math.hypot(...p.map((x, k) => x - b[branch][i][k])))));
  }
  return greatest;
}

/** Downloads a copy, and has `run` carry it out. */
async function saved(page, name) {
  const file = join(folder, name);
  copyFileSync(await downloaded(page, () => page.locator("#copy").click()), file);
  const out = join(folder, `${name}.out`);
  const run = spawnSync(program, ["run", file, "--out", out, "--quiet"], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stdout + run.stderr);
  const result = JSON.parse(readFileSync(join(out, "result.json"), "utf8"));
  const last = result.steps.at(-1);
  return { text: readFileSync(file, "utf8"), last, shape: Object.fromEntries(Object.entries(last.branches).map(([branch, { position }]) => [branch, position])) };
}

test("steps are carried out and play; plugs and points follow the mouse; run reproduces what was saved", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("assembly/workbench.toml"));
  const { page, found } = await opened(address);
  const steps = await page.evaluate(() => window.wireloom.store.timeline.steps.map(({ name, frames }) => [name, frames]));
  assert.deepEqual(steps.slice(1).map(([, frames]) => frames), [1, 10, 20, 30, 1, 1, 5]);
  await page.screenshot({ path: `${shots}studio-opened.png` });

  // Steps play, once all frames are here. A slow machine leaves some out, at most 7 at a time.
  await page.waitForFunction(() => window.wireloom.store.missing() === null, null, { timeout: 60_000 });
  await page.evaluate(() => {
    window.seen = [];
    window.wireloom.store.on("shown", (frame) => window.seen.push(frame.header.frame));
  });
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.seen.includes(0) && window.seen.at(-1) === window.wireloom.store.newest(), null, { timeout: 60_000 });
  const seen = await page.evaluate(() => window.seen);
  assert.equal(seen[0], 0);
  assert.ok(seen.slice(1).every((frame, k) => frame > seen[k] && frame <= seen[k] + 8), seen.join());
  await quiet(page);

  // A plug follows the mouse, and the harness follows the plug.
  const before = await shape(page);
  const plug = await position(page, "plug-B");
  await drag(page, await at(page, "plug-B"), [-60, -50]);
  await quiet(page);
  const brought = await position(page, "plug-B");
  assert.ok(Math.hypot(...brought.map((x, k) => x - plug[k])) > 0.02, `plug-B went from ${plug} to ${brought}`);
  const dragged = await shape(page);
  const end = dragged.left.at(-1);
  assert.ok(Math.hypot(...end.map((x, k) => x - brought[k])) < 1e-4, "the cable's end is in the plug");
  assert.ok(distance(before, dragged) > 0.02);
  await page.screenshot({ path: `${shots}studio-plug-dragged.png` });

  // Once it rests the page says what moving the plug on does to the requirements.
  await page.waitForFunction(() => document.querySelectorAll("#sensitivities tbody tr").length > 0);
  const told = await page.locator("#sensitivities").innerText();
  assert.match(told, /Moved by 1 mm\s+\+x\s+\+y\s+\+z/);
  assert.match(told, /bend radius, .*\s+[+−][\d.]+ mm/);
  // An arrow shows the better direction for a requirement whose derivatives are all known.
  await page.locator("#sensitivities tbody tr").filter({ hasNotText: /[*?]/ }).first().hover();
  await page.waitForFunction(() => document.querySelector(".label.better:not([hidden])")?.textContent.startsWith("better for"));

  // Any point: a handle appears.
  const point = await page.evaluate(() => {
    const { store, toScreen } = window.wireloom;
    const node = 41 + 15;
    return toScreen([0, 1, 2].map((axis) => store.shown.nodes[window.wireloom.floats * node + axis]));
  });
  const constraints = await page.evaluate(() => window.wireloom.store.scene.constraints.length);
  await drag(page, point, [10, -70]);
  await page.waitForFunction((count) => window.wireloom.store.scene.constraints.length === count + 1, constraints);
  await quiet(page);
  const hand = await page.evaluate(() => window.wireloom.hands.constraintName());
  assert.ok(hand, "the new handle is chosen");
  await page.screenshot({ path: `${shots}studio-point-dragged.png` });

  // The keyboard moves it on by 10 mm, and undo takes that back.
  const was = await position(page, hand);
  await page.keyboard.press("Shift+ArrowUp");
  await page.waitForFunction(({ hand, z }) => Math.abs(window.wireloom.hands.at(hand)?.at.position[2] - z - 0.01) < 1e-6, { hand, z: was[2] });
  await quiet(page);
  await page.keyboard.press("Control+z");
  await page.waitForFunction(({ hand, z }) => Math.abs(window.wireloom.hands.at(hand)?.at.position[2] - z) < 1e-9, { hand, z: was[2] });
  await quiet(page);
  await page.keyboard.press("Control+y");
  await page.waitForFunction(({ hand, z }) => Math.abs(window.wireloom.hands.at(hand)?.at.position[2] - z - 0.01) < 1e-6, { hand, z: was[2] });
  await quiet(page);

  // What was saved passes through the same equilibria; frames are f32, metres.
  const shown = await shape(page);
  const reproduced = await saved(page, "dragged.toml");
  assert.match(reproduced.text, new RegExp(hand));
  assert.ok(distance(shown, reproduced.shape) < 1e-6, `${distance(shown, reproduced.shape)} m between page and run`);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("a plug out of reach is a failure, whatever the solver says, until it is undone", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("assembly/workbench.toml"));
  const { page, found } = await opened(address);
  const before = await page.locator("#verdict").innerText();
  assert.match(before, /^(PASS|UNRESOLVED)/);
  await page.evaluate(() => {
    const { hands } = window.wireloom;
    const { position, orientation } = hands.at("plug-B").at;
    hands.bring("plug-B", { position: [position[0] + 0.5, position[1], position[2]], orientation }, false);
  });
  await page.waitForFunction(() => window.wireloom.store.shown?.header.violations.some(({ measure }) => measure === "reach"), null, { timeout: 60_000 });
  await quiet(page);
  assert.match(await page.locator("#verdict").innerText(), /^FAIL/);
  assert.match((await page.locator("#warning > div").first().innerText()).replaceAll(/\s+/g, " "), /^FAIL over-stretched: 1\.\d\d × its length, at most 1\.\d\d × its length; /);
  assert.match(await page.getByLabel("Solver").innerText(), /solver\s+converged/);
  assert.match(await page.locator("#legend").textContent(), /over-stretched, overloaded or in another cable/);
  await page.screenshot({ path: `${shots}studio-out-of-reach.png` });
  const { orange } = await pixels(browser, await page.locator("#stage canvas").screenshot());
  assert.ok(orange > 300, `${orange} pixels are orange`);
  const words = await page.locator("#sheet .lines").innerText();
  assert.match(words, /stretch 1\.\d\d × its length/);
  assert.doesNotMatch(await page.locator("#panels").innerText(), /\d[eE][+−-]?\d/);
  await page.keyboard.press("Control+z");
  await quiet(page);
  await page.waitForFunction((words) => document.getElementById("verdict").textContent === words, before);
  assert.equal(await page.locator("#warning.destroyed").count(), 0);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("another joint model gives another shape, and the one there was stays as a ghost", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await opened(address);
  const before = await shape(page);
  await page.getByText("Swap", { exact: true }).click();
  const setting = page.locator("label.setting", { hasText: "model" }).locator("select").first();
  assert.equal(await setting.inputValue(), "cosserat");
  const run = await page.evaluate(() => window.wireloom.store.scene.run);
  await setting.selectOption("rigid-body");
  await page.waitForFunction((run) => window.wireloom.store.scene.run !== run, run);
  await quiet(page);
  assert.equal(await page.evaluate(() => window.wireloom.store.scene.joints[0].model), "rigid-body");
  const now = await shape(page);
  assert.ok(distance(before, now) > 1e-4, `${distance(before, now)} m between the models`);
  assert.match(await page.locator("#difference").innerText(), /largest distance\s+[1-9]/);
  await page.screenshot({ path: `${shots}studio-swapped.png` });
  const reproduced = await saved(page, "swapped.toml");
  assert.ok(distance(now, reproduced.shape) < 1e-6);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("a page says that its session has ended, and the next one offers what nobody saved", { skip: absent }, async () => {
  const file = scenario("assembly/workbench.toml");
  const first = await studio(file);
  const { page } = await opened(first.address);
  await drag(page, await at(page, "plug-B"), [-50, -30]);
  await quiet(page);
  const dragged = await shape(page);
  await page.waitForFunction(() => window.wireloom.store.session.unsaved);
  await first.stop();
  const ended = () => page.waitForFunction(() => document.getElementById("link").textContent === "session ended");
  await ended();
  assert.match(await page.locator("#draft").textContent(), /Start “wireloom studio” again/);
  await page.screenshot({ path: `${shots}studio-ended.png` });
  // A server that was killed says nothing: the page learns it from the next one, which has another token.
  const killed = await studio(file);
  assert.equal(new URL(killed.address).port, new URL(first.address).port);
  assert.notEqual(killed.address, first.address);
  await page.goto(killed.address);
  await quiet(page);
  await killed.kill();
  await page.waitForFunction(() => document.getElementById("link").textContent.includes("lost"));
  const second = await studio(file);
  await ended();
  await page.goto(second.address);
  await quiet(page);
  assert.ok(distance(dragged, await shape(page)) > 1e-3, "the session begins as the file says");
  await page.screenshot({ path: `${shots}studio-restarted.png` });
  const frames = await page.evaluate(() => window.wireloom.store.timeline.frames);
  await page.getByRole("button", { name: "Restore it" }).click();
  await page.waitForFunction((frames) => window.wireloom.store.timeline.frames > frames, frames, { timeout: 60_000 });
  await quiet(page);
  assert.ok(distance(dragged, await shape(page)) < 1e-6);
  await page.close();
  await second.stop();
});

test("a finished run is replayed by the studio and by a page of its own", { skip: absent }, async () => {
  const out = join(folder, "finished");
  const own = join(folder, "page.html");
  const run = spawnSync(program, ["run", scenario("assembly/workbench.toml"), "--out", out, "--page", own, "--quiet"], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stdout + run.stderr);
  const page = await newPage(browser);
  const found = faults(page);
  await page.goto(local(own));
  await page.waitForFunction(() => window.wireloom?.store.shown?.header.frame === window.wireloom.store.newest());
  assert.ok((await page.evaluate(() => window.wireloom.store.timeline.frames)) > 60);
  assert.equal(await page.getByRole("button", { name: "Undo" }).isVisible(), false);
  await page.screenshot({ path: `${shots}studio-own-page.png` });
  const shown = await shape(page);
  const { address, stop } = await studio(out);
  await page.goto(address);
  await page.waitForFunction(() => window.wireloom?.store.shown?.header.frame === window.wireloom.store.newest());
  assert.ok(distance(shown, await shape(page)) < 1e-6);
  await page.screenshot({ path: `${shots}studio-finished.png` });
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("exact poses, rings, pins, clips, letting go, and going back", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const { page, found } = await opened(address);
  const constraint = (name) => page.evaluate((name) => window.wireloom.hands.at(name), name);
  const started = await page.evaluate(() => window.wireloom.store.newest());

  // A pose that is typed: millimetres, and degrees about the world's axes.
  await page.getByRole("button", { name: "plug-B", exact: true }).click();
  const before = await constraint("plug-B");
  const field = (words) => page.getByLabel(words, { exact: true });
  const z = Number(await field("z, mm").inputValue());
  await field("z, mm").fill(String(z + 12.5));
  const about = Number(await field("about z, °").inputValue());
  await field("about z, °").fill(String(about + 10));
  await page.getByRole("button", { name: "Move there" }).click();
  await page.waitForFunction((z) => Math.abs(window.wireloom.hands.at("plug-B")?.at.position[2] * 1000 - z) < 0.01, z + 12.5);
  await quiet(page);
  const posed = await constraint("plug-B");
  const turn = 2 * Math.acos(Math.min(1, Math.abs(before.at.orientation.reduce((sum, x, i) => sum + x * posed.at.orientation[i], 0))));
  assert.ok(Math.abs((turn * 180) / Math.PI - 10) < 0.05, `turned by ${(turn * 180) / Math.PI}°`);

  // Rings: a drag on one of them turns the plug and leaves its position.
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("r");
  assert.equal(await page.locator("#gizmo-turn").getAttribute("aria-pressed"), "true");
  await settled(page);
  const centre = await at(page, "plug-B");
  const ring = await page.evaluate(async ({ x, y }) => {
    const canvas = document.querySelector("#stage canvas");
    for (let radius = 40; radius < 140; radius += 3) {
      for (let angle = 0; angle < 6.2; angle += 0.15) {
        const [clientX, clientY] = [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
        canvas.dispatchEvent(new PointerEvent("pointermove", { clientX, clientY, pointerId: 1, pointerType: "mouse", bubbles: true }));
        if (["X", "Y", "Z"].includes(window.wireloom.hands.ring())) return { x: clientX, y: clientY };
      }
    }
    return null;
  }, centre);
  assert.ok(ring, "a ring can be pointed at");
  await drag(page, ring, [18, 14]);
  await quiet(page);
  const turned = await constraint("plug-B");
  assert.ok(Math.abs(turned.at.orientation.reduce((sum, x, i) => sum + x * posed.at.orientation[i], 0)) < 0.99999, "it has turned");
  assert.ok(Math.hypot(...turned.at.position.map((x, k) => x - posed.at.position[k])) < 1e-6, "it has not moved");
  await page.screenshot({ path: `${shots}studio-turned.png` });
  await page.keyboard.press("Escape");

  // A clip in the middle of the trunk, which keeps its place when the plug is let go.
  await page.keyboard.press("Alt+ArrowDown");
  const trunk = await page.locator("#said").innerText();
  assert.match(trunk, /^trunk at 200/);
  const count = await page.evaluate(() => window.wireloom.store.scene.constraints.length);
  await page.keyboard.press("c");
  await page.waitForFunction((count) => window.wireloom.store.scene.constraints.length === count + 1, count);
  await quiet(page);
  const clip = await page.evaluate(() => window.wireloom.hands.constraint());
  assert.equal(clip.kind, "collar");
  const closed = await constraint(clip.name);
  await page.getByRole("button", { name: "plug-B", exact: true }).click();
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("Delete");
  await page.waitForFunction(() => window.wireloom.hands.at("plug-B") === null);
  await quiet(page);
  const stays = await constraint(clip.name);
  assert.ok(Math.hypot(...stays.at.position.map((x, k) => x - closed.at.position[k])) < 1e-6);
  await page.screenshot({ path: `${shots}studio-clipped.png` });

  // Hands at an earlier place: the session goes back there, and undo brings back what came after.
  const all = await page.evaluate(() => window.wireloom.store.newest());
  await page.evaluate((frame) => window.wireloom.store.scrub(frame), started);
  await page.waitForFunction((frame) => window.wireloom.store.shown.header.frame === frame, started);
  await page.keyboard.press("n");
  await page.keyboard.press("Shift+ArrowUp");
  await page.waitForFunction((all) => window.wireloom.store.newest() < all, all);
  await quiet(page);
  const names = await page.evaluate(() => window.wireloom.store.shown.header.constraints.map(({ name }) => name));
  assert.ok(names.includes("plug-B") && !names.includes(clip.name));
  await page.keyboard.press("Control+z");
  await quiet(page);
  await page.keyboard.press("Control+z");
  await page.waitForFunction((all) => window.wireloom.store.newest() === all, all);
  await quiet(page);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("several pages see the same session, and what a closed one held is free", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("branches/y_cosserat.toml"));
  const one = await opened(address);
  const two = await opened(address);
  assert.equal(await two.page.evaluate(() => window.wireloom.store.session.tabs), 2);
  await drag(one.page, await at(one.page, "plug-C"), [-20, -30]);
  await quiet(one.page);
  const newest = await one.page.evaluate(() => window.wireloom.store.newest());
  await two.page.waitForFunction((newest) => window.wireloom.store.shown.header.frame === newest, newest);
  await quiet(two.page);
  assert.ok(distance(await shape(one.page), await shape(two.page)) === 0);
  // One page takes hold of a point; the other may move it once the first is gone.
  await one.page.keyboard.press("Alt+ArrowDown");
  await one.page.keyboard.press("h");
  await two.page.waitForFunction(() => window.wireloom.store.session.held.length === 1);
  const [hand] = await two.page.evaluate(() => window.wireloom.store.session.held[0]);
  await one.page.close();
  await two.page.waitForFunction(() => window.wireloom.store.session.held.length === 0 && window.wireloom.store.session.tabs === 1);
  await quiet(two.page);
  const was = await position(two.page, hand);
  await two.page.evaluate((hand) => window.wireloom.hands.choose({ is: "constraint", name: hand }), hand);
  await two.page.keyboard.press("Shift+ArrowUp");
  await two.page.waitForFunction(({ hand, z }) => Math.abs(window.wireloom.hands.at(hand)?.at.position[2] - z - 0.01) < 1e-6, { hand, z: was[2] });
  await quiet(two.page);
  assert.deepEqual([...one.found, ...two.found], []);
  await two.page.close();
  assert.equal(await stop(), 0);
});

test("the tolerance envelope of a sweep is shown around the harness, by percentile and as all that was swept", { skip: absent }, async () => {
  const file = scenario("sweeps/y_tolerances.toml");
  writeFileSync(file, readFileSync(file, "utf8").replace("samples = 256", 'samples = 24\nswept = "10 mm"'));
  const out = join(folder, "envelope.out");
  const sweep = spawnSync(program, ["sweep", file, "--out", out, "--quiet"], { encoding: "utf8" });
  assert.equal(sweep.status, 0, sweep.stdout + sweep.stderr);
  const { address, stop } = await studio(file, "--envelope", out);
  const { page, found } = await opened(address);
  await page.waitForSelector("#envelope-row:not([hidden])");
  assert.deepEqual(await page.$$eval("#envelope option", (options) => options.map((option) => option.value)), ["none", "50", "90", "95", "100", "swept"]);
  const seen = async (choice) => {
    await page.selectOption("#envelope", choice);
    await settled(page);
    const { coloured } = await pixels(browser, await page.locator("canvas").first().screenshot());
    const size = await page.evaluate(() => {
      let greatest = 0;
      for (const { geometry } of window.wireloom.envelope.group.children) {
        geometry.computeBoundingBox();
        greatest = Math.max(greatest, geometry.boundingBox.max.z - geometry.boundingBox.min.z);
      }
      return greatest;
    });
    return { coloured, size, words: await page.textContent("#envelope-words") };
  };
  const none = await seen("none");
  assert.deepEqual([none.size, none.words], [0, ""]);
  let before = none;
  for (const percent of ["50", "90", "100"]) {
    const now = await seen(percent);
    assert.ok(now.coloured > before.coloured && now.size >= before.size, `${percent} %: ${JSON.stringify([before, now])}`);
    assert.equal(now.words, "24 points, at the end of step equilibrium");
    before = now;
  }
  await page.screenshot({ path: `${shots}studio-envelope.png` });
  const swept = await seen("swept");
  assert.ok(swept.coloured > 2 * none.coloured, JSON.stringify([none, swept]));
  assert.equal(swept.words, "at all points, in all steps");
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);

  // Without the flag there is nothing to choose; a folder without an envelope is refused with what would be right.
  const plain = await studio(file);
  const { page: without } = await opened(plain.address);
  assert.equal(await without.isVisible("#envelope-row"), false);
  await without.close();
  await plain.stop();
  const refused = spawnSync(program, ["studio", file, "--no-open", "--envelope", folder], { encoding: "utf8", env: environment() });
  assert.equal(refused.status, 1);
  assert.match(refused.stderr, /has no envelope: it is the folder of a sweep/);
  const asRun = spawnSync(program, ["studio", out, "--no-open"], { encoding: "utf8", env: environment() });
  assert.match(asRun.stderr, /holds a sweep: open its scenario, with its envelope: wireloom studio FILE --envelope/);
});

test("a scenario that gives an accuracy is shown on the mesh of its run, and the page says so", { skip: absent }, async () => {
  const file = scenario("first.toml");
  const text = readFileSync(file, "utf8").replaceAll(/^(segments|max_segment) = .*\n/gm, "");
  writeFileSync(file, text.replace("\n[sections", '\n[mesh]\naccuracy = "0.1 %"\n\n[sections'));
  const { address, stop } = await studio(file);
  const { page, found } = await opened(address);
  const notes = await page.evaluate(() => window.wireloom.store.scene.notes);
  assert.ok(notes.some((note) => note.startsWith("mesh for an accuracy of 0.1 %: ")), notes.join());
  const out = join(folder, "accuracy.out");
  const run = spawnSync(program, ["run", file, "--out", out, "--quiet"], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stdout + run.stderr);
  const last = JSON.parse(readFileSync(join(out, "result.json"), "utf8")).steps.at(-1);
  const own = Object.fromEntries(Object.entries(last.branches).map(([branch, { position }]) => [branch, position]));
  assert.ok(distance(await shape(page), own) < 1e-6);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

test("a slider opens a door, and what is mounted on it goes along", { skip: absent }, async () => {
  const { address, stop } = await studio(scenario("mechanisms/door.toml"));
  const { page, found } = await opened(address);
  const slider = page.getByRole("slider", { name: "front door/hinge, degrees" });
  // Its steps have opened the door and shut it again.
  assert.equal(await slider.inputValue(), "0");
  assert.deepEqual(await slider.evaluate((input) => [input.min, input.max]), ["0", "75"]);
  await slider.evaluate((input) => {
    input.value = "60";
    input.dispatchEvent(new Event("change"));
  });
  await page.waitForFunction(() => window.wireloom.store.shown?.header.step === "drive front door/hinge", null, { timeout: 30_000 });
  await quiet(page);
  const [x, y] = await position(page, "door plug");
  const angle = Math.PI / 3;
  assert.ok(Math.abs(x - (0.1 + 0.2 * Math.cos(angle) + 0.02 * Math.sin(angle))) < 1e-9 && Math.abs(y - (0.2 * Math.sin(angle) - 0.02 * Math.cos(angle))) < 1e-9, `${x}, ${y}`);
  assert.equal(await page.locator("output", { hasText: "60" }).count(), 1);
  await settled(page);
  await page.screenshot({ path: `${shots}door.png` });
  assert.deepEqual(found, []);
  await page.close();
  await stop();
});
