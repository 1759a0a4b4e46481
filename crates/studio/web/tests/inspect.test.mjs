// Looking at a harness: parts hidden and found by name, a cut, measures, the range of the colours. On a page that replays a made-up run,
// whose shape is known.
import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { axed, faults, launch, local, newPage, pixels, poorContrast, settled, shots } from "./browser.mjs";
import { HOSTILE, made, page as replay } from "./recording.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser?.close());

async function opened(options = {}) {
  const file = join(mkdtempSync(join(tmpdir(), "wireloom-inspect-")), "replay.html");
  writeFileSync(file, replay(made()));
  const page = await newPage(browser, options);
  const found = faults(page);
  await page.goto(local(file));
  await page.waitForFunction(() => window.wireloom?.store.shown?.header.frame === 24);
  await page.evaluate(() => document.querySelectorAll("#panels details").forEach((each) => (each.open = ["parts", "measure"].some((id) => each.contains(document.getElementById(id))))));
  // Where things are on the screen is known once they are drawn.
  await settled(page);
  return { page, found };
}

/** How many pixels of the harness are coloured, without what lies over the picture. */
const coloured = async (page) => {
  await page.evaluate(() => document.querySelectorAll("#stage > :not(canvas)").forEach((each) => (each.style.visibility = "hidden")));
  await settled(page);
  const png = await page.locator("#stage canvas").screenshot();
  await page.evaluate(() => document.querySelectorAll("#stage > :not(canvas)").forEach((each) => (each.style.visibility = "")));
  return (await pixels(browser, png)).coloured;
};
const choose = (page, chosen) => page.evaluate((chosen) => window.wireloom.hands.choose(chosen), chosen);
const measured = (page) => page.locator("#measured").evaluate((list) => Object.fromEntries([...list.querySelectorAll("dt")].map((name) => [name.textContent, name.nextElementSibling.textContent])));

test("parts are found by name and pattern, hidden, isolated and shown again", async () => {
  const { page, found } = await opened();
  const all = await coloured(page);
  assert.match(await page.locator("#parts [role=status]").innerText(), /^9 of 9 parts$/);
  await page.locator("#find-part").fill("plug");
  assert.match(await page.locator("#parts [role=status]").innerText(), /^2 of 9 parts$/);
  await page.locator("#find-part").fill("plug-?");
  assert.equal(await page.locator("#parts li").count(), 2);
  await page.locator("#find-part").fill("trunk*");
  await page.locator("#only-found").click();
  assert.match(await page.locator("#parts [role=status]").innerText(), /8 hidden/);
  const isolated = await coloured(page);
  assert.ok(isolated < 0.8 * all && isolated > 0.1 * all, `${isolated} of ${all} pixels`);
  // What is not to be seen cannot be chosen with the mouse, nor by the keyboard.
  const place = await page.evaluate(() => window.wireloom.toScreen([0, 1, 2].map((axis) => window.wireloom.store.shown.nodes[(61 * 2 + 30) * window.wireloom.floats + axis])));
  await page.mouse.click(place.x, place.y);
  assert.equal(await page.evaluate(() => window.wireloom.hands.chosen), null);
  await page.locator("#show-all").click();
  assert.equal(await coloured(page), all);
  await page.locator("#hide-found").click();
  assert.ok((await coloured(page)) < all);
  await page.getByLabel("Show branch trunk").check();
  assert.equal(await coloured(page), all);
  // A name leads to its part; a name that would be markup is text.
  await page.locator("#find-part").fill("onerror");
  await page.locator("#parts li button").click();
  assert.deepEqual(await page.evaluate(() => window.wireloom.hands.chosen), { is: "point", branch: HOSTILE, s: 0.2 });
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.ok((await page.locator("#parts li").innerText()).includes(HOSTILE));
  await page.screenshot({ path: `${shots}inspect-parts.png` });
  assert.deepEqual(found, []);
  await page.close();
});

test("a cut shows one side of a plane", async () => {
  const { page, found } = await opened();
  const all = await coloured(page);
  await page.locator("#section-axis").selectOption("x");
  assert.match(await page.locator("#section-words").innerText(), /^x ≤ \d+\.?\d* mm is shown$/);
  const left = await coloured(page);
  await page.locator("#section-side").check();
  assert.match(await page.locator("#section-words").innerText(), /^x ≥ /);
  const right = await coloured(page);
  assert.ok(left > 0.1 * all && right > 0.1 * all && left + right < 1.2 * all, `${left} and ${right} of ${all} pixels`);
  await page.locator("#section-at").evaluate((input) => {
    input.value = "1";
    input.dispatchEvent(new Event("input"));
  });
  const end = await coloured(page);
  assert.ok(end < 0.3 * right, `${end} of ${right} pixels are left at the end`);
  await page.screenshot({ path: `${shots}inspect-cut.png` });
  await page.locator("#section-axis").selectOption("");
  assert.equal(await coloured(page), all);
  assert.deepEqual(found, []);
  await page.close();
});

