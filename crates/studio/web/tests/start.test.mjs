// The start page with the program behind it, in a browser: examples, recent files, a new harness, paths, files that are dropped, an import of
// KBL whose findings are flown to, and what is refused.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, unlinkSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { after, before, test } from "node:test";
import { axed, faults, launch, newPage, poorContrast, settled, shots } from "./browser.mjs";
import { absent, endAll, folder, program, quiet, root, scenario, startPage } from "./program.mjs";

const small = join(root, "crates/import/tests/small.kbl");

let browser;
before(async () => (browser = await launch()));
after(async () => {
  endAll();
  await browser?.close();
});

/** A start page in a folder of its own. */
async function started(options = {}, at = mkdtempSync(join(folder, "start-"))) {
  const server = await startPage(at);
  const page = await newPage(browser, options);
  const found = faults(page);
  await page.goto(server.address);
  await page.waitForSelector("#start:not([hidden])");
  return { ...server, page, found, at };
}

/** Gives a file to the page as a drop does. */
async function drop(page, name, content) {
  await page.evaluate(
    ([name, content]) => {
      const data = new DataTransfer();
      data.items.add(new File([typeof content === "string" ? content : new Uint8Array(content)], name));
      document.getElementById("start").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    },
    [name, content],
  );
}

/** The drafts that a start page offers. */
const offeredBy = (page) => page.locator("#start-draft .row");

/** Waits until the page tells why nothing was opened, in these words: those of an earlier refusal may still be there. */
async function refused(page, words) {
  const told = () => page.locator("#not-opened").evaluate((box) => box.innerText.replaceAll(/\s+/g, " "));
  const found = page.waitForFunction((words) => {
    const box = document.getElementById("not-opened");
    return !box.hidden && new RegExp(words).test(box.innerText.replaceAll(/\s+/g, " "));
  }, words.source);
  await found.catch(async (error) => {
    throw new Error(`${error.message}: ${await told()}`);
  });
}

/** The chosen point of a branch. */
const chosen = (page) => page.evaluate(() => [window.wireloom.hands.chosen.branch, `${(1000 * window.wireloom.hands.chosen.s).toFixed(1)} mm`]);

/** Saves under a name; the dialog is open. */
async function saveAs(page, name) {
  await page.waitForSelector("#name-dialog[open]");
  await page.locator("#file-name").fill(name);
  await page.keyboard.press("Enter");
}

test("an example is opened by keyboard, changed, saved under a name, and listed as a recent file", { skip: absent }, async () => {
  const { page, found, at, stop } = await started();
  assert.match(await page.locator("#start").innerText(), new RegExp(`Paths begin in ${at}`));
  const example = page.getByRole("button", { name: "A Y harness is plugged in, one arm after the other" });
  await example.focus();
  await page.keyboard.press("Enter");
  await quiet(page);
  assert.equal(await page.locator("#start").isVisible(), false);
  assert.equal(await page.evaluate(() => window.wireloom.store.session.unsaved), false);
  await page.evaluate(() => window.wireloom.hands.choose({ is: "constraint", name: "plug-B" }));
  await page.keyboard.press("Shift+ArrowUp");
  await page.waitForFunction(() => window.wireloom.store.session.unsaved);
  await quiet(page);

  // It has no file yet: there is one of its name, which is not replaced unasked.
  writeFileSync(join(at, "first.toml"), "mine");
  await page.keyboard.press("Control+s");
  await saveAs(page, "first.toml");
  await page.waitForSelector("#file:not([hidden])");
  assert.match(await page.locator("#file").innerText(), /There is a file first.toml already/);
  assert.equal(readFileSync(join(at, "first.toml"), "utf8"), "mine");
  await page.locator("#file-other").click();
  await saveAs(page, "moved.toml");
  await page.waitForFunction(() => window.wireloom.store.document.name === "moved.toml" && !window.wireloom.store.document.is_new);
  assert.match(readFileSync(join(at, "moved.toml"), "utf8"), /plug-B/);
  // From now on it is its file.
  await page.evaluate(() => window.wireloom.hands.choose({ is: "constraint", name: "plug-B" }));
  const before = readFileSync(join(at, "moved.toml"), "utf8");
  await page.keyboard.press("Shift+ArrowUp");
  await page.waitForFunction(() => window.wireloom.store.session.unsaved);
  await quiet(page);
  await page.keyboard.press("Control+s");
  await page.waitForFunction(() => !window.wireloom.store.session.unsaved);
  assert.notEqual(readFileSync(join(at, "moved.toml"), "utf8"), before);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);

  const again = await started({}, at);
  const recent = again.page.getByRole("list", { name: "Recent files" });
  assert.equal(await recent.getByRole("button").first().innerText(), "moved.toml");
  unlinkSync(join(at, "moved.toml"));
  await again.page.reload();
  await again.page.waitForSelector("#start:not([hidden])");
  assert.match((await recent.locator("li").first().innerText()).replaceAll(/\s+/g, " "), /^moved.toml gone: /);
  assert.equal(await recent.locator("li").first().getByRole("button").count(), 0);
  await again.page.close();
  await again.stop();
});

