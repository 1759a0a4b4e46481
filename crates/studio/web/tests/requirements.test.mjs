// Requirements on a page that replays a run: the verdict, all that fails, the worst of it, and what it looks like.
import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { faults, launch, local, newPage, pixels, settled, shots } from "./browser.mjs";
import { HOSTILE, line, made, page as replay, violation } from "./recording.mjs";

let browser;

before(async () => (browser = await launch()));
after(() => browser?.close());

const BEND = { name: "left bend", verdict: "fail", worst: 0.0033312, margin: -0.933, step: "lift further", increment: 12, frame: 24, place: { branch: HOSTILE, s: 0.38 }, because: "VW 60306" };
const REACH = { name: "spans are long enough", origin: "always", measure: "reach", unit: "", verdict: "fail", worst: 1.3123, limit: 1, bound: "max", margin: -0.312, step: "lift further", increment: 5, frame: 17, place: { branch: "right", s: 0.2 } };
const OVERLAP = { name: "cables lie side by side", origin: "always", measure: "overlap", verdict: "fail", worst: 0.0126, limit: 0.0008, bound: "max", margin: -14.75, step: "lift", increment: 2, frame: 2, place: { branch: "trunk", s: 0.3, other_branch: "right", other_s: 0.1 } };
const TENSION = { name: "wires of right", origin: "section", measure: "tension", unit: "N", verdict: "fail", worst: 11873, limit: 450, bound: "max", margin: -25.4, place: { branch: "right", s: 0.4 } };
const SHOULD = { name: "plug-C", measure: "force", unit: "N", severity: "should", verdict: "fail", worst: 50, limit: 40, bound: "max", margin: -0.25, place: { constraint: "plug-C" } };
const UNRESOLVED = { name: "slack at C", measure: "slack", verdict: "unresolved", worst: 0.0101, limit: 0.01, error: 0.0003, margin: 0.01, reason: "the discretisation error reaches over the limit", place: { branch: "right", s: 0.3 } };
const PASS = { name: "plug-A", measure: "moment", unit: "N m", worst: 5.91e-17, limit: 0.2, bound: "max", margin: 1, place: { constraint: "plug-A" } };

async function opened(recording, options = {}) {
  const file = join(mkdtempSync(join(tmpdir(), "wireloom-requirements-")), "replay.html");
  writeFileSync(file, replay(made(recording)));
  const page = await newPage(browser, options);
  const found = faults(page);
  await page.goto(local(file));
  await page.waitForFunction(() => window.wireloom?.store.shown?.header.frame === 24);
  // Where things are on the screen is known once they are drawn.
  await settled(page);
  return { page, found };
}

test("all that fails is listed from the first frame on, in the order of the sheet, beside a solver that has converged", async () => {
  const lines = [OVERLAP, BEND, REACH, UNRESOLVED, SHOULD, PASS].map(line);
  const { page, found } = await opened({ lines });
  await page.keyboard.press("Home");
  assert.equal(await page.evaluate(() => window.wireloom.store.shown.header.frame), 0);
  const listed = await page.locator("#sheet .lines > li").allInnerTexts();
  const words = ["overlap of cables 12.6 mm, at most 0.800 mm", "bend radius 3.33 mm, at least 50.0 mm", "stretch 1.31 × its length, at most 1.00 × its length", "slack 10.1 mm, at least 10.0 mm", "force 50.0 N, at most 40.0 N"];
  assert.equal(listed.length, words.length);
  words.forEach((expected, k) => assert.ok(listed[k].replaceAll(/\s+/g, " ").includes(expected), `${expected} in ${listed[k]}`));
  const whole = listed.join("\n");
  for (const expected of ["−93.3 %", `left bend · ${HOSTILE} at s = 380 mm · step lift further, increment 12 · VW 60306`, "the discretisation error reaches over the limit", "should"]) assert.ok(whole.includes(expected), expected);
  assert.equal(await page.locator("#sheet h2").innerText(), "Requirements FAIL");
  assert.equal(await page.locator("#verdict").innerText(), "FAIL: 3 of 5 requirements fail");
  assert.match(await page.getByLabel("Solver").innerText(), /solver\s+converged/);
  assert.equal(await page.getByLabel("Solver").locator(".good").count(), 0, "what has converged is not green");
  await page.screenshot({ path: `${shots}requirements-start.png` });
  assert.deepEqual(found, []);
  await page.close();
});

