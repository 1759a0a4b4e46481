// A page that replays a run, in a browser: what is drawn, played, chosen, and what names from outside can do.
import assert from "node:assert/strict";
import { copyFileSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { after, before, test } from "node:test";
import { downloaded, faults, launch, local, newPage, pixels, poorContrast, settled, shots } from "./browser.mjs";
import { HOSTILE, made, page as replay } from "./recording.mjs";

let browser;
let address;

before(async () => {
  browser = await launch();
  const file = join(mkdtempSync(join(tmpdir(), "wireloom-replay-")), "replay.html");
  writeFileSync(file, replay(made()));
  address = local(file);
});

after(() => browser?.close());

async function opened(options = {}) {
  const page = await newPage(browser, options);
  const found = faults(page);
  await page.goto(address);
  await page.waitForFunction(() => window.wireloom?.store.shown?.header.frame === 24);
  // Where things are on the screen is known once they are drawn.
  await settled(page);
  return { page, found };
}

const stage = (page) => page.locator("#stage canvas");

test("a run is shown, hatched where it bends too tightly, and names do no harm", async () => {
  const { page, found } = await opened();
  await page.locator("#labels-on").click();
  await page.locator("#legend").evaluate((legend) => (legend.hidden = true));
  await settled(page);
  const tight = await pixels(browser, await stage(page).screenshot({ path: `${shots}replay-end.png` }));
  assert.ok(tight.coloured > 3000, `${tight.coloured} pixels have a colour`);
  assert.ok(tight.magenta > 200, `${tight.magenta} pixels are hatched`);
  assert.match(await page.locator("#warning").innerText(), /FAIL\s+too tight: 3\.33 mm, at least 50\.0 mm/);
  assert.ok((await page.locator("#warning").innerText()).includes(HOSTILE));
  await page.locator("#track").focus();
  await page.keyboard.press("Home");
  assert.equal(await page.evaluate(() => window.wireloom.store.shown.header.frame), 0);
  await settled(page);
  const loose = await pixels(browser, await stage(page).screenshot({ path: `${shots}replay-start.png` }));
  assert.ok(loose.coloured > 3000);
  assert.equal(loose.magenta, 0, `${loose.magenta} pixels are hatched where no bend is too tight`);
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator("#panels img, #labels img").count(), 0);
  assert.deepEqual(found, []);
  await page.close();
});

test("playing goes through all frames and stops at the end", async () => {
  const { page, found } = await opened();
  await page.evaluate(() => {
    window.seen = [];
    window.wireloom.store.on("shown", (frame) => window.seen.push(frame.header.frame));
  });
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.seen.at(-1) === 24 && window.seen.includes(0));
  const seen = await page.evaluate(() => window.seen);
  assert.deepEqual(seen, [...seen].sort((a, b) => a - b));
  assert.equal(await page.getByRole("button", { name: "Play", exact: false }).innerText(), "▶ Play");
  await page.keyboard.press("<");
  assert.equal(await page.evaluate(() => window.wireloom.store.shown.header.frame), 12);
  assert.deepEqual(found, []);
  await page.close();
});

test("joints of mechanisms are listed with their values, and a finished run does not drive them", async () => {
  const { page, found } = await opened();
  const mechanisms = page.locator("details", { hasText: "Mechanisms" });
  assert.match(await mechanisms.innerText(), /door\/hinge\s+57\.30 °\s+door\/strut\s+50\.00 mm/);
  assert.equal(await mechanisms.locator("input:enabled").count(), 0);
  await page.locator("#track").focus();
  await page.keyboard.press("Home");
  assert.match(await mechanisms.innerText(), /door\/hinge\s+0 °\s+door\/strut\s+0 mm/);
  assert.deepEqual(found, []);
  await page.close();
});

test("a click on a cable looks closer at that point", async () => {
  const { page, found } = await opened();
  const place = await page.evaluate(() => {
    const { store, toScreen } = window.wireloom;
    const node = 61 * 2 + 30;
    return toScreen([0, 1, 2].map((axis) => store.shown.nodes[node * window.wireloom.floats + axis]));
  });
  await page.mouse.move(place.x, place.y);
  assert.match(await page.locator("#over").innerText(), /right, s = 200.*bend radius/s);
  await page.mouse.click(place.x, place.y);
  const chosen = page.locator("details", { hasText: "Chosen" }).first();
  assert.match(await chosen.innerText(), /right at s = 200/);
  assert.equal(await page.locator(".plot").count(), 7);
  const label = await page.locator(".plot").nth(1).getAttribute("aria-label");
  assert.match(label, /^Tension, N along right: 3\.5\d N at 200/);
  assert.equal(await page.getByRole("button", { name: "Hold" }).count(), 0, "a finished run has no hands");
  await page.screenshot({ path: `${shots}replay-point.png` });
  assert.deepEqual(found, []);
  await page.close();
});