test("a new harness that nobody saved is offered by the next start page of the folder", { skip: absent }, async () => {
  const first = await started();
  await first.page.getByRole("button", { name: "New harness" }).click();
  await quiet(first.page);
  await first.page.evaluate(() => window.wireloom.hands.choose({ is: "constraint", name: "plug-B" }));
  await first.page.keyboard.press("Shift+ArrowUp");
  await first.page.waitForFunction(() => window.wireloom.store.session.unsaved);
  await quiet(first.page);
  await first.page.waitForFunction(() => window.wireloom.store.document.text.includes("drag plug-B"));
  const text = await first.page.evaluate(() => window.wireloom.store.document.text);
  await first.stop();
  await first.page.waitForFunction(() => document.getElementById("link").textContent === "session ended");
  await first.page.close();

  const second = await started({}, first.at);
  await second.page.getByRole("button", { name: "Restore it" }).click();
  await quiet(second.page);
  assert.equal(await second.page.evaluate(() => window.wireloom.store.document.text), text);
  assert.equal(await second.page.evaluate(() => window.wireloom.store.session.unsaved), true);
  await second.page.locator("#save").click();
  await saveAs(second.page, "mine.toml");
  await second.page.waitForFunction(() => !window.wireloom.store.document.is_new);
  assert.equal(readFileSync(join(first.at, "mine.toml"), "utf8"), text);
  await second.page.close();
  await second.stop();

  const third = await started({}, first.at);
  assert.equal(await third.page.locator("#start-draft").isVisible(), false, "it was saved");
  await third.page.close();
  await third.stop();
});

// Until the offered draft was answered, no other one was kept.
test("every session that nobody saved has a draft of its own, and all of them are offered", { skip: absent }, async () => {
  const at = mkdtempSync(join(folder, "start-"));
  const texts = [];
  for (const steps of [1, 2]) {
    const { page, stop } = await started({}, at);
    await page.getByRole("button", { name: "New harness" }).click();
    await quiet(page);
    // The session offers those before it, too.
    await page.waitForFunction((count) => document.querySelectorAll("#draft .row").length === count, steps - 1);
    await page.evaluate(() => window.wireloom.hands.choose({ is: "constraint", name: "plug-B" }));
    await page.keyboard.press(steps === 1 ? "Shift+ArrowUp" : "Shift+ArrowRight");
    await page.waitForFunction(() => window.wireloom.store.document.text.includes("drag plug-B"));
    await quiet(page);
    texts.push(await page.evaluate(() => window.wireloom.store.document.text));
    await stop();
    await page.close();
  }
  const third = await started({}, at);
  const offered = offeredBy(third.page);
  assert.equal(await offered.count(), 2);
  await settled(third.page);
  await third.page.screenshot({ path: `${shots}start-drafts.png` });
  assert.deepEqual(await axed(third.page), []);
  // The newest first; the other one stays, in the session and behind it.
  await offered.first().getByRole("button", { name: "Restore it" }).click();
  await quiet(third.page);
  assert.equal(await third.page.evaluate(() => window.wireloom.store.document.text), texts[1]);
  await third.page.waitForFunction(() => document.querySelectorAll("#draft .row").length === 1);
  await third.stop();
  await third.page.close();

  const fourth = await started({}, at);
  assert.equal(await offeredBy(fourth.page).count(), 2);
  await offeredBy(fourth.page).first().getByRole("button", { name: "Discard it" }).click();
  await fourth.page.waitForFunction(() => document.querySelectorAll("#start-draft .row").length === 1);
  await offeredBy(fourth.page).getByRole("button", { name: "Restore it" }).click();
  await quiet(fourth.page);
  assert.equal(await fourth.page.evaluate(() => window.wireloom.store.document.text), texts[0]);
  await fourth.stop();
  await fourth.page.close();
});