test("a line of the sheet leads to its frame and its place", async () => {
  const { page, found } = await opened({ lines: [OVERLAP, REACH, SHOULD].map(line) });
  for (const [words, frame, branch, s] of [["overlap of cables", 2, 0, 0.3], ["stretch", 17, 2, 0.2]]) {
    await page.locator("#sheet .lines button", { hasText: words }).click();
    await page.waitForFunction((frame) => window.wireloom.store.shown.header.frame === frame, frame);
    await settled(page);
    const at = await page.evaluate(([branch, s]) => {
      const { store, hands, toScreen } = window.wireloom;
      const node = 61 * branch + Math.round((s / store.scene.branches[branch].length) * 60);
      return { chosen: hands.chosen, ...toScreen([0, 1, 2].map((axis) => store.shown.nodes[window.wireloom.floats * node + axis])) };
    }, [branch, s]);
    const box = await page.locator("#stage").boundingBox();
    const off = Math.hypot(at.x - box.x - box.width / 2, at.y - box.y - box.height / 2);
    assert.ok(off < 20, `the place is ${off} pixels beside the centre of the picture`);
    assert.deepEqual(at.chosen, { is: "point", branch: ["trunk", HOSTILE, "right"][branch], s });
  }
  await page.locator("#sheet .lines button", { hasText: "force" }).click();
  assert.equal(await page.evaluate(() => window.wireloom.hands.constraintName()), "plug-C");
  assert.deepEqual(found, []);
  await page.close();
});

test("the banner says the worst, not the first: what is stretched comes before what bends too tightly", async () => {
  const violations = (frame) => (frame === 24 ? [violation(BEND)] : []);
  const { page, found } = await opened({ lines: [BEND, REACH, SHOULD].map(line), violations });
  const banner = page.locator("#warning");
  const rows = await banner.locator("> div").allInnerTexts();
  assert.match(rows[0].replaceAll(/\s+/g, " "), /^FAIL over-stretched: 1\.31 × its length, at most 1\.00 × its length; right at s = 200 mm, step lift further and 2 more$/);
  assert.match(rows[1].replaceAll(/\s+/g, " "), /^in this frame too tight: 3\.33 mm, at least 50\.0 mm/);
  await banner.getByRole("button", { name: "over-stretched", exact: false }).click();
  assert.equal(await page.evaluate(() => window.wireloom.store.shown.header.frame), 17);
  assert.deepEqual(found, []);
  await page.close();
});

test("cables in each other and forces above what wires bear dominate a solver that has not converged", async () => {
  const { page, found } = await opened({ lines: [TENSION, BEND].map(line), status: "iteration limit" });
  const rows = await page.locator("#warning > div").allInnerTexts();
  assert.match(rows[0].replaceAll(/\s+/g, " "), /^FAIL overloaded in tension: 11 873 N, at most 450 N; right at s = 400 mm/);
  assert.ok(await page.locator("#warning.destroyed").count());
  await page.close();
  const overlap = await opened({ lines: [BEND, OVERLAP].map(line) });
  assert.match(await overlap.page.locator("#warning > div").first().innerText(), /cables pass through each other: 12\.6 mm/);
  await overlap.page.close();
  assert.deepEqual([...found, ...overlap.found], []);
});

