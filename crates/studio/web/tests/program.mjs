// The program behind a page: studios that are started and ended, scenarios of their own. WIRELOOM names the program (else
// target/debug/wireloom).
import { spawn } from "node:child_process";
import { copyFileSync, existsSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { faults, newPage, settled } from "./browser.mjs";

export const root = fileURLToPath(new URL("../../../../", import.meta.url));
export const program = process.env.WIRELOOM ?? join(root, "target/debug/wireloom");
export const absent = existsSync(program) ? false : `${program} is not there: cargo build -p wireloom-cli`;

/** A folder of this test program alone. */
export const folder = mkdtempSync(join(tmpdir(), "wireloom-studio-"));
const running = new Set();
export const environment = () => ({ ...process.env, XDG_STATE_HOME: join(folder, "state"), LOCALAPPDATA: join(folder, "state") });

/** Ends all studios that still run. */
export function endAll() {
  for (const child of running) child.kill("SIGKILL");
}

/** A copy of a scenario, so that what is remembered of it is of this test alone. */
export function scenario(name) {
  const file = join(mkdtempSync(join(folder, "scenario-")), name.split("/").pop());
  copyFileSync(join(root, "scenarios", name), file);
  return file;
}

/** Starts a studio; resolves with its address and what ends it. */
export const studio = (what, ...more) => started([what, ...more]);

/** Starts one with its start page, in a folder. */
export const startPage = (folder) => started([], folder);

function started(what, cwd) {
  const child = spawn(program, ["studio", "--no-open", ...what], { cwd, env: environment(), stdio: ["ignore", "pipe", "pipe"] });
  running.add(child);
  const ended = new Promise((resolve) => child.on("exit", (code) => (running.delete(child), resolve(code))));
  return new Promise((resolve, reject) => {
    let said = "";
    const hear = (chunk) => {
      said += chunk;
      const address = said.match(/http:\/\/\S+/)?.[0];
      if (address) resolve({ address, stop: () => (child.kill("SIGINT"), ended), kill: () => (child.kill("SIGKILL"), ended) });
    };
    child.stdout.on("data", hear);
    child.stderr.on("data", hear);
    ended.then((code) => reject(new Error(`studio ended with ${code}: ${said}`)));
  });
}

/** Opens a page on a studio, and waits until all is computed. */
export async function open(browser, address, options = {}) {
  const page = await newPage(browser, options);
  const found = faults(page);
  await page.goto(address);
  await quiet(page);
  return { page, found };
}

/** How often a test has waited for quiet. */
let waits = 0;

/**
 * Waits until all that the page has asked for is done, nothing is computed, and all that there is has come and is drawn.
 * A session carries out one request after the other: when it has refused to store a file under a name that is none, it
 * has done all that was asked for before. (That it is not busy does not say so: a drag goes on after it is let go.)
 */
export async function quiet(page) {
  await page.waitForFunction(
    (wait) => {
      const { store, hands } = window.wireloom;
      if (!store.session) return false;
      window.asked ??= listen();
      const { asked } = window;
      const name = `${wait}, ${asked.sent}/`;
      if (asked.answered !== name) {
        // Again after a while: the session that was asked may have been replaced by another one.
        if (asked.name !== name || performance.now() - asked.at > 1000) asked.ask(name);
        return false;
      }
      const newest = store.newest();
      const shown = store.timeline.frames > 0 && store.has(newest) && store.shown?.header.frame === newest;
      return shown && store.following && store.session.busy === null && !hands.dragging;

      /** Counts the page's requests to the session, and keeps the answers to those of this function from the page. */
      function listen() {
        const { link } = hands;
        const send = link.send.bind(link);
        const take = store.take.bind(store);
        const asked = { sent: 0, name: "", at: 0, answered: "" };
        asked.ask = (name) => {
          [asked.name, asked.at] = [name, performance.now()];
          send({ do: "store", name, replace: false });
        };
        link.send = (request) => {
          if (request.do !== "frames" && request.do !== "check") asked.sent++;
          send(request);
        };
        store.take = (notice) => {
          const answer = notice.is === "refused" && notice.message.match(/^"(\d+, \d+\/)" is no name for the file/);
          if (answer) asked.answered = answer[1];
          else take(notice);
        };
        return asked;
      }
    },
    ++waits,
    { timeout: 120_000, polling: 50 },
  );
  await settled(page);
}

/** The text of the session. */
export const sessionText = (page) => page.evaluate(() => window.wireloom.store.document.text);

/** Does something that changes the text of the session, and waits until that is computed. */
export async function changing(page, act) {
  const { version } = await page.evaluate(() => window.wireloom.store.document);
  await act();
  await page.waitForFunction((version) => window.wireloom.store.document.version > version, version, { timeout: 60_000 }).catch(async (error) => {
    throw new Error(`${error.message}: ${await page.locator("#messages").innerText()} ${await page.locator("#surroundings").innerText()}`);
  });
  await quiet(page);
}