test("two places have a distance, an arc length, an angle and a clearance", async () => {
  const { page, found } = await opened();
  await page.locator("#stage").focus();
  await page.keyboard.press("m");
  assert.equal(await page.locator("#measure-on").getAttribute("aria-pressed"), "true");
  await choose(page, { is: "point", branch: "trunk", s: 0.15 });
  await choose(page, { is: "point", branch: "trunk", s: 0.45 });
  const own = await measured(page);
  // The curve of the recording: x = 0.6 u, y = 0.02 sin 6u, z = -0.072 sin πu, at u = 1/4 and 3/4.
  const curve = (u) => [0.6 * u, 0.02 * Math.sin(6 * u), -0.072 * Math.sin(Math.PI * u)];
  const by = curve(0.75).map((x, k) => x - curve(0.25)[k]);
  assert.ok(Math.abs(Number.parseFloat(own.distance) - 1000 * Math.hypot(...by)) < 0.06, own.distance);
  assert.equal(own["arc length"], "300.0 mm");
  assert.ok(Math.abs(Number.parseFloat(own["least clearance"]) - (50 - 45)) < 0.1 && own["least clearance"].endsWith("at s = 300.0 mm"), own["least clearance"]);
  const slope = (u) => [0.6, 0.12 * Math.cos(6 * u), -0.072 * Math.PI * Math.cos(Math.PI * u)];
  const [p, q] = [slope(0.25), slope(0.75)];
  const angle = (Math.acos(p.reduce((sum, x, k) => sum + x * q[k], 0) / Math.hypot(...p) / Math.hypot(...q)) * 180) / Math.PI;
  // Between nodes, not of the curve: half a segment off, 0.8 degrees here.
  assert.ok(Math.abs(Number.parseFloat(own["angle of the cables"]) - angle) < 1, `${own["angle of the cables"]}, ${angle}`);
  // It follows the frames; a place that is not there is told.
  await choose(page, { is: "constraint", name: "hand" });
  assert.match((await measured(page)).to, /^hand$/);
  await page.locator("#stage").focus();
  await page.keyboard.press("Home");
  await page.waitForFunction(() => window.wireloom.store.shown.header.frame === 0);
  // The hand does not act yet: its place on the cable, at 0.95 of the arm, which lies flat in this frame.
  const first = await measured(page);
  const apart = [0.6 + 0.3 * 0.95, 0.25 * 0.95 ** 2, 0].map((x, k) => x - curve(0.75)[k]);
  assert.equal(first.to, "hand");
  assert.ok(Math.abs(Number.parseFloat(first.distance) - 1000 * Math.hypot(...apart)) < 0.06, first.distance);
  // Without a place on a cable there is nothing to measure to.
  await page.evaluate(() => (window.wireloom.store.scene.constraints.find(({ name }) => name === "hand").place = null));
  await choose(page, { is: "constraint", name: "hand" });
  assert.equal((await measured(page)).to, "hand (not there in this frame)");
  await page.keyboard.press("End");
  await page.waitForFunction(() => window.wireloom.store.shown.header.frame === 24);
  assert.equal((await measured(page)).to, "hand");
  await settled(page);
  await page.screenshot({ path: `${shots}inspect-measure.png` });
  await page.locator("#measure-clear").click();
  assert.deepEqual(await measured(page), { "": "Choose the first place." });
  await page.locator("#measure-on").click();
  await choose(page, { is: "point", branch: "trunk", s: 0.1 });
  assert.deepEqual(await measured(page), {});
  assert.deepEqual(found, []);
  await page.close();
});