test("a stretched branch is hatched, whatever the scale, and the legend says what that means", async () => {
  const violations = (frame) => (frame < 12 ? [] : [violation(REACH)]);
  const { page, found } = await opened({ lines: [line(REACH)], violations });
  await page.locator("#labels-on").click();
  await page.locator("#arrows-on").click();
  const picture = async (path) => {
    await page.locator("#legend, #warning").evaluateAll((all) => all.forEach((each) => (each.style.visibility = "hidden")));
    await settled(page);
    const png = await page.locator("#stage canvas").screenshot({ path });
    await page.locator("#legend, #warning").evaluateAll((all) => all.forEach((each) => (each.style.visibility = "")));
    return pixels(browser, png);
  };
  await page.keyboard.press("Home");
  // A clip is orange, too.
  const { orange: clip } = await picture(`${shots}requirements-loose.png`);
  await page.keyboard.press("End");
  for (const quantity of ["bend", "tension", "torque"]) {
    await page.locator("#quantity").selectOption(quantity);
    const { orange } = await picture(`${shots}requirements-${quantity}.png`);
    assert.ok(orange > clip + 300, `${orange} pixels are orange, and ${clip} where nothing is stretched`);
    assert.match(await page.locator("#legend").textContent(), /over-stretched, overloaded or in another cable/);
  }
  await page.keyboard.press("Home");
  await settled(page);
  assert.doesNotMatch(await page.locator("#legend").textContent(), /over-stretched/);
  assert.deepEqual(found, []);
  await page.close();
});

test("only the part of a branch that is stretched is hatched", async () => {
  const counts = [];
  for (const [from, to] of [[0.1, 0.2], [0, 10]]) {
    const stretches = [{ branch: "right", from, to }];
    const { page, found } = await opened({ lines: [line(REACH)], violations: () => [violation({ ...REACH, stretches })] });
    await page.locator("#labels-on").click();
    await page.locator("#arrows-on").click();
    await page.locator("#legend, #warning").evaluateAll((all) => all.forEach((each) => (each.style.visibility = "hidden")));
    await settled(page);
    counts.push((await pixels(browser, await page.locator("#stage canvas").screenshot({ path: `${shots}requirements-to-${to}.png` }))).orange);
    assert.deepEqual(found, []);
    await page.close();
  }
  const [part, whole] = counts;
  assert.ok(part > 100 && whole > 1.5 * part, `${part} pixels are orange on a part of the branch, ${whole} on all of it`);
});

test("pass, unresolved and no equilibrium are three things", async () => {
  const passed = await opened({ lines: [line(PASS)], verdict: "pass" });
  assert.equal(await passed.page.locator("#verdict").innerText(), "PASS: 1 of 1 requirements pass");
  assert.ok(!/FAIL|UNRESOLVED/.test(await passed.page.locator("#warning").innerText()));
  await passed.page.locator("#sheet summary").click();
  assert.match(await passed.page.locator("#sheet").innerText(), /moment 0 N mm, at most 200 N mm/);
  await passed.page.close();
  const open = await opened({ lines: [UNRESOLVED, PASS].map(line), verdict: "unresolved" });
  assert.equal(await open.page.locator("#sheet h2").innerText(), "Requirements UNRESOLVED");
  assert.match(await open.page.locator("#warning").innerText(), /UNRESOLVED\s+1 of 2 requirements undecided/);
  await open.page.close();
  const colours = new Set();
  for (const verdict of ["pass", "fail", "unresolved"]) {
    const { page } = await opened({ lines: [line(PASS)], verdict });
    colours.add(await page.locator("#verdict").evaluate((chip) => getComputedStyle(chip).backgroundColor));
    await page.close();
  }
  assert.equal(colours.size, 3);
});

test("no number has an exponent, and round-off is 0", async () => {
  const { page } = await opened({ lines: [line(PASS)], verdict: "pass", noise: 5.91e-17 });
  for (let k = 0; k < 4; k++) {
    await page.keyboard.press("n");
    assert.doesNotMatch(await page.locator("#panels").innerText(), /\d[eE][+−-]?\d/);
  }
  const place = await page.evaluate(() => {
    const { store, toScreen } = window.wireloom;
    return toScreen([0, 1, 2].map((axis) => store.shown.nodes[window.wireloom.floats * 20 + axis]));
  });
  await page.mouse.move(place.x, place.y);
  const over = await page.locator("#over").innerText();
  assert.match(over, /torque 0 N mm/);
  assert.doesNotMatch(over, /\d[eE][+−-]?\d/);
  await page.close();
});
