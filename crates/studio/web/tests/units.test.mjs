// Numbers in words: significant digits, units, and no round-off.
import assert from "node:assert/strict";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const entry = fileURLToPath(new URL("../src/units.ts", import.meta.url));
const { outputFiles } = await build({ entryPoints: [entry], bundle: true, write: false, format: "esm", charset: "utf8" });
const { components, digits, percent, quantity, residual } = await import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);

test("round-off is 0, whatever the unit", () => {
  for (const unit of ["m", "N", "N m", "J", "rad/m", "turns", ""]) {
    for (const value of [5.91e-17, -5.91e-17, 1e-9, 0]) assert.match(quantity(value, unit), /^0( |$)/, `${value} ${unit}`);
  }
  assert.equal(quantity(0, "m"), "0 mm");
  assert.equal(components([1.5, 5.91e-17, -0.42], "N"), "(1.50, 0, −0.42) N");
  assert.equal(components([5.91e-17, 0, -1e-12], "N m"), "(0, 0, 0) N mm");
  assert.equal(components([0.6, -1e-9, -0.0721], "m", 4), "(600.0, 0, −72.1) mm");
});

test("numbers have as many digits as one reads, and never an exponent", () => {
  assert.equal(quantity(0.0331415, "m"), "33.1 mm");
  assert.equal(quantity(-0.0126, "m"), "−12.6 mm");
  assert.equal(quantity(12.345, "m"), "12.3 m");
  assert.equal(quantity(11873.6, "N"), "11\u2009874 N");
  assert.equal(quantity(1234.5, "N"), "1235 N");
  assert.equal(quantity(-3.2e7, "N"), "−32\u2009000\u2009000 N");
  assert.equal(quantity(0.0123, "N m"), "12.3 N mm");
  assert.equal(quantity(0.03, "J", 4), "30.00 mJ");
  assert.equal(quantity(2e-4, "N"), "0.000200 N");
  assert.equal(digits(1.005, 3), "1.00");
  assert.equal(quantity(Infinity, "m"), "∞ m");
  assert.equal(quantity(NaN, "N"), "– N");
  assert.equal(percent(-0.933), "−93.3 %");
  assert.equal(percent(0.01), "+1.0 %");
  assert.equal(percent(0), "0 %");
  assert.equal(residual(3e-9), "10⁻⁸");
  for (const unit of ["m", "N", "N m", "J", "s", "rad/m", "turns", ""]) {
    for (let power = -20; power <= 12; power++) assert.doesNotMatch(quantity(1.7 * 10 ** power, unit), /e/i, `1e${power} ${unit}`);
  }
});