test("the range of the colours is typed, kept for its quantity, and found again", async () => {
  const { page, found } = await opened();
  assert.equal(await page.locator("#range").isVisible(), false, "bend radii are coloured by their limits");
  await page.locator("#quantity").selectOption("tension");
  const automatic = await page.locator("#range-high").inputValue();
  await page.locator("#range-low").fill("1");
  await page.locator("#range-low").blur();
  await page.locator("#range-high").fill("2");
  await page.locator("#range-high").blur();
  assert.match(await page.locator("#scale .ticks").innerText(), /1\.00 N[\s\S]*2\.00 N/);
  await page.locator("#quantity").selectOption("moment");
  await page.locator("#quantity").selectOption("tension");
  assert.equal(await page.locator("#range-high").inputValue(), "2");
  await page.locator("#range-high").fill("0");
  await page.locator("#range-high").blur();
  assert.match(await page.locator("#scale .ticks").innerText(), /2\.00 N/, "what is no range changes nothing");
  await page.locator("#range-auto").click();
  assert.equal(await page.locator("#range-high").inputValue(), automatic);
  assert.deepEqual(found, []);
  await page.close();
});

test("what stays bent is a colour, a number at a point and a plot; of an elastic cable it is 0", async () => {
  const { page, found } = await opened();
  await page.locator("#quantity").selectOption("set");
  assert.match(await page.locator("#scale").innerText(), /Bend that would remain without a moment/);
  const at = async (branch, s) => {
    await choose(page, { is: "point", branch, s });
    return page.locator("#panels dl.facts").evaluateAll((lists) => [...lists.flatMap((list) => [...list.querySelectorAll("dt")])].find((name) => name.textContent === "set").nextElementSibling.textContent);
  };
  assert.equal(await at("trunk", 0.3), "0 rad/m");
  assert.match(await page.locator("#panels svg.plot[aria-label^='Set, rad/m']").getAttribute("aria-label"), /along trunk/);
  assert.equal(await at("right", 0.2), "0.750 rad/m");
  assert.deepEqual(found, []);
  await page.close();
});

test("strains are colours with a legend in percent, and round-off is no strain", async () => {
  const { page, found } = await opened();
  await page.locator("#quantity").selectOption("stretch");
  const high = Number(await page.locator("#range-high").inputValue());
  assert.ok(high >= 0.1 && high <= 0.15, `2e-4 times 5: ${high} %`);
  assert.equal(await page.locator("#range-unit").innerText(), "%");
  assert.match(await page.locator("#scale .ticks").innerText(), /^−0\.1[\d]* %\s+0\s+0\.1[\d]* %$/, "signed: its middle is 0");
  assert.match(await page.locator("#scale").innerText(), /longer than unstressed/);
  await page.locator("#quantity").selectOption("surface");
  await settled(page);
  await page.screenshot({ path: `${shots}inspect-strain.png` });
  assert.match(await page.locator("#scale").innerText(), /Half the diameter over the bend radius/);
  // At a point: half the diameter times the curvature, beside the bend radius there.
  await choose(page, { is: "point", branch: "trunk", s: 0.3 });
  const facts = await page.locator("#panels dl.facts").evaluateAll((lists) => Object.fromEntries(lists.flatMap((list) => [...list.querySelectorAll("dt")].map((name) => [name.textContent, name.nextElementSibling.textContent]))));
  const radius = Number.parseFloat(facts["bend radius"].replace(/[^\d.]/g, "")) * (facts["bend radius"].endsWith(" mm") ? 1e-3 : 1);
  assert.ok(Math.abs(Number.parseFloat(facts["bending strain at the surface"]) / ((100 * 0.006) / radius) - 1) < 0.01, JSON.stringify(facts));
  assert.match(facts.stretch, / %$/);
  assert.match(await page.locator("#panels svg.plot[aria-label^='Stretch, %']").getAttribute("aria-label"), /along trunk/);
  assert.deepEqual(await poorContrast(page), []);
  assert.deepEqual(found, []);
  await page.close();

  const file = join(mkdtempSync(join(tmpdir(), "wireloom-inspect-")), "noise.html");
  writeFileSync(file, replay(made({ noise: 3e-9 })));
  const quiet = await newPage(browser);
  await quiet.goto(local(file));
  await quiet.waitForFunction(() => window.wireloom?.store.shown?.header.frame === 24);
  for (const quantity of ["tension", "stretch", "torque"]) {
    await quiet.locator("#quantity").selectOption(quantity);
    // One colour: that of 0.
    assert.equal(await quiet.evaluate(() => window.wireloom.colours().length), 1, quantity);
  }
  await quiet.close();
});

test("its controls are accessible in light and dark", async () => {
  for (const colorScheme of ["light", "dark"]) {
    const { page, found } = await opened({ colorScheme });
    await page.locator("#quantity").selectOption("tension");
    await page.locator("#section-axis").selectOption("z");
    assert.deepEqual(await poorContrast(page), []);
    assert.deepEqual(await axed(page), []);
    assert.deepEqual(found, []);
    await page.close();
  }
});