// What was opened next replaced it at its first change, and to save that deleted it.
test("an unsaved harness that nobody restores or discards stays while another one is changed and saved", { skip: absent }, async () => {
  const change = async (page) => {
    await page.evaluate(() => window.wireloom.hands.choose({ is: "constraint", name: "plug-B" }));
    await page.keyboard.press("Shift+ArrowUp");
    await page.waitForFunction(() => window.wireloom.store.session.unsaved);
    await quiet(page);
    await page.waitForFunction(() => window.wireloom.store.document.text.includes("drag plug-B"));
  };
  const first = await started();
  await first.page.getByRole("button", { name: "New harness" }).click();
  await quiet(first.page);
  await change(first.page);
  const text = await first.page.evaluate(() => window.wireloom.store.document.text);
  await first.stop();
  await first.page.close();

  const second = await started({}, first.at);
  await drop(second.page, "y.kbl", readFileSync(small, "utf8"));
  await second.page.getByRole("button", { name: "Import" }).click();
  await quiet(second.page);
  const offer = second.page.locator("#draft");
  await offer.filter({ hasText: "Unsaved changes of an earlier session" }).waitFor();
  await offer.getByRole("button", { name: "Restore it" }).click();
  await second.page.waitForFunction(() => /which the draft would replace/.test(document.getElementById("messages").textContent));
  await second.page.locator("#save").click();
  await saveAs(second.page, "y.toml");
  await second.page.waitForFunction(() => !window.wireloom.store.document.is_new);
  // It is no draft of that file.
  await offer.waitFor({ state: "hidden" });
  await second.stop();
  await second.page.close();

  const third = await started({}, first.at);
  await third.page.getByRole("button", { name: "New harness" }).click();
  await quiet(third.page);
  await third.page.locator("#draft").getByRole("button", { name: "Restore it" }).click();
  await third.page.waitForFunction((text) => window.wireloom.store.document.text === text, text);
  await third.page.close();
  await third.stop();
});

