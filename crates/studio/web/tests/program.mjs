// The program behind a page: studios that are started and ended, scenarios of their own. WIRELOOM names the program (else
// target/debug/wireloom).
import { spawn } from "node:child_process";
import { copyFileSync, existsSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { faults } from "./browser.mjs";

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
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, ...options });
  const found = faults(page);
  await page.goto(address);
  await quiet(page);
  return { page, found };
}

/** Waits until nothing is computed and all that there is has come. */
export async function quiet(page) {
  await page.waitForFunction(
    () => {
      const { store, hands } = window.wireloom;
      const newest = store.newest();
      return store.session && store.session.busy === null && !hands.dragging && store.timeline.frames > 0 && store.shown?.header.frame === newest && store.following;
    },
    null,
    { timeout: 60_000, polling: 50 },
  );
}

/** The text of the session. */
export const sessionText = (page) => page.evaluate(() => window.wireloom.store.document.text);

/** Does something that changes the text of the session, and waits until that is computed. */
export async function changing(page, act) {
  const { version } = await page.evaluate(() => window.wireloom.store.document);
  await act();
  await page.waitForFunction((version) => window.wireloom.store.document.version > version, version, { timeout: 30_000 }).catch(async (error) => {
    throw new Error(`${error.message}: ${await page.locator("#messages").innerText()} ${await page.locator("#surroundings").innerText()}`);
  });
  await quiet(page);
}
