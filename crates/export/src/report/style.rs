//! Style sheet and script of the pages.

/// Style sheet, for screen and paper.
pub const SHEET: &str = "
:root { color-scheme: light; }
body { font: 15px/1.45 Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif; color: #1a1a1a;
  max-width: 75rem; margin: 1.5rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; margin: 0 0 .3rem; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; border-bottom: 1px solid #bbb; }
header p { margin: .15rem 0; color: #444; overflow-wrap: anywhere; }
nav a { margin-right: .8rem; }
.good { color: #14632b; } .bad, .trouble td { color: #8b0019; }
.signs { display: flex; gap: .8rem; flex-wrap: wrap; margin: .6rem 0; }
.sign { flex: 1 1 12rem; margin: 0; padding: .5rem .9rem; border-left: .5rem solid; }
.sign.verdict { flex: 3 1 24rem; color: #fff; }
.sign small, .sign strong { display: block; } .sign strong { font-size: 1.5rem; line-height: 1.25; }
.sign.status { background: #f1f1f1; color: #1a1a1a; }
.sign.status strong { font-size: 1.2rem; }
header .sign.verdict { color: #fff; }
.verdict.pass, .mark.pass { background: #14632b; } .verdict.fail, .mark.fail { background: #8b0019; }
.verdict.unresolved, .mark.unresolved { background: #8a5200; } .mark.unchecked { background: #666; }
.verdict { border-color: rgb(0 0 0 / .25); } .status.pass { border-color: #14632b; }
.status.fail { border-color: #8b0019; } .status.fail strong { color: #8b0019; }
.mark { display: inline-block; color: #fff; padding: 0 .45em; border-radius: .2em; white-space: nowrap; }
.sheet td:nth-child(3), .sheet td:last-child { white-space: nowrap; }
.sheet tr.fail td { color: #8b0019; } .sheet tr.unresolved td { color: #8a5200; }
section { overflow-x: auto; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; margin: .4rem 0; }
th, td { text-align: left; padding: .15rem .9rem .15rem 0; vertical-align: top; overflow-wrap: break-word; }
th { border-bottom: 1px solid #888; font-weight: 600; white-space: nowrap; }
.n { text-align: right; white-space: nowrap; }
tbody tr:nth-child(even) { background: #f4f4f4; }
details { margin: .3rem 0; } summary { cursor: pointer; font-weight: 600; overflow-wrap: anywhere; }
img { width: 100%; height: auto; border: 1px solid #ddd; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 1rem; }
figure { margin: .3rem 0; } figure svg { width: 100%; height: auto; } figcaption { font-size: .85rem; color: #444; }
.cross-sections { display: flex; flex-wrap: wrap; gap: 1.4rem; align-items: flex-end; }
.last { color: #1f5fa8; } .other { color: #c46a00; } .limit { color: #8b0019; }
.last::before, .other::before, .limit::before { content: '— '; }
pre { font-size: .78rem; line-height: 1.35; white-space: pre-wrap; overflow-wrap: anywhere;
  background: #f7f7f7; padding: .6rem; }
@page { size: A4; margin: 14mm; }
@media print {
  .sign, .mark { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  body { max-width: none; margin: 0; padding: 0; font-size: 9.5pt; }
  nav { display: none; } section { overflow: visible; }
  table { font-size: 7.5pt; } th { white-space: normal; } th, td { padding-right: .5em; }
  thead { display: table-header-group; }
  img { width: 92%; } tr, figure, img { break-inside: avoid; } h2, summary { break-after: avoid; }
  #scenario { break-before: page; }
  .plots { grid-template-columns: 1fr 1fr; } pre { background: none; padding: 0; font-size: 7pt; }
  details::details-content { content-visibility: visible; display: block; } a { color: inherit; text-decoration: none; }
}
";

/// Script: unfolds sections for printing, and the target of a link.
pub const UNFOLD: &str = "
let folded = [];
addEventListener('beforeprint', () => {
  folded = [...document.querySelectorAll('details:not([open])')];
  folded.forEach(d => d.open = true);
});
addEventListener('afterprint', () => folded.forEach(d => d.open = false));
addEventListener('hashchange', () => {
  const name = location.hash.slice(1);
  const d = document.querySelector('#' + (CSS.escape ? CSS.escape(name) : name));
  if (d && d.tagName === 'DETAILS') d.open = true;
});
";