test("modules of a KBL file are chosen, findings are listed, and their places are flown to", { skip: absent }, async () => {
  const { page, found, at, stop } = await started();
  // Two modules: one has the wire to the right, without which its segment is left out.
  const module = (id, parts) => `<Module id="m-${id}"><Part_number>${id}</Part_number><Module_configuration id="c${id}"><Controlled_components>${parts}</Controlled_components></Module_configuration></Module>`;
  const kbl = readFileSync(small, "utf8").replace("  </Harness>", `    ${module("base", "plugA plugB spliceS clip w1 w4 tape1 c1 c4")}\n    ${module("right", "w2 wc c2 c3")}\n  </Harness>`);
  await drop(page, "y.kbl", kbl);
  await page.waitForSelector("#kbl:not([hidden])");
  assert.deepEqual(await page.locator("#kbl .modules label span:first-of-type").allInnerTexts(), ["base", "right"]);
  await page.getByRole("button", { name: "None" }).click();
  assert.equal(await page.getByRole("button", { name: "Import" }).isDisabled(), true);
  await page.getByRole("checkbox", { name: "base" }).check();
  await page.getByLabel("Longest segment, mm").fill("15");
  await settled(page);
  await page.screenshot({ path: `${shots}start-kbl.png` });
  assert.deepEqual(await axed(page), []);
  await page.getByRole("button", { name: "Import" }).click();
  await quiet(page);
  assert.deepEqual(await page.evaluate(() => window.wireloom.store.scene.branches.map(({ name }) => name)), ["trunk", "left", "stub"]);
  const text = await page.evaluate(() => window.wireloom.store.document.text);
  assert.match(text, /max_segment = "15.0 mm"/);
  assert.equal(await page.evaluate(() => window.wireloom.store.session.unsaved), true, "it is nowhere else");
  const findings = page.locator("#imported");
  assert.match(await findings.innerText(), /segments have no wires of the chosen modules; left out/);
  const place = findings.getByRole("button", { name: /^s2 \(260.0 and 250.0 mm\)/ });
  await place.click();
  assert.deepEqual(await chosen(page), ["left", "130.0 mm"]);
  await findings.getByRole("button", { name: /^n5 \(spliceS S1\)/ }).click();
  assert.deepEqual(await chosen(page), ["stub", "30.0 mm"]);
  await findings.locator("summary", { hasText: "Elements of the file" }).click();
  assert.match((await findings.locator("tr", { hasText: "Segment" }).innerText()).replaceAll(/\s+/g, " "), /^Segment 4 3/);
  await settled(page);
  await page.screenshot({ path: `${shots}start-findings.png` });
  assert.deepEqual(await poorContrast(page), []);

  // Findings stay for a page that comes later.
  await page.reload();
  await quiet(page);
  assert.match(await findings.innerText(), /left out/);
  await page.locator("#save").click();
  await saveAs(page, "y.toml");
  await page.waitForFunction(() => !window.wireloom.store.document.is_new);
  assert.ok(existsSync(join(at, "y.toml")));
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

// They led nowhere.
test("findings that have XML ids alone are flown to", { skip: absent }, async () => {
  const { page, found, stop } = await started();
  await drop(page, "y.kbl", readFileSync(small, "utf8"));
  await page.getByRole("button", { name: "Import" }).click();
  await quiet(page);
  const findings = page.locator("#imported");
  assert.match(await findings.innerText(), /ends carry no component; left free/);
  await findings.getByRole("button", { name: "n4", exact: true }).click();
  assert.deepEqual(await chosen(page), ["right", "250.0 mm"]);
  await findings.getByRole("button", { name: "s4", exact: true }).click();
  assert.deepEqual(await chosen(page), ["stub", "15.0 mm"]);
  assert.deepEqual(found, []);
  await page.close();
  await stop();
});

test("what cannot be opened is told in the page, and the page stays", { skip: absent }, async () => {
  const { page, found, at, stop } = await started();
  await drop(page, "y.toml", "schema = 1\nname = 7\n");
  await refused(page, /y.toml has faults: nothing was opened .*2:8: /);
  assert.equal(await page.evaluate(() => document.activeElement.id), "not-opened");
  await page.screenshot({ path: `${shots}start-refused.png` });
  const mesh = `${readFileSync(join(root, "scenarios/first.toml"), "utf8")}\n[[obstacles]]\nname = "box"\nmesh = "box.stl"\n`;
  await drop(page, "mesh.toml", mesh);
  await refused(page, /open it by its path/);
  writeFileSync(join(at, "tie.so"), "");
  await drop(page, "plugin.toml", `${readFileSync(join(root, "scenarios/first.toml"), "utf8")}\n[plugins]\nload = ["tie.so"]\n`);
  await refused(page, /--allow-plugin/);
  await drop(page, "latin.toml", [0x61, 0xe4]);
  await refused(page, /latin.toml: it is no UTF-8 text/);
  await drop(page, "house.stl", "solid");
  await refused(page, /house.stl: a surface is an obstacle of a scenario/);
  await drop(page, "house.step", "ISO-10303-21;");
  await refused(page, /wireloom import step FILE/);
  await drop(page, "h.vec", "<a/>");
  await refused(page, /wireloom import vec FILE -o NAME.toml/);
  await drop(page, "notes.txt", "hello");
  await refused(page, /notes.txt: a scenario \(.toml\) or a KBL file/);
  await drop(page, "no.kbl", "<a/>");
  await refused(page, /no.kbl cannot be imported/);
  await drop(page, "large.toml", "x".repeat(4 * 1024 * 1024 + 1));
  await refused(page, /large.toml: it has 4194305 bytes/);
  // The program says how large it may be.
  await drop(page, "large.kbl", "x".repeat(16 * 1024 * 1024 + 1));
  await refused(page, /large.kbl: it has 16777217 bytes; a page can be given at most 16777216/);
  for (const [path, why] of [["none.toml", /none.toml/], ["", /no path/], [".", /cannot read/]]) {
    await page.locator("#start-path").fill(path);
    await page.keyboard.press("Enter");
    await refused(page, why);
  }
  assert.deepEqual(await axed(page), []);

  // A valid one is opened by its path all the same, in both pages.
  const other = await newPage(browser);
  await other.goto(page.url());
  await other.waitForSelector("#start:not([hidden])");
  const file = scenario("branches/y_cosserat.toml");
  await page.locator("#start-path").fill(file);
  await page.getByRole("button", { name: "Open", exact: true }).click();
  await quiet(page);
  await quiet(other);
  assert.equal(await other.evaluate(() => window.wireloom.store.document.name), basename(file));
  assert.equal(await page.evaluate(() => window.wireloom.store.document.is_new), false);
  assert.deepEqual(found, []);
  await other.close();
  await page.close();
  assert.equal(await stop(), 0);
});

test("the folder of a finished run is opened by its path, and plays", { skip: absent }, async () => {
  const { page, found, at, stop } = await started();
  const run = spawnSync(program, ["run", join(root, "scenarios/first.toml"), "--out", join(at, "out"), "--quiet"], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stdout + run.stderr);
  await page.locator("#start-path").fill("out");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => window.wireloom?.store.shown && window.wireloom.store.shown.header.frame === window.wireloom.store.newest());
  assert.equal(await page.locator("#link").innerText(), "finished run");
  assert.equal(await page.locator("#start").isVisible(), false);
  assert.deepEqual(found, []);
  await page.close();
  assert.equal(await stop(), 0);
});

// The page took the end of the name for that of a file of another kind, also in its own list.
test("a run whose folder has a dot in its name is opened by its path and from the recent files", { skip: absent }, async () => {
  const first = await started();
  const run = spawnSync(program, ["run", join(root, "scenarios/first.toml"), "--out", join(first.at, "out/first.v2"), "--quiet"], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stdout + run.stderr);
  const plays = async (page) => {
    await page.waitForFunction(() => window.wireloom?.store.shown && window.wireloom.store.shown.header.frame === window.wireloom.store.newest());
    assert.equal(await page.locator("#link").innerText(), "finished run");
  };
  await first.page.locator("#start-path").fill("notes.txt");
  await first.page.keyboard.press("Enter");
  await refused(first.page, /cannot read .*notes.txt/);
  await first.page.locator("#start-path").fill("out/first.v2");
  await first.page.keyboard.press("Enter");
  await plays(first.page);
  await first.page.close();
  await first.stop();

  const second = await started({}, first.at);
  await second.page.getByRole("list", { name: "Recent files" }).getByRole("button", { name: "first.v2" }).click();
  await plays(second.page);
  await second.page.close();
  await second.stop();
});

test("the start page is read by light and in the dark, in narrow windows, and says when its program is gone", { skip: absent }, async () => {
  for (const [name, options] of [
    ["light", { colorScheme: "light" }],
    ["dark", { colorScheme: "dark" }],
    ["narrow", { viewport: { width: 1024, height: 700 } }],
  ]) {
    const { page, found, stop } = await started(options);
    await settled(page);
    await page.screenshot({ path: `${shots}start-${name}.png` });
    assert.deepEqual(await axed(page), [], name);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > window.innerWidth), false, name);
    await stop();
    await page.waitForFunction(() => document.getElementById("start-status").textContent.startsWith("The program has ended"));
    assert.equal(await page.evaluate(() => document.querySelector(".start-body").inert), true);
    assert.deepEqual(found, []);
    await page.close();
  }
});
