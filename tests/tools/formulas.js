// Checks every formula of the documents with KaTeX, which refuses TeX that it does not know.
//
//   node tests/tools/formulas.js KATEX FILE.md...
//
// KATEX is the folder of the Node.js module.
//
// A formula stands between dollar signs, or in a block that begins with ```math. Markdown reads a line before TeX
// does: between dollar signs a backslash before a punctuation mark is lost, and in a table a bar ends the cell.
// Prints a line for each fault; the exit status is then 1.
'use strict';
const fs = require('fs');

const katex = require(process.argv[2]);
let formulas = 0, faults = 0;

function fault(place, what) {
  console.log(`${place}: ${what}`);
  faults += 1;
}

function check(place, tex, displayMode) {
  formulas += 1;
  try {
    katex.renderToString(tex, {displayMode, throwOnError: true, strict: 'error'});
  } catch (error) {
    fault(place, error.message.split('\n')[0]);
  }
}

function checkInline(place, line) {
  const text = line.replace(/`[^`]*`/g, '');
  const pieces = text.split('$');
  if (pieces.length % 2 === 0) return fault(place, 'a dollar sign without its other one');
  for (let i = 1; i < pieces.length; i += 2) {
    const tex = pieces[i];
    if (tex.trim() !== tex || tex === '') fault(place, `$${tex}$: a blank beside its dollar sign`);
    if (/\\[!-/:-@[-`{-~]/.test(tex)) fault(place, `$${tex}$: Markdown takes the backslash before the punctuation mark`);
    if (line.startsWith('|') && tex.includes('|')) fault(place, `$${tex}$: the bar ends the cell`);
    check(place, tex, false);
  }
}

for (const file of process.argv.slice(3)) {
  let fence = null, block = [];
  fs.readFileSync(file, 'utf8').split('\n').forEach((line, i) => {
    const place = `${file}:${i + 1}`;
    if (fence === null && line.startsWith('```')) {
      fence = line.slice(3);
      block = [];
    } else if (fence !== null && line === '```') {
      if (fence === 'math') check(place, block.join('\n'), true);
      fence = null;
    } else if (fence !== null) {
      block.push(line);
    } else if (!line.startsWith('    ') && !line.startsWith('<!--')) {
      checkInline(place, line);
    }
  });
  if (fence !== null) fault(file, 'a block without an end');
}
console.log(`${formulas} formulas, ${faults} faults`);
process.exit(faults === 0 && formulas > 0 ? 0 : 1);