test("keys choose constraints and points, look from sides, keep a ghost and measure against it", async () => {
  const { page, found } = await opened();
  await page.keyboard.press("n");
  assert.match(await page.locator("#said").innerText(), /plug-A is chosen/);
  await page.keyboard.press("n");
  assert.match(await page.locator("#said").innerText(), /clip is chosen/);
  await page.keyboard.press("Alt+ArrowRight");
  assert.match(await page.locator("#said").innerText(), /trunk at 310/);
  await page.keyboard.press("k");
  await page.keyboard.press("Home");
  assert.match(await page.locator("#difference").innerText(), new RegExp("largest distance\\s+255 mm on <img"));
  await page.keyboard.press("2");
  assert.equal(await page.locator("#projection").getAttribute("aria-pressed"), "true");
  await page.keyboard.press("b");
  assert.equal(await page.locator("#quantity").inputValue(), "tension");
  await settled(page);
  await page.screenshot({ path: `${shots}replay-top-ghost.png` });
  await page.keyboard.press("?");
  assert.match(await page.locator("#keys").innerText(), /Choose the next constraint/);
  assert.doesNotMatch(await page.locator("#keys").innerText(), /Undo/);
  await page.screenshot({ path: `${shots}replay-keys.png` });
  await page.keyboard.press("Escape");
  const file = await downloaded(page, () => page.keyboard.press("s"));
  assert.equal(basename(file), "made-up-0.png");
  copyFileSync(file, `${shots}replay-picture.png`);
  const picture = await pixels(browser, readFileSync(file));
  assert.ok(picture.coloured > 3000 && picture.width > 900, JSON.stringify(picture));
  assert.deepEqual(found, []);
  await page.close();
});

for (const [width, height, colorScheme] of [
  [1024, 700, "dark"],
  [1024, 768, "light"],
  [3840, 2160, "light"],
]) {
  test(`nothing sticks out at ${width} × ${height}, ${colorScheme}`, async () => {
    const { page, found } = await opened({ viewport: { width, height }, colorScheme });
    await page.keyboard.press("n");
    await settled(page);
    await page.screenshot({ path: `${shots}replay-${width}x${height}-${colorScheme}.png` });
    const out = await page.evaluate(() =>
      [...document.querySelectorAll("header *, aside *, footer *, #tools *, #legend *")]
        .filter((each) => each.checkVisibility() && !each.closest("#track"))
        .filter((each) => {
          const box = each.getBoundingClientRect();
          return box.left < -1 || box.right > innerWidth + 1;
        })
        .map((each) => each.outerHTML.slice(0, 80)),
    );
    assert.deepEqual(out, []);
    assert.ok((await page.locator("#stage").boundingBox()).width > 0.55 * width);
    assert.deepEqual(found, []);
    await page.close();
  });
}

/** Contrast of words and what is behind them, WCAG 2: every leaf with words in it. */
for (const colorScheme of ["light", "dark"]) {
  test(`words can be read, ${colorScheme}`, async () => {
    const { page } = await opened({ colorScheme });
    await page.keyboard.press("n");
    assert.deepEqual(await poorContrast(page), []);
    // Under the mouse, too: in the banner, in the sheet, in the bars.
    for (const button of await page.locator("#warning button, #sheet .lines button, #verdict, #tools button, header button, #panels li > button").all()) {
      if (!(await button.isVisible()) || (await button.isDisabled())) continue;
      await button.hover({ force: true });
      const under = await button.evaluate((each) => (each.matches(":hover") ? each.textContent : null));
      if (under !== null) assert.deepEqual(await poorContrast(page), [], `with the mouse on ${under}`);
    }
    await page.close();
  });
}

test("a page is drawn with its policy, and breaks none of it", async () => {
  const file = join(mkdtempSync(join(tmpdir(), "wireloom-policy-")), "policy.html");
  writeFileSync(file, replay(made({})));
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  const found = faults(page);
  await page.goto(`file://${file}`);
  await page.locator("#sheet h2").first().waitFor();
  await page.waitForTimeout(500);
  const picture = await pixels(browser, await page.screenshot({ path: `${shots}replay-policy.png` }));
  assert.ok(picture.coloured > 3000, JSON.stringify(picture));
  assert.deepEqual(found, []);
  await page.close();
});

test("4,000 nodes are drawn in place: frames leave nothing behind on the graphics card", async () => {
  const file = join(mkdtempSync(join(tmpdir(), "wireloom-large-")), "large.html");
  writeFileSync(file, replay(made({ frames: 14, nodes: 1334 })));
  const page = await newPage(browser);
  const found = faults(page);
  await page.goto(local(file));
  await page.waitForFunction(() => window.wireloom?.store.shown?.header.frame === 13);
  const buffers = () => page.evaluate(() => window.wireloom.memory());
  await settled(page);
  const before = await buffers();
  const frames = await page.evaluate(() => {
    for (let turn = 0; turn < 3; turn++) for (let frame = 0; frame < 14; frame++) window.wireloom.store.scrub(frame);
    return window.wireloom.store.shown.header.frame;
  });
  assert.equal(frames, 13);
  await settled(page);
  assert.deepEqual(await buffers(), before, "nothing new on the graphics card");
  assert.deepEqual(found, []);
  await page.close();
});
