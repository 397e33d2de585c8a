// The pages of the book: node pages_test.js PAGES.js SOURCE OUT makes them, and reads each as a browser would:
// every link and anchor has its target, every picture its words, every formula its MathML, and nothing is asked
// of another place.
'use strict';
const {spawnSync} = require('child_process');
const fs = require('fs');
const path = require('path');

const [maker, source, out] = process.argv.slice(2);
const all = (folder) => fs.readdirSync(folder, {withFileTypes: true}).flatMap((entry) =>
  entry.isDirectory() ? all(path.join(folder, entry.name)) : [path.join(folder, entry.name)]);
if (fs.existsSync(out)) all(out).filter((file) => file.endsWith('.html')).forEach((file) => fs.rmSync(file));
const made = spawnSync(process.execPath, [maker, source, out], {encoding: 'utf8'});
process.stdout.write(made.stdout + made.stderr);
let faults = Number(made.status !== 0), links = 0, formulas = 0;
const fault = (text) => { console.log(text); faults += 1; };

const pages = all(out).filter((file) => file.endsWith('.html'));
const text = Object.fromEntries(pages.map((file) => [file, fs.readFileSync(file, 'utf8')]));
// The tags alone: code on a page may speak of links too.
const tags = Object.fromEntries(pages.map((file) => [file, text[file].match(/<[a-z][^>]*>/g).join('')]));
const ids = Object.fromEntries(pages.map((file) => [file, new Set([...tags[file].matchAll(/ id="([^"]*)"/g)].map(([, id]) => id))]));
const count = (html, pattern) => (html.match(pattern) || []).length;

for (const file of pages) {
  const html = tags[file], name = path.relative(out, file);
  for (const [, kind, target] of html.matchAll(/ (href|src)="([^"]*)"/g)) {
    if (target === 'data:,' || kind === 'href' && /^https?:/.test(target)) continue;
    links += 1;
    const [place, anchor] = target.replace(/\?[^#]*/, '').split('#');
    let there = place ? path.join(path.dirname(file), decodeURI(place)) : file;
    if (/^[a-z]+:/.test(place)) fault(`${name}: asks another place for ${target}`);
    else if (!fs.existsSync(there) || fs.statSync(there).isDirectory()) fault(`${name}: no ${target}`);
    else if (anchor && !(ids[there] && ids[there].has(anchor))) fault(`${name}: no heading ${target}`);
  }
  if (ids[file].size !== count(html, / id="/g)) fault(`${name}: two with one id`);
  if (count(html, /<h1/g) !== 1) fault(`${name}: ${count(html, /<h1/g)} titles`);
  if (/<img(?![^>]* alt="[^"]+)/.test(html)) fault(`${name}: a picture without words`);
  if (/<img(?![^>]* width="\d+")/.test(html)) fault(`${name}: a picture without its size`);
  if (count(html, /<math /g) !== count(html, /class="katex"/g)) fault(`${name}: a formula without MathML`);
  if (/katex-error/.test(html)) fault(`${name}: a formula that KaTeX refuses`);
  formulas += count(html, /<math /g);
}
for (const file of all(out).filter((one) => one.endsWith('.css')))
  for (const [, target] of fs.readFileSync(file, 'utf8').matchAll(/url\(([^)]*)\)/g))
    if (!fs.existsSync(path.join(path.dirname(file), target))) fault(`${file}: no ${target}`);

// Formulas counted another way, as tests/tools/formulas.js reads them.
let wanted = 0;
for (const file of all(path.join(source, 'docs')).concat(all(path.join(source, 'chapters')), path.join(source, 'README.md'))) {
  if (!file.endsWith('.md') || !text[path.join(out, path.relative(source, file)).replace(/README\.md$/, 'index.html').replace(/\.md$/, '.html')]) continue;
  let code = false;
  for (const line of fs.readFileSync(file, 'utf8').split('\n')) {
    if (line.startsWith('```')) { wanted += line === '```math'; code = !code; }
    else if (!code && !line.startsWith('    ') && !line.startsWith('<!--')) wanted += line.replace(/`[^`]*`/g, '').split('$').length >> 1;
  }
}
if (formulas !== wanted) fault(`${formulas} formulas on the pages, ${wanted} in the documents`);
console.log(`${pages.length} pages, ${links} links, ${formulas} formulas, ${faults} faults`);
process.exit(faults || pages.length < 10 ? 1 : 0);
